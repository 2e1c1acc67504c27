//! Duplicate MAC ID check, heartbeat, shutdown.

use super::*;

const DEVICE: [u8; 7] = [0x00, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00];
const TWIN: [u8; 7] = [0x00, 0x77, 0x00, 0x04, 0x03, 0x02, 0x01];
const STRANGER: [u8; 7] = [0x00, 0x78, 0x00, 0x05, 0x03, 0x02, 0x01];

#[test]
fn a_node_comes_on_line_by_two_checks_and_a_second() {
    let mut bus = Bus::new();
    bus.group2(10, 7, &DEVICE);
    assert_eq!(bus.node(10).access, AccessState::FirstCheck);
    bus.wait(999).group2(10, 7, &DEVICE);
    assert_eq!(bus.node(10).access, AccessState::SecondCheck);
    // It is, even if nothing is heard any more.
    let later = |millis| bus.monitor.nodes_at(Instant::from_millis(bus.now + millis)).next().unwrap().access;
    assert_eq!([later(999), later(1_000)], [AccessState::SecondCheck, AccessState::OnLine]);
    bus.wait(1000).group2(1, 7, &TWIN);
    assert_eq!(bus.node(10).access, AccessState::OnLine);
    let node = bus.node(10);
    assert_eq!((node.vendor.map(u16::from), node.serial), (Some(0x1234), Some(0x2345)));
}

/// A controller that nobody acknowledges sends the same frame again until somebody does; then its wait begins.
#[test]
fn a_check_that_is_repeated_is_one_check() {
    let mut bus = Bus::new();
    for expected in [AccessState::FirstCheck, AccessState::SecondCheck] {
        for _ in 0..3_000 {
            let heard = bus.group2(10, 7, &DEVICE);
            assert_eq!((bus.node(10).access, heard.note, heard.problem), (expected, None, None));
        }
        bus.wait(999);
    }
    bus.wait(1).group2(1, 7, &TWIN);
    assert_eq!(bus.node(10).access, AccessState::OnLine);
    // The same of a restart, and of another device.
    let notes = [(); 3].map(|()| bus.group2(10, 7, &DEVICE).note);
    assert_eq!(notes, [Some(Note::Restarted), None, None]);
    bus.wait(2_001);
    let problems = [(); 3].map(|()| bus.group2(10, 7, &STRANGER).problem);
    assert_eq!(problems, [Some(Problem::TwoIdentities { mac: mac(10) }), None, None]);
    assert_eq!(bus.node(10).access, AccessState::SuspectedDuplicate);
    // What says something in between has been acknowledged: this is a new check.
    bus.group1(15, 1, &[]);
    assert_eq!(bus.group2(1, 7, &TWIN).note, Some(Note::Restarted));
}

#[test]
fn a_check_of_a_node_on_line_is_a_restart_and_ends_its_connections() {
    let mut bus = Bus::new();
    bus.group2(10, 7, &DEVICE);
    bus.wait(999).group2(10, 7, &DEVICE);
    bus.wait(2000).group2(10, 6, &[0x01, 0x4B, 3, 1, 0x03, 1]);
    bus.group2(10, 3, &[0x01, 0xCB, 0]);
    assert_eq!(bus.group2(10, 7, &DEVICE).note, Some(Note::Restarted));
    assert_eq!(bus.state(10, Predefined::Explicit), ConnectionState::NonExistent);
    assert_eq!(bus.node(10).master, None);
    bus.wait(999).group2(10, 7, &DEVICE);
    let heard = bus.wait(5000).group2(10, 7, &DEVICE);
    assert_eq!((heard.note, heard.problem), (Some(Note::Restarted), None));
    assert_eq!(bus.node(10).access, AccessState::FirstCheck);
}

