//! One file on the simulated bus and on one of a real kernel: the same frames, but for their times.

use std::collections::BTreeMap;

use link_core::Id;

use super::process::{Process, wait_for_listeners};
use super::real_kernel::Interface;
use super::witness::Witness;
use crate::devicenet;
use crate::record::file;

/// What belongs together, and has one order. Which of two conversations is ahead of the other is a matter of time: how long a bit is, when
/// a process is started, how fast a machine answers.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
enum Conversation {
    /// Network access of a node, and explicit messages between it and its master.
    Explicit(u16),
    /// A poll command and its response; also what a master sends to a slave of the other kinds.
    Command(u16),
    /// Change of state and cyclic, what a slave sends. It does not wait for its acknowledgement, nor for its master to be ready.
    StateChange(u16),
    /// The acknowledgements of that.
    Acknowledge(u16),
    /// The command to all slaves, and the response of the one.
    BitStrobe,
    Multicast,
}

impl Conversation {
    const fn is_io(self) -> bool {
        !matches!(self, Self::Explicit(_))
    }
}

/// By the identifiers of the predefined connection set (CIP Vol. 3, chapter 3), and by Group 3 for the UCMM and the connections that it
/// opens. `header` is the first byte of data.
fn conversation(id: u16, header: u16) -> Conversation {
    use Conversation::{Acknowledge, BitStrobe, Command, Explicit, Multicast, StateChange};
    match id {
        0x000..0x400 => match (id >> 6, id & 0x3F) {
            (0xC, _) => Multicast,
            (0xD, mac) => StateChange(mac),
            (0xE, _) => BitStrobe,
            (_, mac) => Command(mac),
        },
        0x400..0x600 => match (id & 7, id >> 3 & 0x3F) {
            (0, _) => BitStrobe,
            (1, _) => Multicast,
            (2, mac) => Acknowledge(mac),
            (5, mac) => Command(mac),
            (_, mac) => Explicit(mac),
        },
        // To whom the master sends is in the header.
        _ if id & 0x3F == MASTER => Explicit(header & 0x3F),
        _ => Explicit(id & 0x3F),
    }
}

type Trace = BTreeMap<Conversation, Vec<String>>;

/// The frames of a candump log, each as `id#data`.
fn trace(file: &std::path::Path) -> Trace {
    let mut trace = Trace::new();
    for line in std::fs::read_to_string(file).unwrap().lines() {
        let frame = line.split_whitespace().nth(2).unwrap();
        let (id, data) = frame.split_once('#').unwrap();
        let hex = |digits| u16::from_str_radix(digits, 16).unwrap();
        let header = data.get(..2).map_or(0, hex);
        trace.entry(conversation(hex(id), header)).or_default().push(frame.to_owned());
    }
    trace
}

#[test]
#[ignore = "needs vcan"]
fn the_simulated_bus_and_the_real_one_carry_the_same_frames() {
    let simulated = file("simulated.log");
    let run =
        devicenet(&["simulate", "every-kind.toml", "--summary", "--record", simulated.to_str().unwrap()]);
    assert_eq!(run.code(), 0, "{}", run.err());
    let simulated = trace(&simulated);

    let bus = Interface::new("vcan95");
    let real = file("real.log");
    let path = real.to_str().unwrap();
    // From the first frame on.
    let trigger = ["--trigger", "kind=dup_mac_request", "--after", "1h", "-o", path];
    let record = Process::start(&[&["record", bus.0][..], &trigger].concat());
    wait_for_listeners(bus.0, 1);
    let mut slaves = SLAVES.map(|name| Process::node("slave", bus.0, "every-kind.toml", name));
    slaves.iter_mut().for_each(|slave| slave.until("-> OnLine"));
    let mut witness = Witness::on(bus.0);
    let master = Process::node("master", bus.0, "every-kind.toml", "scanner");
    // One more than is compared: who records may be a frame behind.
    let mut missing: BTreeMap<Conversation, usize> =
        simulated.keys().filter(|conversation| conversation.is_io()).map(|io| (*io, IO + 1)).collect();
    witness.until("I/O of every slave", |frame| {
        let Id::Standard(id) = frame.id() else { panic!("{frame}") };
        let conversation =
            conversation(id.as_raw(), frame.data().first().copied().unwrap_or_default().into());
        if let Some(missing) = missing.get_mut(&conversation) {
            *missing = missing.saturating_sub(1);
        }
        missing.values().all(|count| *count == 0)
    });
    // Before the master releases its slaves, of which the simulated one knows nothing.
    assert_eq!(record.interrupted().code, 1);
    assert_eq!(master.interrupted().code, 0);

    let real = trace(&real);
    let conversations = |trace: &Trace| trace.keys().copied().collect::<Vec<_>>();
    assert_eq!(conversations(&real), conversations(&simulated));
    for (conversation, frames) in &simulated {
        // I/O goes on for as long as the bus, on one longer than on the other.
        let end = if conversation.is_io() { IO } else { usize::MAX };
        let beginning = |frames: &[String]| frames[..end.min(frames.len())].join("\n");
        assert_eq!(beginning(&real[conversation]), beginning(frames), "{conversation:?}");
    }
}

const SLAVES: [&str; 7] = ["valve", "eye", "panel", "gauge", "drive", "lamp", "both"];
const MASTER: u16 = 1;
/// How many frames of each conversation with I/O are compared.
const IO: usize = 12;
