//! Presence, duplicates, restarts, faults and recovery.

use super::*;

#[test]
fn a_node_that_was_never_heard_is_not_found() {
    let mut ward = Ward::new();
    ward.group2(10, 6, &[1, 0x4B, 3, 1, 1, 1]).wait(1_000);
    ward.group2(10, 6, &[1, 0x4B, 3, 1, 1, 1]).wait(2_000);
    // That could be a tool that looks who is there.
    ward.group2(10, 6, &[1, 0x4B, 3, 1, 1, 1]).wait(2_000);
    ward.is_healthy();
    ward.group2(10, 6, &[1, 0x4B, 3, 1, 1, 1]).wait(10);
    let found = ward.only(Rule::NotFound);
    assert_eq!((found.severity, found.since), (Severity::Warning, Instant::from_millis(1)));
    assert_eq!(found.to_string(), "node 10 was never heard, and answers none of 4 requests of node 1");
    assert_eq!(found.scanner_status().map(|status| status.0), Some(78));
    ward.check(10, 0, 1);
    assert!(ward.only(Rule::NotFound).is_over());
}

#[test]
fn a_node_that_is_expected_and_not_found_is_an_error() {
    let mut ward = Ward::new();
    ward.doctor.expect(mac(10), ExpectedNode::default());
    for _ in 0..4 {
        ward.group2(10, 6, &[1, 0x4B, 3, 1, 1, 1]).wait(1_000);
    }
    assert_eq!(ward.only(Rule::NotFound).severity, Severity::Error);
}

/// Nobody wants it any more: that it is silent is no fault.
#[test]
fn a_node_that_nobody_asks_for_any_more_is_not_missed() {
    for is_known in [false, true] {
        let mut ward = Ward::new();
        if is_known {
            ward.check(10, 0, 1);
        }
        for _ in 0..7 {
            ward.group2(10, 6, &[1, 0x4B, 3, 1, 1, 1]).wait(1_000);
        }
        let rule = if is_known { Rule::NotAnswering } else { Rule::NotFound };
        assert!(!ward.only(rule).is_over());
        ward.wait(58_990);
        assert!(!ward.only(rule).is_over());
        ward.wait(20);
        assert!(ward.only(rule).is_over());
    }
}

/// Two checks, each sent again and again until somebody else is there to acknowledge it.
#[test]
fn a_check_that_nobody_acknowledges_is_no_restart() {
    let mut ward = Ward::new();
    for _ in 0..3 {
        for _ in 0..990 {
            ward.check(10, 0, 1);
        }
        ward.wait(10);
    }
    assert_eq!(ward.of(Rule::Restarted), []);
}

/// With power it says something, though it does not answer at that door.
#[test]
fn a_node_that_says_anything_is_there() {
    let mut ward = Ward::new();
    for _ in 0..3 {
        ward.group2(10, 6, &[1, 0x4B, 3, 1, 1, 1]).wait(1_000).check(10, 0, 1);
    }
    assert_eq!(ward.of(Rule::NotFound), []);
}

#[test]
fn a_node_that_was_heard_answers_no_request() {
    let mut ward = Ward::new();
    ward.allocate(10, 1, 1);
    for _ in 0..4 {
        ward.group2(10, 4, &[1, 0x0E, 1, 1, 1]).wait(1_000);
    }
    assert_eq!(ward.only(Rule::NotAnswering).to_string(), "node 10 answers none of 4 requests of node 1");
}

#[test]
fn a_check_that_is_answered_is_a_duplicate() {
    let mut ward = Ward::new();
    ward.check(10, 0, 1).wait(1_000).check(10, 0, 1).wait(1_000);
    ward.is_healthy();
    ward.check(10, 0, 2).check(10, 0x80, 1);
    let found = ward.only(Rule::DuplicateMacId);
    assert_eq!(
        found.to_string(),
        "duplicate MAC ID 10: vendor 4660, serial 0x00000001 has it, vendor 4660, serial 0x00000002 wants it"
    );
    assert_eq!(found.evidence.frames(), [3, 4]);
    assert_eq!(found.scanner_status().map(|status| status.0), Some(70));
    ward.wait(60_000);
    assert!(!ward.only(Rule::DuplicateMacId).is_over(), "the second one is still silent");
    // The second one gets another MAC ID.
    ward.check(11, 0, 2);
    assert!(ward.only(Rule::DuplicateMacId).is_over());
}