#[test]
fn a_twin_is_told_by_its_identity_and_by_the_response() {
    let mut bus = Bus::new();
    bus.group2(10, 7, &DEVICE);
    bus.wait(999).group2(10, 7, &DEVICE);
    let heard = bus.wait(5000).group2(10, 7, &TWIN);
    assert_eq!(heard.problem, Some(Problem::TwoIdentities { mac: mac(10) }));
    let asked = heard.n;
    let mut response = DEVICE;
    response[0] = 0x80;
    let heard = bus.group2(10, 7, &response);
    assert_eq!(heard.problem, Some(Problem::DuplicateMacId { mac: mac(10) }));
    assert_eq!(heard.answers(), Some(asked));
    assert_eq!(heard.text, "dup MAC 10 response  vendor 4660 serial 0x00002345  ! duplicate MAC ID 10");
    let node = bus.node(10);
    assert_eq!((node.access, node.serial), (AccessState::OnLine, Some(0x2345)), "it has defended its MAC ID");
    assert_eq!(node.traffic.problems, 2, "both frames stay problems");
    // The next to ask is suspected anew.
    let heard = bus.wait(5000).group2(10, 7, &TWIN);
    assert_eq!(heard.problem, Some(Problem::TwoIdentities { mac: mac(10) }));
    assert_eq!(bus.node(10).access, AccessState::SuspectedDuplicate);
}

/// The owner could not object, for example because it was bus-off, and starts again.
#[test]
fn a_suspected_node_that_restarts_comes_on_line_by_two_undisputed_checks() {
    let mut bus = Bus::new();
    bus.group2(10, 7, &DEVICE);
    bus.wait(999).group2(10, 7, &DEVICE);
    bus.wait(1500).group2(10, 7, &TWIN);
    assert_eq!(bus.node(10).access, AccessState::SuspectedDuplicate);
    let heard = bus.wait(120).group2(10, 7, &DEVICE);
    assert_eq!((heard.problem, bus.node(10).access), (None, AccessState::FirstCheck));
    bus.wait(999).group2(10, 7, &DEVICE);
    assert_eq!(bus.node(10).access, AccessState::SecondCheck);
    bus.wait(1000).group2(1, 7, &TWIN);
    let node = bus.node(10);
    assert_eq!((node.access, node.serial, node.traffic.problems), (AccessState::OnLine, Some(0x2345), 1));
}

#[test]
fn a_suspected_node_is_on_line_if_it_goes_on_after_the_newcomer_has_fallen_silent() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.group2(10, 7, &DEVICE);
    bus.wait(999).group2(10, 7, &DEVICE);
    bus.wait(5000).group2(10, 7, &TWIN);
    bus.wait(1000).group1(15, 10, &[]);
    assert_eq!(bus.node(10).access, AccessState::SuspectedDuplicate, "the second check may still come");
    bus.wait(1001).group1(15, 10, &[]);
    assert_eq!(bus.node(10).access, AccessState::OnLine);
    // A check of the newcomer long after is a first one again.
    let heard = bus.wait(60_000).group2(10, 7, &TWIN);
    assert_eq!(heard.problem, Some(Problem::TwoIdentities { mac: mac(10) }));
}

#[test]
fn an_access_state_has_one_spelling() {
    for (state, name) in [
        (AccessState::OnLine, "online"),
        (AccessState::Faulted, "comm_fault"),
        (AccessState::SuspectedDuplicate, "suspected_duplicate"),
    ] {
        assert_eq!((state.name(), state.to_string().as_str()), (name, name));
    }
}

#[test]
fn a_check_of_another_length_is_a_check_with_a_problem() {
    let mut bus = Bus::new();
    let heard = bus.group2(10, 7, &DEVICE[..5]);
    assert_eq!(heard.kind, Kind::DupMacRequest);
    assert_eq!(heard.problem, Some(Problem::Flaw(Flaw::Length { expected: 7, found: 5 })));
    assert!(heard.text.ends_with("! 7 bytes expected, 5 found"), "{}", heard.text);
}

