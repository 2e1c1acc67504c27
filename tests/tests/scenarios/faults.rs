//! Every fault of a scenario does what it says.

use crate::{holds, traced};

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

/// In the order of the file the later fault is first: at 2 s the clock would be set right after it has gone wrong again.
#[test]
fn one_fault_ends_before_another_begins_whatever_their_order() {
    let clock = |from: &str, to: &str, ppm: &str| {
        format!(
            "[[fault]]\nkind = \"clock\"\nfrom = \"{from}\"\nto = \"{to}\"\nppm = {ppm}\nnode = \"valve\"\n"
        )
    };
    let segment = |from: &str, to: &str, node: &str| {
        format!("[[fault]]\nkind = \"segment\"\nfrom = \"{from}\"\nto = \"{to}\"\nnode = \"{node}\"\n")
    };
    for (later, earlier) in [
        (clock("2s", "3s", "-500"), clock("1s", "2s", "500")),
        (segment("2s", "3s", "valve"), segment("1s", "2s", "scanner")),
    ] {
        let (reversed, _) = traced(&format!("{later}{earlier}"));
        let (in_order, _) = traced(&format!("{earlier}{later}"));
        assert_eq!(reversed, in_order);
        let at_2_s: Vec<&str> = (in_order.lines())
            .filter(|line| line.trim_start().starts_with("2.000000"))
            .filter_map(|line| line.split("| ").nth(1))
            .collect();
        let expected = if later.contains("clock") {
            ["clock off by 0 ppm", "clock off by -500 ppm"]
        } else {
            ["the bus is whole again", "the bus is cut: valve apart"]
        };
        assert_eq!(at_2_s, expected);
    }
}

/// Each part is a network of its own, where one identifier may have another producer.
#[test]
fn the_same_identifier_on_both_parts_breaks_no_rule() {
    let babbler = |name: &str, data: &str| {
        format!(
            "[[node]]\nname = \"{name}\"\nrole = \"babbler\"\nframe = \"3C5#{data}\"\nperiod = \"100ms\"\n"
        )
    };
    let nodes = format!("{}{}", babbler("one", "01"), babbler("other", "02"));
    let apart = "[[fault]]\nkind = \"segment\"\nnodes = [\"scanner\", \"other\"]\n";
    let rule = "one identifier, two producers";
    assert!(!traced(&format!("{nodes}{apart}")).0.contains(rule));
    assert!(traced(&nodes).0.contains(rule));
    let late = apart.replace("kind", "to = \"5s\"\nkind");
    let (trace, _) = traced(&format!("{nodes}{late}"));
    let first = trace.lines().find(|line| line.contains(rule)).expect("joined, they are one network");
    assert!(first.trim_start().starts_with("5."), "{first}");
}

/// A tool that stays with the others knows of those apart what it knew before.
#[test]
fn what_a_part_has_learnt_is_not_known_to_the_others() {
    let more = r#"
        [[node]]
        name = "mover"
        protocol = "devicenet"
        role = "access"
        mac = 20
        identity = { vendor = 0x1234, serial = 3 }
        [[fault]]
        kind = "segment"
        from = "3s"
        to = "6s"
        nodes = ["mover", "scanner"]
        [[action]]
        at = "3s"
        node = "mover"
        do = "set_mac"
        value = 10
        [[action]]
        at = "7s"
        node = "mover"
        do = "reset"
        [[expect]]
        at = "6s"
        node = "mover"
        state = "online"
        [[expect]]
        at = "6s"
        node = "valve"
        state = "online"
        [[expect]]
        by = "7.1s"
        node = "mover"
        state = "comm_fault""#;
    let (trace, _) = traced(more);
    let told: Vec<&str> = (trace.lines())
        .filter(|line| line.contains("dup MAC 10") && line.contains(" ! "))
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    // While apart too: before that the mover's segment had heard the valve.
    assert_eq!(told.len(), 3, "{trace}");
    assert!(told[0].starts_with("3.") && told[1..].iter().all(|at| at.starts_with("7.")), "{told:?}");
}

#[test]
fn the_trace_says_what_a_fault_is_like() {
    for (fault, words) in [
        ("kind = \"bit_error\"\nrate = 1e-4", "bit errors on the bus, 0.0001 per bit"),
        (
            "kind = \"bit_error\"\nbit = 3\nframe = 7\nnode = \"valve\"",
            "an error in what valve hears in bit 3 of frame 7 from now",
        ),
        ("kind = \"lost_frame\"\nnode = \"valve\"", "the end of frames is wrong in what valve hears"),
        (
            "kind = \"lost_frame\"\nnodes = [\"valve\", \"scanner\"]\nid = 0x57\nrate = 0.5\noverrun = true",
            "valve, scanner are too slow to read frames 057, 0.5 of them",
        ),
        (
            "kind = \"noise\"\ngap = \"1ms\"\nlength = \"200us\"",
            "noise on the bus, bursts of 200us about every 1.2ms",
        ),
        (
            "kind = \"babble\"\npull = \"1ms\"\nevery = \"1s\"",
            "a transceiver holds the bus dominant, for 1ms every 1s",
        ),
        ("kind = \"babble\"", "a transceiver holds the bus dominant"),
    ] {
        let (trace, _) = traced(&format!("[[fault]]\nfrom = \"9.99s\"\nto = \"10s\"\n{fault}\n"));
        for told in [format!("| fault begins: {words}\n"), format!("| fault ends: {words}\n")] {
            assert!(trace.contains(&told), "{told}{trace}");
        }
    }
}

/// Every ten milliseconds a frame gets through on the other part. That is no news for the valve, which goes on failing.
#[test]
fn failures_are_counted_on_each_part_for_itself() {
    let (trace, _) = traced(
        r#"
        [[node]]
        name = "other"
        role = "babbler"
        frame = "3C5#"
        period = "10ms"
        [[fault]]
        kind = "segment"
        to = "100ms"
        node = "valve""#,
    );
    let apart = trace.split("the bus is whole again").next().expect("the beginning");
    let told = apart.lines().filter(|line| line.contains("ACK error")).count();
    assert_eq!(told, 2, "an active flag, then a passive one: {apart}");
    let times: Vec<&str> = apart.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert!(times.is_sorted(), "{apart}");
}
