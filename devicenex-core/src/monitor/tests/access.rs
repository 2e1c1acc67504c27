//! Hello, Mini-who and ROAM.

use super::*;

/// Identifiers and data of the figures 3, 4 and 6: OA 127, serial number 0x11223344, vendor 0x0123, product 0x0456,
/// revision 2; the manager's serial number ends in 0x0001.
#[test]
fn a_device_gets_an_address() {
    let mut bus = Bus::new();
    let data = [0x22, 0x11, 0x23, 0x01, 0x56, 0x04, 0x02, 0x00];
    let heard = bus.extended(0x1FFE_4433, &data);
    assert_eq!((heard.kind, heard.stage, heard.src), (Kind::HelloRequest, Some(Stage::First), Some(127)));
    assert_eq!(heard.text, "Hello 1 OA 127  vendor 291, product 1110, revision 2, serial 0x11223344");
    bus.wait(1000);
    assert_eq!(bus.extended(0x1FFE_4433, &data).stage, Some(Stage::Second));
    assert_eq!(bus.monitor.nodes().next().unwrap().access, AccessState::SecondHello);
    bus.wait(1000);
    let asked = bus.frame(&Frame::remote(extended_id(0x1FFE_0100), 8).unwrap());
    assert_eq!((asked.kind, asked.src, asked.problem), (Kind::MiniWho, None, None));
    assert_eq!(asked.text, "Mini-who  serial ending in 0x0001");
    let heard = bus.extended(0x1FFE_4433, &data);
    assert_eq!((heard.stage, heard.answers(), heard.assumed), (Some(Stage::Asked), Some(asked.n), false));
    assert!(heard.text.starts_with("Hello OA 127  "), "{}", heard.text);
    assert_eq!(bus.monitor.nodes().next().unwrap().access, AccessState::Standby);

    let roam = bus.extended(0x1EFE_4433, &[0x22, 0x11, 0x23, 0x01, 0x56, 0x04, 0x02, 0x43]);
    assert_eq!((roam.kind, roam.dst, roam.problem), (Kind::Roam, Some(127), None));
    assert_eq!(roam.text, "ROAM to OA 67  vendor 291, product 1110, revision 2, serial 0x11223344");
    let heard = bus.extended(0x1F86_4433, &data);
    assert_eq!((heard.stage, heard.answers(), heard.src), (Some(Stage::First), Some(roam.n), Some(67)));
    bus.wait(1000);
    assert_eq!(bus.extended(0x1F86_4433, &data).stage, Some(Stage::Second));
    bus.wait(1000).mini_who(1);
    let nodes: Vec<_> = bus.monitor.nodes().collect();
    let [node] = &nodes[..] else { panic!("{nodes:?}") };
    assert_eq!((node.address, node.access, node.traffic.frames), (oa(67), AccessState::OnLine, 2));
    assert_eq!(node.device, Some(device(0x1122_3344)));
}

#[test]
fn the_manager_is_known_by_its_serial_number() {
    let mut bus = Bus::new();
    bus.join(1, device(0x0000_0001));
    let heard = bus.mini_who(1);
    assert_eq!((heard.src, &*heard.text), (Some(1), "Mini-who of 1"));
    assert_eq!(bus.node(1).roles, Roles::MANAGER);
    assert_eq!(bus.node(1).access, AccessState::OnLine);
    let heard = bus.mini_who(2);
    assert_eq!(heard.problem, Some(Problem::SecondManager { first: 1 }));
}

#[test]
fn a_roam_that_a_device_does_not_take_shows() {
    let mut bus = Bus::new();
    bus.join(127, device(7)).mini_who(1);
    bus.hello(127, device(7));
    let first = bus.roam(device(7), 5).n;
    let second = bus.roam(device(7), 5);
    assert_eq!(second.problem, Some(Problem::RoamWithoutEffect { n: first }));
    bus.wait(2000).mini_who(1);
    let heard = bus.hello(127, device(7));
    assert_eq!(heard.problem, Some(Problem::RoamWithoutEffect { n: second.n }));
    // It has none pending any more.
    bus.wait(2000).mini_who(1);
    assert_eq!(bus.hello(127, device(7)).problem, None);
}

#[test]
fn a_taken_address_is_told_to_the_newcomer() {
    let mut bus = Bus::new();
    bus.join(67, device(7));
    let asked = bus.hello(67, device(8));
    assert_eq!(asked.problem, Some(Problem::TwoIdentities { address: oa(67) }));
    let heard = bus.hello_of(67, Direction::Response, device(7));
    assert_eq!((heard.kind, heard.answers()), (Kind::HelloResponse, Some(asked.n)));
    assert_eq!(heard.problem, Some(Problem::AddressTaken { address: oa(67) }));
    assert_eq!(
        heard.text,
        "Hello response OA 67  vendor 291, product 1110, revision 2, serial 0x00000007  ! OA 67 is taken"
    );
    assert_eq!(bus.node(67).device, Some(device(7)));
    let heard = bus.hello(127, device(8));
    assert_eq!((heard.stage, heard.problem), (Some(Stage::First), None));
}

/// A node on line tells its address from time to time: [`Config::announcement`](crate::access::Config).
#[test]
fn an_announcement_is_no_refusal() {
    let mut bus = Bus::new();
    bus.join(67, device(7)).wait(10_000);
    let heard = bus.hello_of(67, Direction::Response, device(7));
    assert_eq!((heard.stage, heard.problem, heard.assumed), (Some(Stage::Announcement), None, false));
    assert!(heard.text.starts_with("Hello announcement OA 67  "), "{}", heard.text);
    // Two segments were joined.
    let heard = bus.wait(1000).hello_of(67, Direction::Response, device(8));
    assert_eq!(heard.problem, Some(Problem::TwoIdentities { address: oa(67) }));
}

