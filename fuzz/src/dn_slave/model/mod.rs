//! A slave once more, as small as the tables of CIP Vol. 3 allow: connections and their timers, ownership, explicit
//! messages and their fragments, I/O. Network access is not in it: it has a target of its own, and here it is asked
//! whether the node is on line.

mod allocation;
mod connections;
mod io;
mod objects;
mod pipe;
mod ports;

use devicenet_core::slave::{Config, IoMode, Options};
use link_core::Instant;

use super::device::Device;
use crate::fragment::reference::IoReceiver;
use connections::{Connection, Kind, Parent};
use io::Line;
pub(super) use pipe::LONGEST;
use pipe::{Piece, Pipe};
pub(super) use ports::Sender;

#[derive(Clone, Debug)]
pub(super) struct Model {
    options: Options,
    resolution: u16,
    pub(super) mac: u8,
    pub(super) now: Instant,
    pub(super) online: bool,
    pub(super) explicit: Connection,
    /// Instances 2 to 5, and what they were allocated as.
    pub(super) io: [Connection; 4],
    kinds: [Kind; 4],
    pub(super) dynamic: Vec<Dynamic>,
    held: u8,
    pub(super) master: Option<u8>,
    parent: Parent,
    pub(super) group: u8,
    pub(super) inputs: [Vec<u8>; 4],
    pub(super) outputs: [Vec<u8>; 4],
    pub(super) modes: [IoMode; 4],
    receivers: [IoReceiver; 4],
    pub(super) lines: [Line; 4],
    /// Of the predefined explicit connection, then of the dynamic ones.
    pub(super) pipes: Vec<Pipe>,
    /// Responses of the unconnected ports that wait: on the line of the UCMM or not, data field.
    answers: Vec<(bool, Vec<u8>)>,
    explicit_in_flight: Option<ports::Sent>,
    explicit_withdraw: bool,
    ucmm_in_flight: Option<ports::Sent>,
    ucmm_withdraw: bool,
    /// Of instance 4.
    pending: bool,
    retries: u8,
    trigger: Option<Instant>,
    inhibit: Option<Instant>,
    acknowledge: Option<Instant>,
    acknowledge_time: u16,
    retry_limit: u8,
    /// The node leaves when the response on this pipe is sent.
    pub(super) leaving: Option<usize>,
}

/// A connection that was opened through the UCMM.
#[derive(Clone, Debug)]
pub(super) struct Dynamic {
    pub(super) connection: Connection,
    pub(super) client: u8,
    format: u8,
    pub(super) group: Group,
    request: u8,
    response: u8,
    /// What is with the controller; nothing if it does not matter any more.
    in_flight: Option<Option<Piece>>,
    withdraw: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Group {
    One,
    Two,
    Three,
}

impl Dynamic {
    const CLOSED: Self = Self {
        connection: Connection::NONE,
        client: 0,
        format: 0,
        group: Group::Three,
        request: 0,
        response: 0,
        in_flight: None,
        withdraw: false,
    };

    pub(super) fn consumed(&self, own: u8) -> u16 {
        let (request, client, own) = (u16::from(self.request), u16::from(self.client), u16::from(own));
        match self.group {
            Group::One => request << 6 | client,
            Group::Two => 0x400 | own << 3 | request,
            Group::Three => 0x600 | request << 6 | client,
        }
    }

    fn produced(&self, own: u8) -> u16 {
        let (response, own) = (u16::from(self.response), u16::from(own));
        match self.group {
            Group::One => response << 6 | own,
            Group::Two => 0x400 | own << 3 | response,
            Group::Three => 0x600 | response << 6 | own,
        }
    }
}

impl Model {
    pub(super) fn new(config: &Config, device: &Device, dynamic: usize) -> Self {
        let receivers =
            [0, 1, 2, 3].map(|at: usize| IoReceiver::new(LONGEST_IO.max(device.outputs[at].len())));
        Self {
            options: config.options,
            resolution: config.resolution.millis(),
            mac: config.access.mac_id.number(),
            now: Instant::ZERO,
            online: false,
            explicit: Connection::NONE,
            io: [Connection::NONE; 4],
            kinds: [Kind::Polled; 4],
            dynamic: vec![Dynamic::CLOSED; dynamic],
            held: 0,
            master: None,
            parent: Parent::Predefined,
            group: 0,
            inputs: device.inputs.clone(),
            outputs: device.outputs.clone(),
            modes: [IoMode::Inactive; 4],
            receivers,
            lines: Default::default(),
            pipes: vec![Pipe::new(); dynamic + 1],
            answers: Vec::new(),
            explicit_in_flight: None,
            explicit_withdraw: false,
            ucmm_in_flight: None,
            ucmm_withdraw: false,
            pending: false,
            retries: 0,
            trigger: None,
            inhibit: None,
            acknowledge: None,
            acknowledge_time: 16,
            retry_limit: 1,
            leaving: None,
        }
    }

    pub(super) fn advance(&mut self, now: Instant) {
        self.now = self.now.max(now);
    }

    /// A restart of the node.
    pub(super) fn reset(&mut self) {
        (self.acknowledge_time, self.retry_limit) = (16, 1);
    }
}

const EXPLICIT: u8 = 0x01;
const POLL: u8 = 0x02;
const STROBE: u8 = 0x04;
const COS: u8 = 0x10;
const CYCLIC: u8 = 0x20;
const BOTH: u8 = COS | CYCLIC;
const SUPPRESSION: u8 = 0x40;
/// What the application has room for.
const LONGEST_IO: usize = 16;
