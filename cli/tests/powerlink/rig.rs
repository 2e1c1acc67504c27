//! A managing node and a controlled node at the ends of a cable.

use std::process::Command;

pub(crate) use crate::namespace::Cable;
pub(crate) use crate::process::Process;

/// The command with these arguments.
pub(crate) fn devicenet(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_devicenet"));
    command.args(arguments).current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/powerlink"));
    command
}

/// A node as `network.toml` wants it, with the inputs 0x33 (digital) and 0x0605 (analog).
pub(crate) const NODE: [&str; 18] = [
    "--node",
    "1",
    "--vendor",
    "0x123",
    "--product",
    "7",
    "--revision",
    "1",
    "--serial",
    "42",
    "--digital",
    "1",
    "--analog",
    "1",
    "--inputs",
    "330506",
    "--answer-within",
    "20ms",
];

pub(crate) fn controlled(interface: &str, more: &[&str]) -> Process {
    Process::spawn(devicenet(&["powerlink", "cn", interface, "--allow-tx"]).args(NODE).args(more))
}

pub(crate) fn managing(interface: &str, more: &[&str]) -> Process {
    Process::spawn(devicenet(&["powerlink", "mn", interface, "network.toml", "--allow-tx"]).args(more))
}

pub(crate) const OUTPUTS: &str = "outputs 5a0201";
pub(crate) const NODE_OPERATIONAL: &str = "ReadyToOperate -> Operational: state shown";

/// Both, when they exchange process data.
pub(crate) fn running(cable: &Cable) -> (Process, Process) {
    let mut node = controlled(cable.0, &[]);
    let mut manager = managing(cable.1, &[]);
    is_running(&mut node, &mut manager);
    (node, manager)
}

/// Waits until process data go both ways.
#[track_caller]
pub(crate) fn is_running(node: &mut Process, manager: &mut Process) {
    manager.until(NODE_OPERATIONAL);
    manager.until("node 1: inputs 050633");
    node.until("ReadyToOperate -> Operational: NMTStartNode");
}