/// The device that had the address is gone: nobody objects to the one that follows it, whether by ROAM or by itself.
#[test]
fn a_lost_device_is_replaced() {
    let mut bus = Bus::new();
    bus.join(67, device(7)).join(127, device(8));
    bus.roam(device(8), 67);
    let heard = bus.hello(67, device(8));
    assert_eq!((heard.note, heard.problem), (Some(Note::Replaced), None));
    bus.wait(1000).hello(67, device(8));
    bus.wait(1000);
    assert_eq!(bus.node(67).device, Some(device(8)));
}

#[test]
fn of_two_nodes_with_one_address_the_one_that_nobody_opposes_has_it() {
    let mut bus = Bus::new();
    bus.hello(5, device(7));
    assert_eq!(bus.hello(5, device(8)).code(), Some("two_identities"));
    assert_eq!(bus.node(5).access, AccessState::Contested);
    bus.wait(1000);
    let heard = bus.hello(5, device(8));
    assert_eq!((heard.stage, heard.problem, heard.note), (Some(Stage::Second), None, Some(Note::Replaced)));
    assert_eq!(bus.node(5).device, Some(device(8)));
}

#[test]
fn a_device_that_moves_leaves_its_address() {
    let mut bus = Bus::new();
    bus.join(5, device(7));
    let heard = bus.hello(6, device(7));
    assert_eq!((heard.note, heard.problem), (Some(Note::Moved { from: oa(5) }), None));
    assert_eq!(bus.node(5).access, AccessState::OffLine);
    let heard = bus.hello(127, device(7));
    assert_eq!(heard.note, Some(Note::Moved { from: oa(6) }));
}

#[test]
fn a_restart_is_noted() {
    let mut bus = Bus::new();
    bus.join(5, device(7)).wait(5000);
    let heard = bus.hello(5, device(7));
    assert_eq!((heard.note, heard.stage), (Some(Note::Restarted), Some(Stage::First)));
    bus.join(127, device(8)).wait(5000);
    let heard = bus.hello(127, device(8));
    assert_eq!((heard.note, heard.stage), (Some(Note::Restarted), Some(Stage::First)));
}

/// The chance is 2^-16 for a pair, and the paper has no remedy.
#[test]
fn two_devices_with_one_half_of_a_serial_number_are_told() {
    let mut bus = Bus::new();
    bus.hello(127, device(0x0001_2345));
    let heard = bus.hello(127, device(0x0002_2345));
    assert_eq!(heard.problem, Some(Problem::SharedSerialHalf { serial_low: 0x2345 }));
    assert_eq!(bus.monitor.nodes().count(), 2);
}

#[test]
fn a_device_that_answers_in_the_middle_of_a_recording_is_in_standby() {
    let mut bus = Bus::new();
    bus.mini_who(1);
    let heard = bus.hello(127, device(7));
    assert_eq!((heard.stage, heard.assumed), (Some(Stage::Asked), true));
    assert_eq!(bus.monitor.nodes().next().unwrap().access, AccessState::Standby);
}

#[test]
fn the_rules_of_network_access() {
    let good = [0x22, 0x11, 0x23, 0x01, 0x56, 0x04, 0x02, 0x00];
    for (id, data, code) in [
        (0x1FFE_4433, &good[..7], "too_short"),
        (0x1FFE_4433, &[], "too_short"),
        (0x1FFE_4433, &[0x22, 0x11, 0x23, 0x01, 0x56, 0x04, 0x02, 0x80], "reserved_bits"),
        (0x1FFF_4433, &good, "response_without_address"),
        (0x1EFE_4433, &[0x22, 0x11, 0x23, 0x01, 0x56, 0x04, 0x02, 0x7F], "reserved_value"),
        (0x1EFE_4433, &[0x22, 0x11, 0x23, 0x01, 0x56, 0x04, 0x02, 0xC3], "reserved_value"),
        (0x1EFE_4433, &good[..6], "too_short"),
        (0x1E0A_4433, &[0x22, 0x11, 0x23, 0x01, 0x56, 0x04, 0x02, 0x43], "roam_to_address"),
        (0x1EFF_4433, &good, "reserved_identifier"),
        (0x1800_0000, &[], "reserved_identifier"),
        (0x1BFF_FFFF, &[], "reserved_identifier"),
        // Class 11101 with F = 1.
        (0x1D86_0309, &[], "reserved_identifier"),
    ] {
        let heard = Bus::new().extended(id, data);
        assert_eq!(heard.code(), Some(code), "{id:08X} {data:02X?}: {}", heard.text);
    }
}

#[test]
fn what_is_not_devicenex_is_foreign() {
    let mut bus = Bus::new();
    // UCMM of DeviceNet, and an identifier that must not be used there either.
    for id in [0x782, 0x7EF, 0x7FF] {
        let heard = bus.standard(id, &[0x0A, 0x4B, 0, 0]);
        assert_eq!((heard.kind, heard.code()), (Kind::Foreign, Some("standard_identifier")));
    }
    for id in [0x1F0A_4433, 0x1EFE_4433, 0x1C86_0209, 0x0286_0007] {
        let heard = bus.frame(&Frame::remote(extended_id(id), 8).unwrap());
        assert_eq!((heard.kind, heard.code()), (Kind::Foreign, Some("remote_frame")), "{id:08X}");
    }
    assert_eq!(bus.frame(&Frame::remote(standard_id(0x123), 0).unwrap()).code(), Some("remote_frame"));
    let long = Frame::with_dlc(extended_id(0x0286_0007), 9, [0; 8]).unwrap();
    assert_eq!(bus.frame(&long).code(), Some("data_length_code"));
}
