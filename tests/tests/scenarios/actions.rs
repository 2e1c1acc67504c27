//! Every action of a scenario does what it says.

use crate::{holds, traced};

#[test]
fn cut_and_plug() {
    holds(
        r#"
        [[action]]
        at = "3s"
        node = "valve"
        do = "cut"
        [[action]]
        at = "4s"
        node = "valve"
        do = "plug"
        [[expect]]
        always = true
        from = "3s"
        to = "3.999s"
        node = "valve"
        state = "nonexistent"
        [[expect]]
        from = "4s"
        to = "4.01s"
        node = "valve"
        state = "sending_dup_mac"
        [[expect]]
        at = "7s"
        node = "valve"
        state = "online""#,
    );
}

#[test]
fn power_off_on_and_cycle() {
    holds(
        r#"
        [[action]]
        at = "3s"
        node = "valve"
        do = "power_off"
        [[action]]
        at = "4s"
        node = "valve"
        do = "power_on"
        [[action]]
        at = "3s"
        node = "scanner"
        do = "power_cycle"
        [[expect]]
        always = true
        from = "3s"
        to = "3.999s"
        node = "valve"
        state = "nonexistent"
        [[expect]]
        at = "7s"
        node = "valve"
        state = "online"
        [[expect]]
        at = "3s"
        node = "scanner"
        state = "sending_dup_mac""#,
    );
}

#[test]
fn a_mac_id_that_was_set_outlives_a_power_cycle() {
    let outcome = holds(
        r#"
        [[action]]
        at = "3s"
        node = "valve"
        do = "set_mac"
        value = 11
        [[action]]
        at = "6s"
        node = "valve"
        do = "power_cycle"
        [[expect]]
        at = "3s"
        node = "valve"
        state = "sending_dup_mac"
        [[expect]]
        at = "5.5s"
        node = "valve"
        state = "online"
        [[expect]]
        at = "9s"
        node = "valve"
        state = "online""#,
    );
    assert_eq!(outcome.summary.nodes[0].mac, Some(11));
}

#[test]
fn reset_begins_anew() {
    holds(
        r#"
        [[action]]
        at = "3s"
        node = "valve"
        do = "reset"
        [[expect]]
        at = "2.999s"
        node = "valve"
        state = "online"
        [[expect]]
        at = "3s"
        node = "valve"
        state = "sending_dup_mac"
        [[expect]]
        at = "5.1s"
        node = "valve"
        state = "online""#,
    );
}

#[test]
fn a_bit_rate_that_was_set_outlives_a_power_cycle() {
    holds(
        r#"
        [[action]]
        at = "3s"
        node = "valve"
        do = "set_bit_rate"
        value = 250_000
        [[action]]
        at = "4s"
        node = "valve"
        do = "power_cycle"
        [[expect]]
        from = "4s"
        never = true
        node = "valve"
        state = "online""#,
    );
}

/// A switch is turned while the node is off: it is on line with the new MAC ID two seconds after it gets power.
#[test]
fn a_mac_id_that_is_set_without_power_is_read_at_power_up() {
    let (trace, outcome) = traced(
        r#"
        [[action]]
        at = "3s"
        node = "valve"
        do = "power_off"
        [[action]]
        at = "4s"
        node = "valve"
        do = "set_mac"
        value = 11
        [[action]]
        at = "5s"
        node = "valve"
        do = "power_on"
        [[expect]]
        always = true
        from = "3s"
        to = "4.999s"
        node = "valve"
        state = "nonexistent"
        [[expect]]
        at = "8s"
        node = "valve"
        state = "online""#,
    );
    assert_eq!(outcome.summary.nodes[0].mac, Some(11));
    assert!(trace.contains("| MAC ID switch set to 11, which is read at power-up\n"), "{trace}");
    assert!(trace.contains("dup MAC 11 request"), "{trace}");
}

/// The order of the file is the order of what is done at one moment, and so is what is told of it.
#[test]
fn a_mac_id_that_is_set_at_the_moment_of_power_up() {
    let action =
        |at: &str, what: &str| format!("[[action]]\nat = \"{at}\"\nnode = \"valve\"\ndo = \"{what}\"\n");
    let off = action("3s", "power_off");
    let on = action("4s", "power_on");
    let set = action("4s", "set_mac") + "value = 11\n";
    for (more, told) in [
        (format!("{off}{on}{set}"), "| MAC ID switch set to 11\n"),
        (format!("{off}{set}{on}"), "| MAC ID switch set to 11, which is read at power-up\n"),
    ] {
        let (trace, outcome) = traced(&more);
        assert_eq!(outcome.summary.nodes[0].mac, Some(11), "{trace}");
        assert!(trace.contains(told), "{trace}");
    }
}

#[test]
fn an_action_without_effect_is_told() {
    let action =
        |at: &str, what: &str| format!("[[action]]\nat = \"{at}\"\nnode = \"valve\"\ndo = \"{what}\"\n");
    let more: String = [
        action("3s", "power_on"),
        action("3.1s", "plug"),
        action("3.2s", "cut"),
        action("3.3s", "cut"),
        action("3.4s", "power_off"),
        action("3.5s", "power_off"),
        action("3.6s", "reset"),
    ]
    .concat();
    let (trace, _) = traced(&more);
    let told: Vec<(&str, &str)> = (trace.lines())
        .filter(|line| line.contains("has no effect"))
        .filter_map(|line| Some((line.split_whitespace().next()?, line.split("| ").nth(1)?)))
        .collect();
    assert_eq!(
        told,
        [
            ("3.000000", "the action power_on has no effect: it has power already"),
            ("3.100000", "the action plug has no effect: the cable is plugged already"),
            ("3.300000", "the action cut has no effect: the cable is unplugged already"),
            ("3.500000", "the action power_off has no effect: no power"),
            ("3.600000", "the action reset has no effect: no power"),
        ]
    );
    assert!(!trace.contains("| reset\n"), "{trace}");
}

/// The valve asks alone. Its counters go with its power: it does not become error-active, though network access becomes
/// nonexistent.
#[test]
fn a_node_that_loses_its_power_is_not_error_active() {
    holds(
        r#"
        [[action]]
        at = "0s"
        node = "scanner"
        do = "power_off"
        [[action]]
        at = "1s"
        node = "valve"
        do = "power_off"
        [[expect]]
        at = "999ms"
        node = "valve"
        tec = 128
        [[expect]]
        at = "1s"
        node = "valve"
        tec = 0
        [[expect]]
        never = true
        node = "valve"
        event = "error_active"
        [[expect]]
        from = "1s"
        to = "1s"
        node = "valve"
        event = "state_changed"
        state = "nonexistent""#,
    );
}
