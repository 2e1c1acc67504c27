//! Slaves, masters and tools on one bus.

use devicenet_cli::simulate::Outcome;

use crate::{trace, traced_text};

trace!(
    every_kind_of_io,
    "exchange", "each slave is brought up, its data go both ways, and idle rests the outputs"
);
trace!(
    a_slave_is_cut_off,
    "slave-lost", "time-out after four packet rates, back-off, and the slave's check ends it"
);
trace!(a_master_loses_its_power, "master-lost", "the slave times out, and the master takes it again");
trace!(
    a_device_is_replaced,
    "replacement", "the wrong device is refused, the right one gets MAC ID and configuration"
);
trace!(
    a_tool_recovers,
    "offline-tool", "ownership, Who, Identify, Change_MAC_ID, and a rival that gives way"
);
trace!(
    the_owner_of_an_offline_recovery_dies,
    "offline-owner-lost", "two claims in the same bit, one owner, whose silence gives the set to the other"
);
trace!(a_scan_list_that_is_wrong, "wrong-devices", "scanner status 73, 77, 78 and 83");
trace!(a_bit_rate_is_detected, "auto-bit-rate", "the slave listens, finds 500 kbit/s, and is brought up");

/// A master and a slave; the I/O runs at 2.1 s. Fourteen seconds.
const PAIR: &str = r#"
[bus]
duration = "14s"
[[node]]
name = "scanner"
protocol = "devicenet"
role = "master"
mac = 1
interscan_delay = "20ms"
identity = { vendor = 0x1234, serial = 1 }
[[node.scan]]
mac = 10
poll = { produce = 2, consume = 1 }
epr = "100ms"
output = "AA"
[[node]]
name = "valve"
protocol = "devicenet"
role = "slave"
mac = 10
input = "0102"
poll = { produce = 2, consume = 1 }
identity = { vendor = 0x1234, serial = 10 }
"#;

#[track_caller]
fn holds(text: &str) -> (String, Outcome) {
    let (trace, outcome) = traced_text("pair", text);
    assert!(outcome.verdict.held > 0, "nothing is expected");
    (trace, outcome)
}

#[test]
fn inputs_and_outputs_are_set() {
    let more = r#"
        [[action]]
        at = "4s"
        node = "valve"
        do = "set_input"
        value = "0304"
        [[action]]
        at = "4s"
        node = "scanner"
        do = "set_output"
        value = "BB"
        [[expect]]
        from = "4s"
        to = "4.1s"
        node = "scanner"
        slave = 10
        event = "input_changed"
        input = "0304"
        [[expect]]
        from = "4s"
        to = "4.1s"
        node = "valve"
        connection = "poll"
        event = "output_changed"
        output = "BB"
        [[expect]]
        at = "3.9s"
        node = "valve"
        output = "AA""#;
    let (trace, _) = holds(&format!("{PAIR}{more}"));
    assert!(
        trace.contains("| input data 03 04\n") && trace.contains("| output data for 10: BB\n"),
        "{trace}"
    );
}

/// What is at the sensors does not depend on power; the outputs do.
#[test]
fn an_input_that_is_set_without_power_is_there_at_power_up() {
    let more = r#"
        [[action]]
        at = "4s"
        node = "valve"
        do = "power_off"
        [[action]]
        at = "4.5s"
        node = "valve"
        do = "set_input"
        value = "0506"
        [[action]]
        at = "5s"
        node = "valve"
        do = "power_on"
        [[expect]]
        at = "4.9s"
        node = "valve"
        connection = "poll"
        connection_state = "non_existent"
        mode = "inactive"
        output = "00"
        input = "0506"
        [[expect]]
        at = "14s"
        node = "scanner"
        slave = "valve"
        input = "0506""#;
    let (trace, _) = holds(&format!("{PAIR}{more}"));
    assert!(trace.contains("| input data 05 06, which is read at power-up\n"), "{trace}");
}

#[test]
fn idle_and_run() {
    let more = r#"
        [[action]]
        at = "4s"
        node = "scanner"
        do = "go_idle"
        [[action]]
        at = "5s"
        node = "scanner"
        do = "go_run"
        [[expect]]
        from = "4.1s"
        to = "5s"
        always = true
        node = "valve"
        mode = "idle"
        output = "00"
        [[expect]]
        at = "4.1s"
        node = "scanner"
        status = 80
        [[expect]]
        at = "5.1s"
        node = "valve"
        mode = "run"
        output = "AA""#;
    holds(&format!("{PAIR}{more}"));
}

#[test]
fn a_master_that_begins_idle() {
    let idle = PAIR.replacen("interscan_delay", "run = false\ninterscan_delay", 1);
    holds(&format!(
        "{idle}[[expect]]\nat = \"4s\"\nnode = \"valve\"\nmode = \"idle\"\nconnection = \"poll\"\nconnection_state = \"established\""
    ));
}