#[test]
fn a_duplicate_is_over_when_the_second_one_has_got_the_mac_id() {
    let mut ward = Ward::new();
    ward.check(10, 0, 1).wait(1_000).check(10, 0, 1).wait(1_000).check(10, 0, 2).check(10, 0x80, 1);
    // The first one is taken out, and the second one begins anew.
    ward.wait(10_000).check(10, 0, 2).wait(1_000).check(10, 0, 2).wait(900);
    assert!(ward.of(Rule::DuplicateMacId)[0].1.is_none());
    ward.wait(200);
    assert!(ward.of(Rule::DuplicateMacId)[0].1.is_some());
}

#[test]
fn two_devices_that_check_at_once_silence_each_other() {
    let mut ward = Ward::new();
    ward.check(10, 0, 1).wait(500).check(10, 0, 2);
    let found = ward.only(Rule::DuplicateMacId);
    assert_eq!(found.evidence.frames(), [1, 2]);
    assert_eq!(
        found.to_string(),
        "duplicate MAC ID 10: vendor 4660, serial 0x00000001 and vendor 4660, serial 0x00000002 both want it, and none has \
         it yet"
    );
    // The first one has heard the second, and is silent.
    ward.wait(1_000).check(10, 0, 2).wait(1_010);
    assert_eq!(
        ward.only(Rule::DuplicateMacId).to_string(),
        "duplicate MAC ID 10: vendor 4660, serial 0x00000002 has it, vendor 4660, serial 0x00000001 wants it"
    );
}

/// A device that was there before, and is not any more, has no part in it.
#[test]
fn an_owner_that_is_gone_does_not_have_the_mac_id() {
    const GOODBYE: [u8; 8] = [10, 0xCE, 1, 0, 1, 0, 0, 0];
    let leave: [(&str, Deed); 3] = [
        ("without a word", |_| {}),
        ("to another MAC ID", |ward| {
            ward.check(11, 0, 1).wait(1_000).check(11, 0, 1);
        }),
        ("with a farewell", |ward| {
            ward.group2(10, 3, &GOODBYE);
        }),
    ];
    for (how, leave) in leave {
        let mut ward = Ward::new();
        ward.check(10, 0, 1).wait(1_000).check(10, 0, 1).wait(5_000);
        leave(&mut ward);
        ward.wait(5_000).check(10, 0, 2).wait(500).check(10, 0, 3);
        assert_eq!(
            ward.of(Rule::DuplicateMacId)[0].2,
            "duplicate MAC ID 10: vendor 4660, serial 0x00000002 and vendor 4660, serial 0x00000003 both want it, and none \
             has it yet",
            "{how}"
        );
    }
}

/// Whoever asked was not heard; who has asked long before is somewhere else by now.
#[test]
fn an_answer_names_only_who_has_just_asked() {
    let mut ward = Ward::new();
    ward.check(10, 0, 1).wait(1_000).check(10, 0, 1).wait(60_000).check(10, 0x80, 2);
    assert_eq!(
        ward.only(Rule::DuplicateMacId).to_string(),
        "duplicate MAC ID 10: vendor 4660, serial 0x00000002 has it"
    );
}

/// Its defence fails, it is bus-off, begins anew, and checks its MAC ID itself: it is still the owner.
#[test]
fn an_owner_that_checks_anew_after_an_intruder_is_the_owner() {
    let mut ward = Ward::new();
    ward.check(10, 0, 1).wait(1_000).check(10, 0, 1).wait(1_000);
    ward.check(10, 0, 2).wait(100).check(10, 0, 1).wait(1_000).check(10, 0, 1).wait(2_000);
    assert_eq!(
        ward.of(Rule::DuplicateMacId)[0].2,
        "duplicate MAC ID 10: vendor 4660, serial 0x00000001 has it, vendor 4660, serial 0x00000002 wants it"
    );
}

