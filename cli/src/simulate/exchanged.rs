//! What I/O frames have said already. What repeats itself is counted, not told.

use std::collections::HashMap;

use devicenet_core::monitor::{Kind, Reading};
use devicenex_core::monitor as nex;
use link_core::Frame;
use transport_mock::record::FrameRecord;

use super::said::Said;

/// I/O frames are told when they have other data than the last of their kind; the others are counted.
#[derive(Default)]
pub(super) struct Exchanged {
    /// Whether all are told.
    pub(super) all: bool,
    /// The last of each segment, identifier and fragment.
    told: HashMap<(usize, u32, Option<u8>), Known>,
    /// How many were not told since the last heading.
    pub(super) silent: u64,
    /// How many requests with their answers were not.
    pub(super) silent_polls: u64,
}

impl Exchanged {
    /// Whether the frame says nothing that the last of its kind has not said.
    pub(super) fn is_known(&mut self, record: &FrameRecord<'_>, said: &Said<'_>) -> bool {
        let io = match said {
            Said::DeviceNet(reading) => io_of_devicenet(reading),
            Said::DeviceNex(reading) => io_of_devicenex(reading),
        };
        let Some(Io { of, problem, is_fragment }) = io.filter(|_| !self.all) else { return false };
        let fragment = if is_fragment { record.frame.data().first().copied() } else { None };
        let key = (record.segment, record.frame.raw_id(), fragment);
        let known = Known { frame: *record.frame, problem, of };
        let last = self.told.insert(key, known);
        let is_known = last.is_some_and(|last| last.frame == *record.frame && last.problem == problem);
        self.silent += u64::from(is_known);
        is_known
    }

    /// The data of a slave, or of a device, are new again.
    pub(super) fn forget(&mut self, whose: u8) {
        self.told.retain(|_, known| known.of.is_some_and(|of| of != whose));
    }
}

struct Known {
    frame: Frame,
    /// What was wrong with it.
    problem: Option<&'static str>,
    /// Whose data they are: the MAC ID of the slave, the operational address of the sender.
    of: Option<u8>,
}

/// What there is to know of an I/O frame beside its data.
struct Io {
    of: Option<u8>,
    problem: Option<&'static str>,
    is_fragment: bool,
}

fn io_of_devicenet(reading: &Reading<'_>) -> Option<Io> {
    let of = match reading.kind {
        Kind::PollCommand | Kind::MulticastPollCommand | Kind::BitStrobeCommand => reading.dst,
        Kind::PollResponse
        | Kind::MulticastPollResponse
        | Kind::BitStrobeResponse
        | Kind::CosCyclic
        | Kind::CosCyclicAck
        | Kind::Io => reading.src,
        _ => return None,
    };
    let problem = reading.problem.map(|problem| problem.code());
    Some(Io { of: of.map(u8::from), problem, is_fragment: reading.frag.is_some() })
}

fn io_of_devicenex(reading: &nex::Reading<'_>) -> Option<Io> {
    let of = reading.src.map(|source| source.number());
    let problem = reading.problem.map(|problem| problem.code());
    reading.kind.is_io().then_some(Io { of, problem, is_fragment: reading.frag.is_some() })
}
