//! Attempts to send: the fields of frames and of errors.

use link_core::{BusErrorKind, Frame};
use serde::Serialize;
use transport_mock::Flag;
use transport_mock::bus::{BusError, Sender, SenderOutcome};
use transport_mock::record::FrameRecord;

use super::{hex, seconds};
use crate::simulate::sight::{Nodes, index};
use crate::simulate::text::field_name;

/// The fields of every attempt to send.
#[derive(Serialize)]
pub(super) struct Attempt<'a> {
    t: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    n: Option<u64>,
    nodes: Vec<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    segment: Option<usize>,
    #[serde(flatten)]
    wire: Wire,
}

/// The fields of every frame, as `decode` names them.
#[derive(Serialize)]
pub(super) struct Wire {
    id: u32,
    ext: bool,
    rtr: bool,
    dlc: u8,
    data: String,
}

#[derive(Serialize)]
pub(super) struct ErrorFields<'a> {
    error: BusErrorKind,
    #[serde(skip_serializing_if = "Option::is_none")]
    bit: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    field: Option<&'static str>,
    by: &'a str,
    flag: &'static str,
}

pub(super) fn attempt<'a>(nodes: &'a Nodes<'_>, record: &FrameRecord<'_>, n: Option<u64>) -> Attempt<'a> {
    let has_lost = |sender: &&Sender| matches!(sender.outcome, SenderOutcome::LostArbitration { .. });
    let senders = record.senders.iter().filter(|sender| !has_lost(sender));
    Attempt {
        t: seconds(record.end),
        n,
        nodes: senders.map(|sender| nodes.name(index(sender.node))).collect(),
        // The bus, or the others when some are apart, have no number.
        segment: Some(record.segment).filter(|segment| *segment > 0),
        wire: Wire::of(record.frame),
    }
}

pub(super) fn error_fields<'a>(nodes: &'a Nodes<'_>, error: &BusError) -> ErrorFields<'a> {
    ErrorFields {
        error: error.kind,
        bit: error.place.map(|(bit, _)| bit),
        field: error.place.map(|(_, field)| field_name(field)),
        by: nodes.name(index(error.node)),
        flag: match error.flag {
            Flag::Active => "active",
            Flag::Passive => "passive",
            Flag::None => "none",
        },
    }
}

impl Wire {
    fn of(frame: &Frame) -> Self {
        Self {
            id: frame.raw_id(),
            ext: frame.is_extended(),
            rtr: frame.is_remote(),
            dlc: frame.dlc(),
            data: hex(frame.data()),
        }
    }
}
