//! Every action and every fault of a scenario does what it says.

use std::path::Path;

use devicenet_cli::scenario::Scenario;
use devicenet_cli::simulate::{self, Outcome, Settings};

/// A valve with MAC ID 10 and a scanner with MAC ID 0, on line after two seconds; ten seconds.
const PAIR: &str = r#"
[bus]
[[node]]
name = "valve"
protocol = "devicenet"
role = "access"
mac = 10
identity = { vendor = 0x1234, serial = 1 }
[[node]]
name = "scanner"
protocol = "devicenet"
role = "access"
mac = 0
identity = { vendor = 0x1234, serial = 2 }
"#;

/// Runs the pair with more around it, and demands that every expectation holds.
#[track_caller]
fn holds(more: &str) -> Outcome {
    let scenario = Scenario::parse("pair", &format!("{PAIR}{more}"), Path::new("")).unwrap();
    let (trace, outcome) = simulate::trace(&scenario, Settings::default());
    assert_eq!(outcome.verdict.failures, [], "{trace}");
    assert!(outcome.verdict.held > 0, "nothing is expected");
    outcome
}

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

#[test]
fn one_wrong_bit_destroys_one_frame() {
    let outcome = holds(
        r#"
        [[fault]]
        kind = "bit_error"
        bit = 40
        [[expect]]
        at = "3s"
        node = "valve"
        state = "online""#,
    );
    assert_eq!(outcome.summary.bus.errors, 1);
}

#[test]
fn bit_errors_and_noise_destroy_frames_and_end() {
    for fault in ["kind = \"bit_error\"\nrate = 0.02", "kind = \"noise\"\ngap = \"1ms\"\nlength = \"200us\""]
    {
        let expect = "[[expect]]\nat = \"4s\"\nnode = \"valve\"\nstate = \"online\"";
        let outcome = holds(&format!("[[fault]]\nto = \"50ms\"\n{fault}\n{expect}"));
        assert!(outcome.summary.bus.errors > 0, "{fault}");
    }
}

#[test]
fn a_babbling_transceiver_stops_everything() {
    holds(
        r#"
        [[fault]]
        kind = "babble"
        to = "100ms"
        [[expect]]
        never = true
        to = "100ms"
        event = "sent"
        [[expect]]
        at = "3s"
        node = "valve"
        state = "online""#,
    );
}

/// The valve does not hear the twin's request, so it does not answer it: both are on line with one MAC ID.
#[test]
fn a_lost_request_is_not_answered() {
    holds(
        r#"
        [[fault]]
        kind = "lost_frame"
        from = "3s"
        overrun = true
        node = "valve"
        id = 0x457
        [[node]]
        name = "twin"
        protocol = "devicenet"
        role = "access"
        mac = 10
        power_up = "3s"
        identity = { vendor = 0x1234, serial = 3 }
        [[expect]]
        at = "6s"
        node = "valve"
        state = "online"
        [[expect]]
        at = "6s"
        node = "twin"
        state = "online""#,
    );
}

/// Only the valve sees the end of the frame wrong. Its active error flag makes the twin send again, for ever.
#[test]
fn a_spoilt_end_is_sent_again() {
    let outcome = holds(
        r#"
        [[fault]]
        kind = "lost_frame"
        from = "3s"
        to = "3.02s"
        node = "valve"
        id = 0x45F
        [[node]]
        name = "other"
        protocol = "devicenet"
        role = "access"
        mac = 11
        power_up = "3s"
        identity = { vendor = 0x1234, serial = 3 }
        [[expect]]
        at = "6s"
        node = "other"
        state = "online""#,
    );
    assert!(outcome.summary.bus.errors > 10, "{}", outcome.summary.bus.errors);
}

/// A second is 999 ms on a clock that is a thousandth fast.
#[test]
fn a_fast_clock_shortens_the_wait() {
    holds(
        r#"
        [[fault]]
        kind = "clock"
        ppm = 1_000
        node = "valve"
        [[expect]]
        by = "2.001s"
        node = "valve"
        state = "online"
        [[expect]]
        never = true
        to = "2.001s"
        node = "scanner"
        state = "online""#,
    );
}

#[test]
fn a_babbler_with_the_highest_priority_lets_nobody_else_send() {
    let more = r#"
        [[node]]
        name = "mad"
        role = "babbler"
        frame = "000#"
        power_up = "1ms"
        [[expect]]
        never = true
        from = "3ms"
        node = "valve"
        event = "sent""#;
    let outcome = holds(more);
    assert!(outcome.summary.bus.load > 90.0, "{}", outcome.summary.bus.load);
}

#[test]
fn a_listener_does_not_acknowledge() {
    let text = PAIR.replacen(
        "role = \"access\"\nmac = 0\nidentity = { vendor = 0x1234, serial = 2 }",
        "role = \"listener\"",
        1,
    );
    let text = text.replacen("name = \"scanner\"\nprotocol = \"devicenet\"", "name = \"scanner\"", 1);
    let scenario = Scenario::parse("pair", &text, Path::new("")).unwrap();
    let outcome = simulate::outcome(
        &scenario,
        Settings { seed: None, until: Some(core::time::Duration::from_secs(1)) },
    );
    assert_eq!(outcome.summary.bus.frames, 0);
}

/// What the README shows is a scenario, and its expectations hold.
#[test]
fn the_scenario_of_the_readme() {
    let readme = devicenet_tests::read("README.md");
    let (_, after) = readme.split_once("```toml\n").expect("a scenario");
    let (text, _) = after.split_once("```").expect("its end");
    let scenario =
        Scenario::parse("README.md", text, Path::new("")).unwrap_or_else(|error| panic!("{error}"));
    let (trace, outcome) = simulate::trace(&scenario, Settings::default());
    assert_eq!(outcome.verdict.failures, [], "{trace}");
}