#[test]
fn a_heartbeat_says_how_the_device_is() {
    let mut bus = Bus::new();
    let heard = bus.group2(3, 3, &[0x03, 0xCD, 0x01, 0x00, 0x03, 0x04, 0x34, 0x12]);
    assert_eq!((heard.kind, heard.problem), (Kind::Heartbeat, None));
    assert_eq!(heard.text, "heartbeat 3  operational, system fault, configuration 0x1234");
    let heard = bus.group3(5, 3, &[0x03, 0xCD, 0x01, 0x00, 0x03, 0x08, 0x00, 0x00]);
    assert_eq!(heard.problem, Some(Problem::HeartbeatEvent));
    let heard = bus.group3(5, 3, &[0x04, 0xCD, 0x01, 0x00, 0x03, 0x00, 0x00, 0x00]);
    assert_eq!(heard.problem, Some(Problem::HeaderNotSender { found: mac(4) }));
    let heard = bus.group3(5, 3, &[0x03, 0xCD, 0x01, 0x00, 0x03, 0x00, 0x00]);
    assert_eq!(heard.problem, Some(Problem::Flaw(Flaw::TooShort { at_least: 8, found: 7 })));
}

#[test]
fn a_missing_heartbeat_is_missed_once_the_interval_is_known() {
    const HEARTBEAT: [u8; 8] = [0x0A, 0xCD, 0x01, 0x00, 0x03, 0x00, 0x00, 0x00];
    let mut bus = Bus::with_slave(10, 0x01);
    bus.group2(10, 3, &HEARTBEAT);
    assert_eq!(bus.wait(60_000).group2(10, 3, &HEARTBEAT).problem, None, "the interval is not known");
    let mut bus = Bus::with_slave(10, 0x01);
    bus.group2(10, 4, &[0x01, 0x10, 1, 1, 10, 5]);
    bus.group2(10, 3, &[0x01, 0x90]);
    bus.group2(10, 3, &HEARTBEAT);
    assert_eq!(bus.wait(5_000).group2(10, 3, &HEARTBEAT).problem, None);
    let expected = Problem::HeartbeatMissing { after: 15, interval: 5 };
    assert_eq!(bus.wait(15_000).group2(10, 3, &HEARTBEAT).problem, Some(expected));
}

#[test]
fn a_shutdown_ends_the_connections() {
    let mut bus = Bus::with_slave(3, 0x03);
    let heard = bus.group2(3, 3, &[0x03, 0xCE, 0x04, 0x00, 0x02, 0x00, 0x01, 0x02]);
    assert_eq!(heard.text, "shutdown 3  Assembly 2, vendor-specific code 0x0201");
    assert_eq!(bus.state(3, Predefined::Explicit), ConnectionState::NonExistent);
    assert_eq!(bus.node(3).access, AccessState::OffLine);
    bus.group2(3, 7, &DEVICE);
    assert_eq!(bus.node(3).access, AccessState::FirstCheck);
    bus.group2(3, 3, &[0x03, 0xCE, 0x01, 0x00, 0x01, 0x00, 0x00, 0x00]);
    bus.group1(15, 3, &[]);
    assert_eq!(bus.node(3).access, AccessState::OnLine, "it is there after all");
}

/// On the identifier of explicit responses 0x4E is also a service of a class, and the header tells them apart.
#[test]
fn a_class_service_with_the_code_of_a_broadcast_is_a_response() {
    let mut bus = Bus::with_slave(3, 0x01);
    bus.group2(3, 4, &[0x01, 0x4E, 0x64, 1]);
    let heard = bus.group2(3, 3, &[0x01, 0xCE, 7]);
    assert_eq!((heard.kind, heard.problem), (Kind::ExplicitResponse, None));
}

