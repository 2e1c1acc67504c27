//! What is compared with afterwards.

use powerlink_core::error::Symptom;
use powerlink_core::node::NodeCounters;

use super::super::device::Node;

/// The node before an input.
pub(in super::super) struct Before {
    pub(super) counters: [u32; 14],
    pub(super) foreign_frames: u32,
    pub(super) cumulative: Vec<u32>,
    pub(super) outputs: (u8, u32),
    pub(super) mapped: usize,
}

impl Before {
    pub(in super::super) fn of(node: &Node) -> Self {
        Self {
            counters: fields(node.counters()),
            foreign_frames: node.counters().foreign_frames,
            cumulative: cumulative(node),
            outputs: node.objects().outputs,
            mapped: node.dictionary().mappings.transmit.len(),
        }
    }
}

pub(super) fn fields(counters: &NodeCounters) -> [u32; 14] {
    let NodeCounters {
        bad_frames,
        other_destinations,
        foreign_frames,
        address_conflicts,
        echoes,
        unknown,
        commands_ignored,
        sdo_ignored,
        sdo_refused,
        pdo_errors,
        errors_untold,
        frames_lost,
        not_sent,
        events_lost,
    } = *counters;
    [
        bad_frames,
        other_destinations,
        foreign_frames,
        address_conflicts,
        echoes,
        unknown,
        commands_ignored,
        sdo_ignored,
        sdo_refused,
        pdo_errors,
        errors_untold,
        frames_lost,
        not_sent,
        events_lost,
    ]
}

pub(super) fn cumulative(node: &Node) -> Vec<u32> {
    Symptom::ALL.map(|symptom| node.dictionary().counters.of(symptom).cumulative).to_vec()
}
