//! Others on the cable, who keep to nothing.

use link_core::ethernet::{Input, LinkEvent, Port as _};
use transport_ethernet::{EthernetPort, Interface, Options};

use crate::namespace::ip;
use crate::rig::{Cable, NODE_OPERATIONAL, controlled, managing};

/// Frames of the right EtherType with anything in them, of every length, from one byte to more than an adapter may send.
#[test]
#[ignore = "needs a namespace"]
fn garbage_is_counted_and_disturbs_nobody() {
    let cable = Cable::new("gar0", "gar1");
    for end in [cable.0, cable.1] {
        ip(&["link", "set", end, "mtu", "9000"]);
    }
    let mut node = controlled(cable.0, &["--json"]);
    let mut manager = managing(cable.1, &[]);
    manager.until(NODE_OPERATIONAL);
    let mut port = EthernetPort::open(cable.1, Options::new(0x88AB)).unwrap();
    let node_mac = Interface::find(cable.0).unwrap().mac();
    let destinations = [node_mac.0, [0x01, 0x11, 0x1E, 0, 0, 2], [0x01, 0x11, 0x1E, 0, 0, 4], [0xFF; 6]];
    let mut seed = 1_u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        seed.to_be_bytes()[1]
    };
    for (number, len) in
        [0, 1, 2, 3, 5, 9, 22, 46, 300, 1500, 1501, 8900].into_iter().cycle().take(600).enumerate()
    {
        let mut frame = destinations[number % destinations.len()].to_vec();
        frame.extend([0x02, 0, 0, 0, 0, 0x77, 0x88, 0xAB]);
        // Anything but SoC, SoA and what is for this node: that would be obeyed.
        let of_header = |at: usize| [[0x03, 0x04, 0x06, 0x09][number % 4], 99].get(at).copied();
        frame.extend((0..len).map(|at| of_header(at).unwrap_or_else(&mut random)));
        port.transmit(&frame).unwrap();
    }
    node.until("bad_frame");
    node.until("lost\",\"frames");
    let manager = manager.interrupted();
    assert!(manager.code == 0 && !manager.out.contains("is lost"), "{}", manager.out);
    let ended = node.interrupted();
    let last: serde_json::Value = serde_json::from_str(ended.out.lines().last().unwrap()).unwrap();
    let counted = |name: &str| last["counters"][name].as_u64().unwrap();
    assert!(counted("bad_frames") > 0 && counted("frames_lost") > 0 && counted("echoes") == 0, "{last}");
}

/// The number of lines does not follow the number of frames, and every frame is in one of them.
#[test]
#[ignore = "needs a namespace"]
fn a_flood_of_equal_frames_is_told_with_its_number() {
    let cable = Cable::new("flo0", "flo1");
    let mut node = controlled(cable.0, &["--json"]);
    node.until("NMT_NOT_ACTIVE");
    let mut port = EthernetPort::open(cable.1, Options::new(0x88AB)).unwrap();
    // It sends as soon as there is a link.
    assert!(matches!(port.wait(None), Ok((_, Input::Link(LinkEvent::Up)))));
    let mac = Interface::find(cable.0).unwrap().mac().0;
    // A PReq that ends within its Size.
    let short = [&mac[..], &[2, 0, 0, 0, 0, 0x77, 0x88, 0xAB, 3, 1, 240, 0, 0, 0, 0, 0, 1]].concat();
    for _ in 0..2_000 {
        port.transmit(&short).unwrap();
    }
    node.until("\"count\":");
    let ended = node.interrupted();
    let lines: Vec<serde_json::Value> =
        ended.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let told: Vec<_> = lines.iter().filter(|line| line["event"] == "bad_frame").collect();
    let frames: u64 = told.iter().map(|line| line["count"].as_u64().unwrap_or(1)).sum();
    assert_eq!(lines.last().unwrap()["counters"]["bad_frames"], frames);
    assert!(frames > 1_000 && told.len() < 10, "{frames} frames, {} lines", told.len());
}

/// Frames that are obeyed, as fast as they can be sent: the node changes its state with many of them, and says so now and then.
#[test]
#[ignore = "needs a namespace"]
fn a_flood_of_cycles_is_told_in_few_lines() {
    let cable = Cable::new("soc0", "soc1");
    let mut node = controlled(cable.0, &["--json"]);
    node.until("NMT_NOT_ACTIVE");
    let mut port = EthernetPort::open(cable.1, Options::new(0x88AB)).unwrap();
    assert!(matches!(port.wait(None), Ok((_, Input::Link(LinkEvent::Up)))));
    let frame = |group: u8, message: &[u8]| {
        let header = [0x01, 0x11, 0x1E, 0, 0, group, 2, 0, 0, 0, 0, 0x77, 0x88, 0xAB];
        let mut frame = [&header[..], message].concat();
        frame.resize(60, 0);
        frame
    };
    // The managing node is in PreOperational1; a cycle begins; NMTResetConfiguration, NMTStopNode, NMTEnterPreOperational2.
    let command = |id: u8| frame(4, &[6, 255, 240, 4, id]);
    let frames = [
        frame(3, &[5, 255, 240, 0x1D]),
        frame(1, &[1, 255, 240]),
        command(0x2A),
        command(0x22),
        command(0x23),
    ];
    for number in 0..20_000 {
        port.transmit(&frames[number % frames.len()]).unwrap();
    }
    node.until("(the last of ");
    let ended = node.interrupted();
    let lines: Vec<serde_json::Value> =
        ended.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let changes: Vec<_> = lines.iter().filter(|line| line["event"] == "state_changed").collect();
    let all: u64 = changes.iter().map(|line| line["count"].as_u64().unwrap_or(1)).sum();
    let seconds = lines.last().unwrap()["t"].as_f64().unwrap();
    // 30 and the last of the others, in every second that was begun.
    let full = u32::try_from(changes.len() / 31).unwrap();
    assert!(
        all > 1_000 && f64::from(full) < seconds + 2.0,
        "{all} changes, {} lines in {seconds} s",
        changes.len()
    );
    // The end of what was held back is what the node is in the end.
    assert_eq!(changes.last().unwrap()["to"], lines.last().unwrap()["state"]);
}