#[test]
fn a_slave_and_a_master_are_reset() {
    let reset =
        |node: &str, at: &str| format!("[[action]]\nat = \"{at}\"\nnode = \"{node}\"\ndo = \"reset\"\n");
    let more = r#"
        [[expect]]
        from = "4s"
        to = "4s"
        node = "valve"
        state = "sending_dup_mac"
        [[expect]]
        from = "4s"
        to = "10s"
        node = "scanner"
        event = "established"
        slave = "valve"
        [[expect]]
        from = "11s"
        to = "11s"
        node = "scanner"
        state = "sending_dup_mac""#;
    holds(&format!("{PAIR}{}{}{more}", reset("valve", "4s"), reset("scanner", "11s")));
}

#[test]
fn switches_are_turned() {
    let more = r#"
        [[action]]
        at = "3s"
        node = "valve"
        do = "set_mac"
        value = 11
        [[action]]
        at = "3s"
        node = "scanner"
        do = "set_mac"
        value = 2
        [[action]]
        at = "6s"
        node = "valve"
        do = "power_cycle"
        [[expect]]
        at = "9s"
        node = "valve"
        state = "online""#;
    let (_, outcome) = holds(&format!("{PAIR}{more}"));
    let macs: Vec<Option<u8>> = outcome.summary.nodes.iter().map(|node| node.mac).collect();
    assert_eq!(macs, [Some(2), Some(11)]);
}

#[test]
fn what_needs_power_has_no_effect_without_it() {
    let action = |what: &str| format!("[[action]]\nat = \"4s\"\nnode = \"scanner\"\ndo = \"{what}\"\n");
    let set = "[[action]]\nat = \"4s\"\nnode = \"scanner\"\ndo = \"set_output\"\nvalue = \"BB\"\n";
    let more = format!(
        "{}{}{set}[[expect]]\nat = \"5s\"\nnode = \"scanner\"\nstate = \"nonexistent\"",
        action("power_off"),
        action("go_idle")
    );
    let (trace, _) = holds(&format!("{PAIR}{more}"));
    for what in ["go_idle", "set_output"] {
        assert!(trace.contains(&format!("| the action {what} has no effect: no power\n")), "{trace}");
    }
}

/// The figures of a master are those of its slaves, and of its scan.
#[test]
fn the_summary_of_a_master() {
    let (_, outcome) = holds(&format!("{PAIR}[[expect]]\nat = \"9s\"\nnode = \"valve\"\nmode = \"run\""));
    let scan = outcome.summary.nodes[0].scan.as_ref().expect("a master");
    let slave = &scan.slaves[0];
    assert_eq!((slave.mac, slave.state.name(), slave.status.0), (10, "running", 0));
    assert_eq!((slave.counters.established, slave.counters.timeouts, slave.counters.missed), (1, 0, 0));
    assert!(slave.counters.commands >= slave.counters.received && slave.counters.received > 300, "{slave:?}");
    // Interscan delay and the command before it: 20 ms and 56 bits.
    assert!(
        scan.min >= 0.020_4 && scan.mean >= scan.min && scan.max >= scan.mean && scan.max < 0.022,
        "{scan:?}"
    );
    let counters = outcome.summary.nodes[1].slave.expect("a slave");
    assert_eq!(counters.consumed, slave.counters.commands);
    assert!(outcome.summary.nodes[1].scan.is_none());
}

/// A slave whose MAC ID comes from switches is not given another by the network.
#[test]
fn switches_cannot_be_set_over_the_network() {
    let fixed = PAIR.replacen("input = \"0102\"", "input = \"0102\"\nswitches = true", 1).replacen(
        "output = \"AA\"",
        "configuration = [{ class = 3, instance = 1, attribute = 1, value = \"0b\" }]",
        1,
    );
    holds(&format!("{fixed}[[expect]]\nat = \"9s\"\nnode = \"scanner\"\nslave = 10\nstatus = 89"));
}

#[test]
fn a_configuration_is_written_before_the_io_starts() {
    let written = PAIR.replacen(
        "output = \"AA\"",
        "configuration = [{ class = 4, instance = 199, attribute = 3, value = \"000102030405060708090a0b0c0d0e0f\" }]",
        1,
    );
    let (trace, _) = holds(&format!(
        "{written}[[expect]]\nat = \"4s\"\nnode = \"scanner\"\nslave = 10\nslave_state = \"running\""
    ));
    assert!(trace.contains("Set_Attribute_Single Assembly 199"), "{trace}");
}

/// I/O frames are told when they say something new; all others are counted.
#[test]
fn frames_that_say_nothing_new_are_counted() {
    let more = "[[action]]\nat = \"4s\"\nnode = \"valve\"\ndo = \"set_input\"\nvalue = \"0304\"\n\
                [[expect]]\nat = \"9s\"\nnode = \"valve\"\nmode = \"run\"";
    let (trace, outcome) = holds(&format!("{PAIR}{more}"));
    let told = trace.lines().filter(|line| line.contains("poll 10 -> 1")).count();
    assert_eq!(told, 2, "{trace}");
    let counted: u64 = (trace.lines().filter(|line| line.contains("with the same data as before")))
        .filter_map(|line| line.split("| ").nth(1)?.split(' ').next()?.parse::<u64>().ok())
        .sum();
    let slave = &outcome.summary.nodes[0].scan.as_ref().expect("a master").slaves[0];
    assert_eq!(counted, u64::from(slave.counters.commands + slave.counters.received) - 3);
}
