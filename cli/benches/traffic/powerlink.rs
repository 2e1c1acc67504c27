//! Traffic of an Ethernet POWERLINK network of any length: the same seed gives the same frames.
//!
//! A managing node polls ten controlled nodes every two milliseconds, with process data of 8 to 36 bytes, asks for their status
//! and reads their objects; from time to time a response is lost.

use std::collections::VecDeque;
use std::io::{self, Write};
use std::time::Duration;

use link_core::Instant;
use powerlink_core::ethernet::{MAX_FRAME, group};
use powerlink_core::wire::{
    AsyncRequest, Body, Con, Flags, Frame, NmtStateCode, POWERLINK_V2, PdoVersion, Preq, Pres,
    RequestedService, Sdo, SdoCommand, SdoCommandId, SdoSequence, SequenceHalf, Soa, Soc, StatusResponse,
};
use powerlink_core::{MacAddress, NodeId};

use super::below;

/// An endless capture.
struct Powerlink {
    now: Instant,
    random: u64,
    cycle: u64,
    /// SDO transfers with each node.
    transfers: [u8; NODES as usize],
    pending: VecDeque<(Instant, Vec<u8>)>,
}

impl Powerlink {
    fn new(seed: u64) -> Self {
        Self {
            now: Instant::from_nanos(1_700_000_000_000_000_000),
            random: seed,
            cycle: 0,
            transfers: [0; NODES as usize],
            pending: VecDeque::new(),
        }
    }

    fn run_cycle(&mut self) {
        let begin = self.now;
        let soc = Soc { relative_time: self.cycle * CYCLE.as_micros() as u64, ..Soc::default() };
        self.send(group::SOC, 255, 240, Body::Soc(soc));
        let data = [self.cycle as u8; 36];
        for node in 1..=NODES {
            let data = &data[..8 + usize::from(node) % 4 * 8];
            let (flags, pdo_version) = (Flags::DATA_VALID, PdoVersion(0));
            self.send(mac(node), node, 240, Body::Preq(Preq { flags, pdo_version, data }));
            if self.below(20_000) > 0 {
                let (state, request) = (NmtStateCode::OPERATIONAL, AsyncRequest::NONE);
                let pres = Pres { state, flags, request, pdo_version, data };
                self.send(group::PRES, 255, node, Body::Pres(pres));
            }
        }
        let node = 1 + self.below(usize::from(NODES)) as u8;
        match self.below(4) {
            0 => {
                self.invite(RequestedService::STATUS_REQUEST, node);
                let (flags, request) = (Flags::empty(), AsyncRequest::NONE);
                let (state, entries) = (NmtStateCode::OPERATIONAL, Default::default());
                let status = StatusResponse { flags, request, state, static_errors: [0; 8], entries };
                self.send(group::ASND, 255, node, Body::StatusResponse(status));
            }
            1 => self.read_object(node),
            _ => self.invite(RequestedService::NO_SERVICE, 0),
        }
        self.cycle += 1;
        let jitter = Duration::from_micros(self.below(4) as u64);
        self.now = begin + CYCLE + jitter;
    }

    /// The managing node asks for the vendor ID; the node answers in its slot.
    fn read_object(&mut self, node: u8) {
        let number = self.transfers[usize::from(node) - 1].wrapping_add(1) & 0x3F;
        self.transfers[usize::from(node) - 1] = number;
        let half = |number| SequenceHalf::new(number, Con::Valid);
        self.invite(RequestedService::UNSPECIFIED_INVITE, 240);
        let request = SdoCommand::request(number, SdoCommandId::READ_BY_INDEX, &[0x18, 0x10, 0x01, 0]);
        let sequence = SdoSequence { receive: half(number.wrapping_sub(1)), send: half(number) };
        self.send(group::ASND, node, 240, Body::Sdo(Sdo { sequence, command: Some(request) }));
        self.invite(RequestedService::UNSPECIFIED_INVITE, node);
        let response = SdoCommand {
            is_response: true,
            ..SdoCommand::request(number, SdoCommandId::READ_BY_INDEX, &[0x23, 1, 0, 0])
        };
        let sequence = SdoSequence { receive: half(number), send: half(number) };
        self.send(group::ASND, 240, node, Body::Sdo(Sdo { sequence, command: Some(response) }));
    }

    fn invite(&mut self, service: RequestedService, target: u8) {
        let state = NmtStateCode::OPERATIONAL;
        let soa =
            Soa { state, flags: Flags::empty(), service, target: NodeId(target), version: POWERLINK_V2 };
        self.send(group::SOA, 255, 240, Body::Soa(soa));
    }

    fn send(&mut self, destination: MacAddress, to: u8, from: u8, body: Body<'_>) {
        let mut buffer = [0; MAX_FRAME];
        let frame = Frame { destination, source: mac(from), to: NodeId(to), from: NodeId(from), body };
        // 100 Mbit/s, and the reaction of the sender.
        let pause = Duration::from_micros(10 + self.below(20) as u64);
        self.now += pause;
        let bytes = frame.emit(&mut buffer).unwrap().to_vec();
        self.pending.push_back((self.now, bytes));
    }

    fn below(&mut self, bound: usize) -> usize {
        below(&mut self.random, bound)
    }
}

/// Writes a pcap file of so many frames: microseconds, little-endian, link type 1.
pub(crate) fn write(out: &mut impl Write, seed: u64, frames: usize) -> io::Result<()> {
    let header = [0xA1B2_C3D4, 0x0004_0002, 0, 0, 0x0004_0000, 1_u32];
    out.write_all(&header.map(u32::to_le_bytes).concat())?;
    for (at, frame) in Powerlink::new(seed).take(frames) {
        let (nanos, length) = (at.as_nanos(), frame.len() as u32);
        let (seconds, micros) = (nanos / 1_000_000_000, nanos % 1_000_000_000 / 1000);
        out.write_all(&[seconds as u32, micros as u32, length, length].map(u32::to_le_bytes).concat())?;
        out.write_all(&frame)?;
    }
    out.flush()
}

impl Iterator for Powerlink {
    type Item = (Instant, Vec<u8>);

    fn next(&mut self) -> Option<Self::Item> {
        while self.pending.is_empty() {
            self.run_cycle();
        }
        self.pending.pop_front()
    }
}

const fn mac(node: u8) -> MacAddress {
    MacAddress([2, 0, 0, 0, 0, node])
}

const NODES: u8 = 10;
const CYCLE: Duration = Duration::from_millis(2);