/// The old one was taken out. Nobody objects to the new one, which has the same MAC ID.
#[test]
fn a_replaced_device_is_no_duplicate() {
    let mut ward = Ward::new();
    ward.check(10, 0, 1).wait(1_000).check(10, 0, 1).wait(10_000);
    ward.check(10, 0, 2).wait(1_000).check(10, 0, 2).wait(10_000);
    let found = ward.only(Rule::IdentityChanged);
    assert_eq!(found.severity, Severity::Info);
    assert_eq!(
        found.to_string(),
        "node 10 is another device than before: serial number was 0x00000001, is 0x00000002"
    );
}

#[test]
fn a_restart_is_worth_knowing_and_the_third_one_worth_a_look() {
    let mut ward = Ward::new();
    let mut restart = |millis: u64| {
        ward.check(10, 0, 1).wait(1_000).check(10, 0, 1).wait(millis);
        ward.of(Rule::Restarted).len()
    };
    assert_eq!([restart(2_000), restart(2_000), restart(2_000)], [0, 1, 1]);
    assert_eq!(ward.only(Rule::Restarted).severity, Severity::Info);
    ward.check(10, 0, 1);
    let found = ward.only(Rule::Restarted);
    assert_eq!((found.severity, found.count), (Severity::Warning, 3));
    assert_eq!(found.to_string(), "node 10 has restarted, 3 times");
}

#[test]
fn a_faulted_device_waits_until_it_is_repaired() {
    let mut ward = Ward::new();
    ward.id(0x7ED, &[0x3F, 0x4B, 3]);
    ward.is_healthy();
    ward.id(0x7EC, &[0, 0x34, 0x12, 7, 0, 0, 0]);
    let found = ward.only(Rule::WaitingForRecovery);
    assert_eq!(
        found.to_string(),
        "vendor 4660, serial 0x00000007 has a communication fault and waits for recovery"
    );
    // Another one is another finding; asked again, it is the same.
    ward.id(0x7EC, &[0, 0x34, 0x12, 8, 0, 0, 0]).id(0x7EC, &[0, 0x34, 0x12, 7, 0, 0, 0]);
    assert_eq!(ward.of(Rule::WaitingForRecovery).len(), 2);
    ward.check(12, 0, 7);
    let ends: Vec<bool> = ward.of(Rule::WaitingForRecovery).iter().map(|(_, end, _)| end.is_some()).collect();
    assert_eq!(ends, [true, false]);
}

#[test]
fn a_fault_that_stays_is_an_error() {
    let heartbeat = |state, flags| [10, 0xCD, 1, 0, state, flags, 0, 0];
    let mut ward = Ward::new();
    ward.group2(10, 3, &heartbeat(3, 0));
    ward.is_healthy();
    ward.group2(10, 3, &heartbeat(4, 1));
    let found = ward.only(Rule::Fault);
    assert_eq!(found.severity, Severity::Warning);
    assert_eq!(
        found.to_string(),
        "node 10 reports a fault in its heartbeat: major recoverable fault, fault flags 0x01"
    );
    let kinds = |ward: &mut Ward| {
        core::iter::from_fn(|| ward.doctor.poll()).map(|news| news.kind).collect::<Vec<_>>()
    };
    assert_eq!(kinds(&mut ward), [ChangeKind::Begins]);
    // Nothing has told that it stays.
    ward.wait(10_000);
    assert_eq!(ward.only(Rule::Fault).severity, Severity::Warning);
    ward.group2(10, 3, &heartbeat(4, 1)).wait(10);
    assert_eq!(ward.only(Rule::Fault).severity, Severity::Error);
    assert_eq!(kinds(&mut ward), [ChangeKind::Escalates]);
    ward.group2(10, 3, &heartbeat(3, 0));
    assert_eq!(kinds(&mut ward), [ChangeKind::Ends]);
}

/// After a restart it tells anew.
#[test]
fn a_fault_and_a_bus_off_counter_end_with_the_power() {
    let mut ward = Ward::new();
    ward.allocate(10, 1, 1);
    ward.group2(10, 4, &[1, 0x0E, 1, 1, 5]).group2(10, 3, &[1, 0x8E, 0x01, 0x04]);
    ward.group2(10, 4, &[1, 0x0E, 3, 1, 4]).group2(10, 3, &[1, 0x8E, 2]);
    assert_eq!(ward.rules(), [Rule::Fault, Rule::BusOff]);
    ward.check(10, 0, 1);
    assert!([Rule::Fault, Rule::BusOff].iter().all(|&rule| ward.of(rule)[0].1.is_some()));
}

