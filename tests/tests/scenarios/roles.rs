//! Nodes that perform no network access.

use std::path::Path;

use devicenet_cli::scenario::Scenario;
use devicenet_cli::simulate::{self, Settings};

use crate::{PAIR, holds, traced};

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
    assert!(outcome.summary.bus.load > 0.9, "{}", outcome.summary.bus.load);
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

/// Two nodes play a recording, each its identifiers, in step; its lines are not in the order of time.
#[test]
fn recordings_are_played_in_the_order_of_time_and_in_step() {
    let replay = |name: &str, only: &str| {
        format!(
            "[[node]]\nname = \"{name}\"\nrole = \"replay\"\npower_up = \"3s\"\nonly = [{only}]\nlog = \"\"\"\n\
             (7.3) can0 3C7#03\n(7.0) can0 3C5#01\n(7.1) can0 3C6#02\n(7.2) can0 3C5#04\n\"\"\"\n"
        )
    };
    let (trace, _) = traced(&format!("{}{}", replay("one", "0x3C5, 0x3C7"), replay("other", "0x3C6")));
    let played: Vec<(&str, &str)> = (trace.lines())
        .filter_map(|line| {
            let mut words = line.split_whitespace();
            let (at, _, id) = (words.next()?, words.next()?, words.next()?);
            id.starts_with("3C").then(|| (&at[..3], id))
        })
        .collect();
    assert_eq!(played, [("3.0", "3C5"), ("3.1", "3C6"), ("3.2", "3C5"), ("3.3", "3C7")]);
}

#[test]
fn a_babbler_keeps_its_period_from_start_to_start() {
    // 100 periods of 10 ms are a second; a frame takes half a millisecond, which would cost five periods.
    let outcome = holds(
        r#"
        [[node]]
        name = "mad"
        role = "babbler"
        frame = "3C5#0102030405060708"
        period = "10ms"
        [[expect]]
        from = "9.985s"
        to = "10s"
        node = "mad"
        event = "sent""#,
    );
    assert_eq!(outcome.summary.nodes[2].sent, 1_000);
}
