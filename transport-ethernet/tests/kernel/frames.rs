//! Frames that arrive, and those that do not.

use link_core::ethernet::{Input, LinkEvent, MAX_FRAME, Port as _};
use link_core::machine::Deadline;
use transport_ethernet::{Error, EthernetPort, Interface, Options};

use crate::namespace::ip;
use crate::rig::{Cable, GROUP, Heard, OPTIONS, frame, frame_of, heard, port, silent};

#[test]
#[ignore = "needs a namespace"]
fn a_frame_arrives_at_the_other_end_and_does_not_come_back() {
    let cable = Cable::new("fr0", "fr1");
    let (mut one, mut other) = (port(cable.0, OPTIONS), port(cable.1, OPTIONS));
    for len in [0, 1, 46, 1500] {
        let sent = frame(&vec![0x5A; len]);
        one.transmit(&sent).unwrap();
        assert_eq!(heard(&mut other), Heard::Frame(sent));
    }
    silent(&mut one);
    assert_eq!(one.interface(), &Interface::find(cable.0).unwrap());
    assert_eq!(one.interface().mac().0[..2], [0x02, 0x00]);
}

/// However late it is read; and a deadline that has passed does not come before it. The kernel's clock and that of the port are measured
/// against one another, which a busy machine can disturb, but not every time.
#[test]
#[ignore = "needs a namespace"]
fn the_time_of_a_frame_is_when_it_arrived() {
    let cable = Cable::new("ti0", "ti1");
    let is_of_its_time = |_| {
        let (mut one, mut other) = (port(cable.0, OPTIONS), port(cable.1, OPTIONS));
        let before = other.now();
        one.transmit(&frame(b"early")).unwrap();
        let after = other.now();
        std::thread::sleep(core::time::Duration::from_millis(30));
        let (at, input) = other.wait(Some(Deadline { at: after, why: "the test" })).unwrap();
        assert!(matches!(input, Input::Frame(_)));
        silent(&mut other);
        let slack = core::time::Duration::from_millis(5);
        before.saturating_sub(slack) <= at && at <= after + slack
    };
    assert!((0..50).any(is_of_its_time));
}

#[test]
#[ignore = "needs a namespace"]
fn other_protocols_and_other_interfaces_are_not_heard() {
    let (cable, elsewhere) = (Cable::new("by0", "by1"), Cable::new("by2", "by3"));
    let mut listener = port(cable.1, OPTIONS);
    let mut other_protocol = port(cable.0, Options::new(0x88B6));
    other_protocol.transmit(&frame_of(0x88B6, b"other protocol")).unwrap();
    port(elsewhere.0, OPTIONS).transmit(&frame(b"other cable")).unwrap();
    silent(&mut listener);
}

#[test]
#[ignore = "needs a namespace"]
fn groups_are_joined_and_left() {
    let cable = Cable::new("gr0", "gr1");
    let members = || {
        let table = std::fs::read_to_string("/proc/thread-self/net/dev_mcast").unwrap();
        let address: String = GROUP.0.iter().map(|byte| format!("{byte:02x}")).collect();
        table.lines().filter(|line| line.contains("gr0") && line.contains(&address)).count()
    };
    assert_eq!(members(), 0);
    let port = port(cable.0, OPTIONS);
    assert_eq!(members(), 1);
    drop(port);
    assert_eq!(members(), 0);
}

#[test]
#[ignore = "needs a namespace"]
fn frames_that_are_too_long_are_counted() {
    let cable = Cable::new("lo0", "lo1");
    for end in [cable.0, cable.1] {
        ip(&["link", "set", end, "mtu", "9000"]);
    }
    let (mut one, mut other) = (port(cable.0, OPTIONS), port(cable.1, OPTIONS));
    for _ in 0..3 {
        one.transmit(&frame(&vec![0; 1501])).unwrap();
    }
    one.transmit(&frame(b"next")).unwrap();
    assert_eq!(heard(&mut other), Heard::Link(LinkEvent::FramesLost { count: 3 }));
    assert_eq!(heard(&mut other), Heard::Frame(frame(b"next")));
    // Longer than the interface allows, and too short to have a header.
    for bad in [vec![0; 20_000], vec![0; 5]] {
        one.transmit(&bad).unwrap();
        assert_eq!(heard(&mut one), Heard::Link(LinkEvent::NotSent));
    }
    silent(&mut other);
    assert_eq!(frame(&vec![0; 1500]).len(), MAX_FRAME);
}

#[test]
#[ignore = "needs a namespace"]
fn frames_for_which_there_was_no_room_are_counted() {
    const SENT: u32 = 20_000;
    let cable = Cable::new("dr0", "dr1");
    let (mut one, mut other) = (port(cable.0, OPTIONS), port(cable.1, OPTIONS));
    for number in 0..SENT {
        one.transmit(&frame(&number.to_be_bytes())).unwrap();
    }
    let mut received = 0;
    loop {
        match crate::rig::wait(&mut other, core::time::Duration::ZERO) {
            Heard::Frame(bytes) => {
                assert_eq!(bytes, frame(&u32::to_be_bytes(received)), "the queue keeps the oldest");
                received += 1;
            }
            Heard::Nothing => break,
            event @ Heard::Link(_) => panic!("{event:?}"),
        }
    }
    assert!(received < SENT, "there was room for all");
    // The count comes with the next frame that there was room for.
    one.transmit(&frame(b"room")).unwrap();
    assert_eq!(heard(&mut other), Heard::Link(LinkEvent::FramesLost { count: SENT - received }));
    assert_eq!(heard(&mut other), Heard::Frame(frame(b"room")));
    silent(&mut one);
}

#[test]
#[ignore = "needs a namespace"]
fn wrong_names_and_numbers_are_answered_with_what_there_is() {
    let cable = Cable::new("wr0", "wr1");
    let error = EthernetPort::open("rw0", OPTIONS).unwrap_err();
    assert!(
        matches!(&error, Error::NoInterface { present, .. } if present.contains(&cable.0.to_owned())),
        "{error}"
    );
    assert!(matches!(EthernetPort::open("lo", OPTIONS), Err(Error::NotEthernet { .. })));
    assert!(matches!(EthernetPort::open(cable.0, Options::new(0x05FF)), Err(Error::NotAnEtherType(0x05FF))));
}

/// As a user without rights: who is root in this namespace drops them all.
#[test]
#[ignore = "needs a namespace"]
fn a_missing_right_is_told_with_the_command_that_gives_it() {
    let cable = Cable::new("ri0", "ri1");
    let this = std::env::current_exe().unwrap();
    let output = std::process::Command::new("setpriv")
        .args(["--bounding-set=-all", "--no-new-privs"])
        .arg(&this)
        .args(["--ignored", "--exact", "frames::without_the_right"])
        .env("DEVICENET_TEST_INTERFACE", cable.0)
        .output()
        .unwrap();
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success() && out.contains("1 passed"), "{out}{err}");
}

#[test]
#[ignore = "the test before runs it"]
fn without_the_right() {
    let Some(name) = std::env::var_os("DEVICENET_TEST_INTERFACE") else { return };
    let name = name.into_string().unwrap();
    let error = EthernetPort::open(&name, OPTIONS).unwrap_err();
    assert!(matches!(error, Error::NoRight { .. }), "{error}");
    let words = error.to_string();
    assert!(words.contains("setcap cap_net_raw+ep /") && words.contains("as root"), "{words}");
}