#[test]
fn faults_in_the_status_and_the_bus_off_counter() {
    let mut ward = Ward::new();
    ward.allocate(10, 1, 1);
    let mut get = |class, attribute, value: &[u8]| {
        ward.group2(10, 4, &[1, 0x0E, class, 1, attribute]);
        ward.group2(10, 3, &[&[1, 0x8E], value].concat());
        ward.rules()
    };
    assert_eq!(get(1, 5, &[0x01, 0x00]), []);
    assert_eq!(get(3, 4, &[0]), []);
    assert_eq!(get(1, 5, &[0x01, 0x04]), [Rule::Fault]);
    assert_eq!(get(3, 4, &[2]), [Rule::Fault, Rule::BusOff]);
    assert_eq!(ward.of(Rule::Fault)[0].2, "node 10 reports a fault in its status: 0x0401");
    assert_eq!(ward.of(Rule::BusOff)[0].2, "node 10 tells that it was bus-off 2 times");
}

#[test]
fn whoever_says_goodbye_has_left() {
    let mut ward = Ward::new();
    ward.group2(10, 3, &[10, 0xCE, 1, 0, 1, 0, 0, 0]);
    assert_eq!(ward.only(Rule::Left).severity, Severity::Info);
    ward.check(10, 0, 1);
    assert!(ward.only(Rule::Left).is_over());
}

/// What rules judge, or a lost frame makes, is worth knowing; what breaks the protocol is more.
#[test]
fn a_problem_of_a_frame_has_a_severity() {
    use crate::monitor::Problem;
    use cip_core::monitor::Flaw;
    assert_eq!(Severity::of(&Flaw::PollUnanswered { n: 1 }.into()), Severity::Info);
    assert_eq!(Severity::of(&Flaw::LateAcknowledge { count: 1 }.into()), Severity::Info);
    assert_eq!(Severity::of(&Problem::RemoteFrame), Severity::Info);
    assert_eq!(Severity::of(&Flaw::ResponseBitOnRequest.into()), Severity::Warning);
}

#[test]
fn answers_that_nobody_has_asked_for_have_a_second_sender() {
    let mut ward = Ward::with_slave();
    let other = |ward: &mut Ward| _ = ward.group1(0xF, 10, &[3]);
    other(ward.poll().answer());
    other(ward.poll().answer());
    ward.is_healthy();
    other(ward.poll().answer());
    let found = ward.only(Rule::IdentifierCollision);
    assert_eq!(
        found.to_string(),
        "identifier 0x3CA of node 10 carries answers that nobody has asked for: a second sender, 1 times"
            .trim_end_matches(", 1 times")
    );
    // A slave that is late answers each of the polls that it has got.
    let mut ward = Ward::with_slave();
    for _ in 0..10 {
        ward.poll().poll().answer().answer();
    }
    ward.is_healthy();
    // The listener has missed a poll now and then: no second sender.
    let mut ward = Ward::with_slave();
    for _ in 0..10 {
        other(ward.poll().answer());
        ward.wait(6_000);
    }
    assert_eq!(ward.of(Rule::IdentifierCollision), []);
    // The same answer twice: a second sender, if it is so nearly each time, or else the frame was sent again.
    for (every, expected) in [(1, &[Rule::IdentifierCollision][..]), (3, &[])] {
        let mut ward = Ward::with_slave();
        for round in 0..30 {
            ward.poll().answer();
            if round % every == 0 {
                ward.answer();
            }
            ward.wait(20);
        }
        assert_eq!(ward.rules(), expected, "{every}");
    }
    // There was an error before: then it was sent again, whatever it is.
    let mut ward = Ward::with_slave();
    for _ in 0..9 {
        ward.poll().answer().link(LinkEvent::BusError(link_core::BusErrorKind::Form));
        other(&mut ward);
        ward.wait(90);
    }
    ward.is_healthy();
    // Or it has missed many, and knows it.
    let mut ward = Ward::with_slave();
    for _ in 0..10 {
        other(ward.poll().answer().link(LinkEvent::Overrun { lost: 1 }));
    }
    assert_eq!(ward.rules(), [Rule::Overrun]);
}
