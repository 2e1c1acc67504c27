//! The end of a session, and what is recorded of it.

use std::io::{BufRead as _, BufReader};
use std::process::Stdio;

use link_core::ethernet::{Input, LinkEvent, Port as _};
use rustix::process::Signal;
use transport_ethernet::{EthernetPort, Options};

use crate::rig::{Cable, NODE_OPERATIONAL, controlled, devicenet, managing};

#[test]
#[ignore = "needs a namespace"]
fn a_session_ends_when_its_time_is_over() {
    let cable = Cable::new("end0", "end1");
    let ended = controlled(cable.0, &["--for", "100ms"]).ended();
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(ended.out.contains("ends in NotActive"), "{}", ended.out);
    // Nobody answers.
    let ended = managing(cable.1, &["--for", "100ms"]).ended();
    assert_eq!(ended.code, 1, "{}", ended.err);
    let words = "not operational in the end: node 1 (Absent), the managing node (";
    assert!(ended.err.contains(words), "{}", ended.err);
}

/// As `timeout` sends them: to the program, and to its group, in which the program is.
#[test]
#[ignore = "needs a namespace"]
fn two_signals_right_behind_one_another_are_one() {
    let cable = Cable::new("two0", "two1");
    let (_node, mut manager) = (controlled(cable.0, &[]), managing(cable.1, &[]));
    manager.until(NODE_OPERATIONAL);
    manager.signal(Signal::INT);
    manager.signal(Signal::TERM);
    let ended = manager.ended();
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(ended.err.contains("note: told every node NMTResetNode"), "{}", ended.err);
}

/// As with `| head`: nobody reads on, and the nodes are reset all the same.
#[test]
#[ignore = "needs a namespace"]
fn a_manager_that_nobody_listens_to_any_more_resets_its_nodes() {
    let cable = Cable::new("pipe0", "pipe1");
    let mut node = controlled(cable.0, &[]);
    let mut manager = devicenet(&["powerlink", "mn", cable.1, "network.toml", "--allow-tx"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(manager.stdout.take().unwrap()).lines().map(Result::unwrap);
    let told: Vec<String> = lines.take_while(|line| !line.contains(NODE_OPERATIONAL)).collect();
    assert!(told[0].contains(" starts; time 0 is "), "{told:?}");
    node.until("ReadyToOperate -> Operational: NMTStartNode");
    // It would tell of this.
    let mut port = EthernetPort::open(cable.0, Options::new(0x88AB)).unwrap();
    assert!(matches!(port.wait(None), Ok((_, Input::Link(LinkEvent::Up)))));
    port.transmit(&[&[0xFF; 6][..], &[2, 0, 0, 0, 0, 0x77, 0x88, 0xAB, 4, 255, 9]].concat()).unwrap();
    node.until("Operational -> ResetApplication: NMTResetNode");
    let ended = manager.wait_with_output().unwrap();
    let err = String::from_utf8(ended.stderr).unwrap();
    assert!(ended.status.success() && err.contains("note: told every node NMTResetNode"), "{err}");
}

#[test]
#[ignore = "needs a namespace"]
fn an_interface_without_a_link_is_waited_for() {
    let cable = Cable::new("late0", "late1");
    cable.set(0, "down");
    let mut node = controlled(cable.0, &[]);
    node.until("NotActive");
    cable.set(0, "up");
    node.until("link up");
    let ended = node.interrupted();
    assert!(
        ended
            .err
            .contains("late0 has no link, and is waited for; if it is down, as root: ip link set late0 up"),
        "{}",
        ended.err
    );
}

/// Both ends record the same frames, each with its own times.
#[test]
#[ignore = "needs a namespace"]
fn what_is_sent_and_received_is_recorded() {
    let folder = std::env::temp_dir().join(format!("devicenet-powerlink-{}", std::process::id()));
    std::fs::create_dir(&folder).unwrap();
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let (of_node, of_manager) = (file("node.pcap"), file("manager.pcap"));
    let cable = Cable::new("rec0", "rec1");
    let node = controlled(cable.0, &["--record", &of_node]);
    let mut manager = managing(cable.1, &["--record", &of_manager]);
    manager.until(NODE_OPERATIONAL);
    manager.interrupted();
    node.interrupted();
    let [one, other] = [&of_node, &of_manager].map(|path| frames(path));
    assert!(one.len() > 50);
    // The managing node may have begun before the other listened.
    let begin = other.len() - one.len();
    assert_eq!(one, other[begin..]);
    // A file is never written over, and standard output has the lines.
    for (path, told) in [
        (
            &*of_node,
            "node.pcap: cannot be recorded to: it exists, and is not written over; name another file",
        ),
        ("-", "error: --record -: standard output has the lines of the station; record into a file\n"),
    ] {
        let again = devicenet(&["powerlink", "cn", cable.0, "--node", "1", "--allow-tx", "--record", path])
            .output()
            .unwrap();
        let err = String::from_utf8(again.stderr).unwrap();
        assert!(again.status.code() == Some(2) && err.contains(told), "{err}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

fn frames(path: &str) -> Vec<Vec<u8>> {
    let mut reader = pcap_file::pcap::PcapReader::new(std::fs::File::open(path).unwrap()).unwrap();
    assert_eq!(reader.header().datalink, pcap_file::DataLink::ETHERNET);
    let mut frames = Vec::new();
    while let Some(packet) = reader.next_packet() {
        frames.push(packet.unwrap().data.into_owned());
    }
    frames
}