#[test]
fn a_device_that_was_replaced_is_suspected_once() {
    let mut bus = Bus::new();
    bus.group2(10, 7, &DEVICE);
    bus.wait(999).group2(10, 7, &DEVICE);
    assert!(bus.wait(60_000).group2(10, 7, &TWIN).problem.is_some());
    let heard = bus.wait(999).group2(10, 7, &TWIN);
    assert_eq!((heard.problem, bus.node(10).access), (None, AccessState::SecondCheck));
    assert_eq!(bus.node(10).serial, Some(0x0102_0304));
}

#[test]
fn a_device_that_moves_frees_its_mac_id() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.group2(10, 7, &DEVICE);
    bus.wait(999).group2(10, 7, &DEVICE);
    bus.group2(10, 6, &[0x01, 0x4B, 3, 1, 0x03, 1]);
    bus.group2(10, 3, &[0x01, 0xCB, 0]);
    bus.establish(10, 2, 0);
    bus.wait(60_000).group2(11, 7, &DEVICE);
    let old = bus.node(10);
    assert_eq!((old.access, old.serial, old.master), (AccessState::OffLine, None, None));
    assert_eq!(
        (bus.node(11).serial, bus.state(10, Predefined::Poll)),
        (Some(0x2345), ConnectionState::NonExistent)
    );
    let heard = bus.wait(60_000).group2(10, 7, &TWIN);
    assert_eq!((heard.problem, bus.node(10).access), (None, AccessState::FirstCheck));
    assert_eq!(bus.node(10).serial, Some(0x0102_0304));
}

/// The recording began when it was on line: who checks now may be the same device, or another one.
#[test]
fn a_node_that_was_never_identified_is_still_there_if_it_answers_the_check() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.establish(10, 2, 1000);
    let heard = bus.group2(10, 7, &TWIN);
    assert_eq!((heard.note, heard.problem, heard.assumed), (Some(Note::RestartedOrAnother), None, true));
    assert!(heard.text.ends_with("(restart, or another device) (assumed)"), "{}", heard.text);
    assert_eq!((bus.node(10).access, bus.node(10).serial), (AccessState::FirstCheck, None));
    let mut response = DEVICE;
    response[0] = 0x80;
    let heard = bus.group2(10, 7, &response);
    assert_eq!(heard.problem, Some(Problem::DuplicateMacId { mac: mac(10) }));
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::Established);
    assert_eq!((bus.node(10).access, bus.node(10).serial), (AccessState::OnLine, Some(0x2345)));
    assert_eq!(bus.node(10).master, Some(mac(1)));
    // It is known now, and the next to ask is another.
    let heard = bus.wait(5000).group2(10, 7, &TWIN);
    assert_eq!(heard.problem, Some(Problem::TwoIdentities { mac: mac(10) }));
}

#[test]
fn a_node_that_was_never_identified_and_goes_on_is_not_the_one_that_checks() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.establish(10, 2, 1000);
    bus.group2(10, 7, &TWIN);
    bus.group2(10, 5, &[1]);
    let heard = bus.group1(15, 10, &[2]);
    assert_eq!((heard.note, heard.problem, heard.assumed), (None, None, false));
    assert_eq!((bus.node(10).access, bus.node(10).serial), (AccessState::OnLine, None));
    assert_eq!(bus.wait(999).group2(10, 7, &TWIN).note, Some(Note::RestartedOrAnother));
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::Established);
}

#[test]
fn a_node_that_was_never_identified_has_restarted_if_nobody_answers_for_it() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.establish(10, 2, 1000);
    bus.group2(10, 7, &DEVICE);
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::Established);
    assert_eq!(bus.wait(999).group2(10, 7, &DEVICE).problem, None);
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::NonExistent);
    assert_eq!((bus.node(10).access, bus.node(10).serial), (AccessState::SecondCheck, Some(0x2345)));
}

