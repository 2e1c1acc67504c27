//! A network that starts, and what it survives.

use rustix::process::Signal;

use crate::rig::{
    Cable, NODE_OPERATIONAL, OUTPUTS, Process, controlled, devicenet, is_running, managing, running,
};

#[test]
#[ignore = "needs a namespace"]
fn process_data_go_both_ways() {
    let cable = Cable::new("both0", "both1");
    let (mut node, mut manager) = (controlled(cable.0, &[]), managing(cable.1, &[]));
    manager.until_all(&["PreOperational1 -> PreOperational2: nodes configured"]);
    manager.until(NODE_OPERATIONAL);
    manager.until("node 1: inputs 050633");
    node.until_all(&["0x1C14/0 written", "0x6200/2 written", "0x1A00/0 written"]);
    node.until("PreOperational1 -> PreOperational2: SoC");
    node.until("PreOperational2 -> ReadyToOperate: NMTEnableReadyToOperate");
    node.until("ReadyToOperate -> Operational: NMTStartNode");
    node.until(OUTPUTS);
    let manager = manager.interrupted();
    assert_eq!(manager.code, 0, "{}", manager.err);
    assert!(manager.out.contains("ends in Operational: cycles"), "{}", manager.out);
    assert!(manager.err.contains("note: told every node NMTResetNode"), "{}", manager.err);
    // A reset restores outputs, and nobody may think that the last ones count.
    node.until("Operational -> ResetApplication: NMTResetNode");
    node.until("outputs 000000, not valid");
    assert_eq!(node.interrupted().code, 0);
}

/// What the node does not take is an object that the file does not name: its mapping.
#[test]
#[ignore = "needs a namespace"]
fn a_mapping_that_a_node_refuses_is_named() {
    let cable = Cable::new("ref0", "ref1");
    let path = std::env::temp_dir().join(format!("devicenet-refused-{}.toml", std::process::id()));
    let map = "map_inputs = [{ object = \"0x6000/1\", bits = 8 }, { object = \"0x7000/1\", bits = 16 }]";
    std::fs::write(&path, format!("[[node]]\nnode = 1\n{map}\n")).unwrap();
    let _node = controlled(cable.0, &[]);
    let command = ["powerlink", "mn", cable.1, path.to_str().unwrap(), "--allow-tx"];
    let mut manager = Process::spawn(&mut devicenet(&command));
    manager.until("node 1 does not take 0x1A00/0");
    let manager = manager.interrupted();
    let note = "note: node 1: 0x1A00/0 is its `map_inputs`: 0x6000/1 of 8 bits, 0x7000/1 of 16 bits";
    assert!(manager.err.contains(note), "{}", manager.err);
    std::fs::remove_file(&path).unwrap();
}

#[test]
#[ignore = "needs a namespace"]
fn mirrored_outputs_come_back_as_inputs() {
    let cable = Cable::new("mir0", "mir1");
    let (_node, mut manager) = (controlled(cable.0, &["--mirror"]), managing(cable.1, &[]));
    manager.until("node 1: inputs 02015a");
}

/// One end is down, and up again.
#[test]
#[ignore = "needs a namespace"]
fn a_cut_cable_is_survived() {
    let cable = Cable::new("cut0", "cut1");
    let (mut node, mut manager) = running(&cable);
    for end in [0, 1] {
        cable.set(end, "down");
        node.until("link down");
        manager.until_all(&["link down", "node 1 is lost: "]);
        cable.set(end, "up");
        node.until("link up");
        manager.until("link up");
        is_running(&mut node, &mut manager);
    }
    assert_eq!(manager.interrupted().code, 0);
    assert_eq!(node.interrupted().code, 0);
}

/// Both adapters are taken out, and put in again.
#[test]
#[ignore = "needs a namespace"]
fn adapters_that_were_unplugged_are_found_again() {
    let cable = Cable::new("plug0", "plug1");
    let (mut node, mut manager) = running(&cable);
    cable.unplug();
    node.until("link down");
    manager.until_all(&["link down", "node 1 is lost: "]);
    cable.plug();
    is_running(&mut node, &mut manager);
}

#[test]
#[ignore = "needs a namespace"]
fn a_managing_node_that_dies_is_replaced_by_another() {
    let cable = Cable::new("mn0", "mn1");
    let (mut node, manager) = running(&cable);
    // Killed, without a word to its node.
    drop(manager);
    node.until("Operational -> PreOperational1: ");
    node.until("outputs 5a0201, not valid");
    let mut manager = managing(cable.1, &[]);
    is_running(&mut node, &mut manager);
}

#[test]
#[ignore = "needs a namespace"]
fn a_controlled_node_that_dies_is_missed_and_started_again() {
    let cable = Cable::new("cn0", "cn1");
    let (node, mut manager) = running(&cable);
    drop(node);
    manager.until_all(&["PRes of node 1 lost", "node 1: no inputs", "node 1 is lost: "]);
    let mut node = controlled(cable.0, &[]);
    is_running(&mut node, &mut manager);
    drop(node);
    manager.until("node 1 is lost: ");
    let ended = manager.interrupted();
    assert_eq!(ended.code, 1);
    assert!(ended.err.contains("error: not operational in the end: node 1 (Absent)"), "{}", ended.err);
}

/// A node that was kept from running finds a backlog, answers nothing of it, and comes back.
#[test]
#[ignore = "needs a namespace"]
fn a_node_that_was_stopped_does_not_answer_what_is_over() {
    let cable = Cable::new("stop0", "stop1");
    let node = controlled(cable.0, &["--json"]);
    let mut manager = managing(cable.1, &[]);
    manager.until(NODE_OPERATIONAL);
    node.signal(Signal::STOP);
    manager.until("node 1 is lost: ");
    node.signal(Signal::CONT);
    manager.until(NODE_OPERATIONAL);
    let ended = node.interrupted();
    let last: serde_json::Value = serde_json::from_str(ended.out.lines().last().unwrap()).unwrap();
    assert!(last["counters"]["not_sent"].as_u64().unwrap() > 0, "{last}");
    assert_eq!((&last["event"], &last["node"]), (&"end".into(), &1.into()));
    // What came late was told as such.
    let late = manager.interrupted().out;
    assert!(late.lines().last().unwrap().contains("lost pres"), "{late}");
}