/// Two devices with one vendor and serial number: the first goes on, and its connections with it.
#[test]
fn a_device_that_only_seemed_to_move_is_still_there() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.group2(10, 7, &DEVICE);
    bus.group2(10, 6, &[0x01, 0x4B, 3, 1, 0x03, 1]);
    bus.group2(10, 3, &[0x01, 0xCB, 0]);
    bus.establish(10, 2, 0);
    bus.wait(60_000).group2(11, 7, &DEVICE);
    bus.group2(10, 5, &[1]);
    let heard = bus.group1(15, 10, &[2]);
    assert_eq!((heard.note, heard.problem), (None, None));
    assert_eq!((bus.node(10).access, bus.node(10).master), (AccessState::OnLine, Some(mac(1))));
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::Established);
}

#[test]
fn a_device_with_two_ports_has_two_mac_ids() {
    let mut bus = Bus::new();
    let mut second = DEVICE;
    second[0] = 0x01;
    bus.group2(10, 7, &DEVICE);
    bus.group2(11, 7, &second);
    assert_eq!((bus.node(10).serial, bus.node(11).serial), (Some(0x2345), Some(0x2345)));
    assert_eq!(bus.node(10).access, AccessState::FirstCheck);
}

#[test]
fn a_newcomer_that_moves_away_is_new_again_when_it_comes_back() {
    let mut bus = Bus::new();
    bus.group2(10, 7, &DEVICE);
    let twins = Some(Problem::TwoIdentities { mac: mac(10) });
    assert_eq!(bus.wait(5_000).group2(10, 7, &TWIN).problem, twins);
    assert_eq!(bus.wait(5_000).group2(20, 7, &TWIN).problem, None);
    assert_eq!(bus.wait(5_000).group2(10, 7, &TWIN).problem, twins);
}

#[test]
fn a_device_that_has_said_goodbye_leaves_its_mac_id_to_another() {
    let mut bus = Bus::new();
    bus.group2(10, 7, &DEVICE);
    bus.group2(10, 3, &[0x0A, 0xCE, 0x01, 0x00, 0x01, 0x00, 0x00, 0x00]);
    let heard = bus.wait(5_000).group2(10, 7, &TWIN);
    assert_eq!((heard.problem, bus.node(10).serial), (None, Some(0x0102_0304)));
}

/// It has another identity than the one that was faulted, or was repaired unheard.
#[test]
fn a_mac_id_that_sends_is_not_faulted() {
    let mut bus = Bus::new();
    bus.group2(10, 7, &DEVICE);
    bus.frame(0x7EC, &DEVICE);
    assert_eq!(bus.node(10).access, AccessState::Faulted);
    bus.group1(15, 10, &[]);
    assert_eq!(bus.node(10).access, AccessState::OnLine);
}

#[test]
fn twins_that_start_together_are_both_suspected() {
    let mut bus = Bus::new();
    assert_eq!(bus.group2(10, 7, &DEVICE).problem, None);
    assert!(bus.group2(10, 7, &TWIN).problem.is_some());
    bus.wait(999).group2(10, 7, &DEVICE);
    assert!(bus.group2(10, 7, &TWIN).problem.is_some());
    assert_eq!(bus.node(10).access, AccessState::SuspectedDuplicate);
}

/// Quick Connect: allocated between its two checks.
#[test]
fn a_node_that_takes_part_after_one_check_keeps_its_connections() {
    let mut bus = Bus::new();
    bus.group2(10, 7, &DEVICE);
    bus.group2(10, 6, &[0x01, 0x4B, 3, 1, 0x03, 1]);
    bus.group2(10, 3, &[0x01, 0xCB, 0]);
    bus.establish(10, 2, 100);
    assert_eq!(bus.node(10).access, AccessState::OnLine);
    let heard = bus.wait(990).group2(10, 7, &DEVICE);
    assert_eq!((heard.note, heard.problem), (None, None));
    assert_eq!(bus.node(10).access, AccessState::OnLine);
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::Established);
    // Both checks are done: the next is that of a restart.
    let heard = bus.wait(990).group2(10, 7, &DEVICE);
    assert_eq!(heard.note, Some(Note::Restarted));
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::NonExistent);
}
