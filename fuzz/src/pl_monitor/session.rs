//! A session on an Ethernet segment, read from bytes: recorded frames, frames that belong to exchanges of POWERLINK, and frames from
//! before with a byte changed.
//!
//! Each item is a byte of time, then a head, then what bits 7-6 of the head say:
//!
//! | Bits 7-6 | Frame | Bytes that follow |
//! |---|---|---|
//! | 00 | recorded, padded to 60 bytes with zeros | how many, then these |
//! | 01 | recorded, not padded | how many, then these |
//! | 10 | number bits 4-0 of [`exchange`] | [nodes](Ends), then an argument |
//! | 11 | the one sent so many frames ago as bits 4-0 say | which byte of it is changed, and with what |
//!
//! Bit 5: the clock goes back by that time. Bit 4 of a recorded frame: the capture has cut it, it had [`BEYOND`] more bytes. The time
//! is a [span](crate::input::span), but 0xFF is ten years.

use core::time::Duration;

use arbitrary::{Result, Unstructured};
use powerlink_core::ethernet::{MAX_FRAME, group};
use powerlink_core::monitor::Captured;
use powerlink_core::wire::*;
use powerlink_core::{MacAddress, NodeId};

use crate::input;

/// A frame of a session.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Sent {
    /// Since the session began, by a clock that may go back.
    pub(super) at: Duration,
    bytes: Vec<u8>,
    /// That are not in the capture.
    beyond: usize,
}

impl Sent {
    pub(super) fn captured(&self) -> Captured<'_> {
        Captured { bytes: &self.bytes, length: self.bytes.len() + self.beyond }
    }
}

/// Reads a session, at most `most` frames of it.
pub(super) fn read(input: &mut Unstructured<'_>, most: usize) -> Vec<Sent> {
    let mut sent: Vec<Sent> = Vec::new();
    let mut at = Duration::ZERO;
    while !input.is_empty() && sent.len() < most {
        let Ok((time, head)) = input.arbitrary::<(u8, u8)>() else { break };
        let span = if time == u8::MAX { TEN_YEARS } else { input::span(time) };
        at = if head & BACK != 0 { at.saturating_sub(span) } else { (at + span).min(LATEST) };
        let Ok((bytes, beyond)) = frame(head, input, &sent) else { break };
        sent.push(Sent { at, bytes, beyond });
    }
    sent
}

/// The bytes from which `read` reads these frames, some of which may be longer than what is left of them.
#[must_use]
pub fn session_bytes<'a>(frames: impl IntoIterator<Item = (Duration, &'a [u8])>) -> Vec<u8> {
    let mut last = None;
    let mut bytes = Vec::new();
    for (at, frame) in frames {
        let span = at.saturating_sub(last.replace(at).unwrap_or(at));
        let content = frame.len() - frame.iter().rev().take_while(|byte| **byte == 0).count();
        // Padding is made again.
        let (head, kept) = if frame.len() == PADDED { (0x00, content) } else { (0x40, frame.len()) };
        bytes.extend([input::span_byte(span), head, u8::try_from(kept).expect("a short frame")]);
        bytes.extend(&frame[..kept]);
    }
    bytes
}

fn frame(head: u8, input: &mut Unstructured<'_>, before: &[Sent]) -> Result<(Vec<u8>, usize)> {
    let number = head & 0x1F;
    match head >> 6 {
        0b10 => {
            let (nodes, argument) = input.arbitrary()?;
            Ok(Ends::of(nodes).captured(number, argument))
        }
        0b11 => {
            let (place, change): (u8, u8) = input.arbitrary()?;
            let earlier =
                before.len().checked_sub(usize::from(number) + 1).and_then(|index| before.get(index));
            Ok(earlier.map_or_else(
                || Ends::of(place).captured(0, change),
                |Sent { bytes, beyond, .. }| {
                    let mut bytes = bytes.clone();
                    if let Some(byte) = bytes.get_mut(usize::from(place)) {
                        *byte ^= change;
                    }
                    (bytes, *beyond)
                },
            ))
        }
        is_raw => {
            let len: u8 = input.arbitrary()?;
            let mut bytes = vec![0; len.into()];
            input.fill_buffer(&mut bytes)?;
            if is_raw == 0 {
                bytes.resize(bytes.len().max(PADDED), 0);
            }
            Ok((bytes, if head & CUT != 0 { BEYOND } else { 0 }))
        }
    }
}

/// Between whom: bits 3-0 the controlled node, from 1 on, bit 4 a managing node with another address, bit 5 a VLAN tag, bit 6 the
/// capture has the first 40 bytes, bit 7 to a foreign address.
struct Ends {
    node: u8,
    managing: u8,
    is_tagged: bool,
    is_cut: bool,
    is_astray: bool,
}

impl Ends {
    const fn of(nodes: u8) -> Self {
        Self {
            node: 1 + (nodes & 0x0F),
            managing: if nodes & 0x10 != 0 { 0xF1 } else { 0xF0 },
            is_tagged: nodes & 0x20 != 0,
            is_cut: nodes & 0x40 != 0,
            is_astray: nodes & 0x80 != 0,
        }
    }

    fn captured(&self, number: u8, argument: u8) -> (Vec<u8>, usize) {
        let mut bytes = self.exchange(number, argument);
        if self.is_astray {
            bytes[..6].copy_from_slice(&[2, 0, 0, 0, 0, 0xAA]);
        }
        if self.is_tagged {
            bytes.splice(12..12, [0x81, 0x00, argument & 0xE0, argument]);
        }
        let length = bytes.len();
        if self.is_cut {
            bytes.truncate(FIRST);
        }
        let beyond = length - bytes.len();
        (bytes, beyond)
    }

    /// The frames of which exchanges consist.
    fn exchange(&self, number: u8, argument: u8) -> Vec<u8> {
        let node = NodeId(self.node);
        let state = STATES[usize::from(argument & 0x07)];
        let request = AsyncRequest(argument >> 3);
        let pdo_version = PdoVersion(argument >> 4);
        let data = &DATA[..usize::from(argument >> 3)];
        let soa = |service, target| {
            let flags = Flags::from_bits_retain(argument >> 3 & 0x06);
            self.of_managing(0xFF, Body::Soa(Soa { state, flags, service, target, version: POWERLINK_V2 }))
        };
        let asnd = |to, body| self.of_node(to, body);
        let command = |to, base: u8, data| {
            let command = NmtCommandId(base | argument & 0x0F);
            self.of_managing(to, Body::NmtCommand(NmtCommand { command, data }))
        };
        match number {
            0 | 1 => self.of_managing(
                0xFF,
                Body::Soc(Soc {
                    flags: Flags::empty(),
                    net_time: NetTime::default(),
                    relative_time: u64::from(argument) * 20_000 * u64::from(number),
                }),
            ),
            2 => soa(RequestedService::NO_SERVICE, NodeId::NONE),
            3 => soa(RequestedService::IDENT_REQUEST, node),
            4 => soa(RequestedService::STATUS_REQUEST, node),
            5 => soa(RequestedService::NMT_REQUEST_INVITE, node),
            6 => soa(RequestedService::UNSPECIFIED_INVITE, node),
            7 => soa(RequestedService::UNSPECIFIED_INVITE, NodeId::MANAGING_NODE),
            8 => {
                self.of_managing(self.node, Body::Preq(Preq { flags: Flags::DATA_VALID, pdo_version, data }))
            }
            9 => asnd(0xFF, Body::Pres(Pres { state, flags: Flags::empty(), request, pdo_version, data })),
            10 => self.of_managing(
                0xFF,
                Body::Pres(Pres { state, flags: Flags::empty(), request, pdo_version, data }),
            ),
            11 => asnd(0xFF, self.ident(argument, state)),
            12 | 13 => {
                let entry = |code| ErrorEntry {
                    kind: EntryType(0x3002),
                    code: ErrorCode(code),
                    time: NetTime::default(),
                    additional: 0,
                };
                let count = if number == 12 { 0 } else { argument >> 5 };
                let entries = (0..count.into()).map(entry).collect();
                let flags = Flags::from_bits_retain(argument & 0x18);
                asnd(
                    0xFF,
                    Body::StatusResponse(StatusResponse {
                        flags,
                        request,
                        state,
                        static_errors: [argument; 8],
                        entries,
                    }),
                )
            }
            14 => command(self.node, PLAIN, &[]),
            15 => command(0xFF, PLAIN, &DATA[..2]),
            16 => command(0xFF, EXTENDED, &DATA),
            17 => asnd(
                0xF0,
                Body::NmtRequest(NmtRequest { command: NmtCommandId(argument), target: node, data: &[] }),
            ),
            18 => self.sdo_frame(false, argument & 3, 1, None),
            19 => self.sdo_frame(true, argument & 3, 1, None),
            20..=27 => {
                let (is_response, is_abort) = (number & 1 != 0, number >= 26);
                let segmentation = match number {
                    20 | 21 | 26 | 27 => Segmentation::Expedited,
                    22 | 23 => Segmentation::Initiate { total: 100 },
                    24 | 25 if argument & 4 == 0 => Segmentation::Segment,
                    _ => Segmentation::Complete,
                };
                let id = if argument & 8 == 0 {
                    SdoCommandId::WRITE_BY_INDEX
                } else {
                    SdoCommandId::READ_BY_INDEX
                };
                let data = if is_abort { &DATA[..4] } else { &DATA[..8 + usize::from(argument & 3)] };
                let command =
                    SdoCommand { transaction: 1, is_response, is_abort, segmentation, command: id, data };
                self.sdo_frame(is_response, argument >> 2, 2, Some(command))
            }
            28 => self.of_managing(0xFF, Body::Other(MessageType(argument & 0x7F | 0x07), &[])),
            29 => asnd(0xFF, Body::OtherAsnd(ServiceId(argument | 0xA0), &DATA[..3])),
            30 => {
                let mut foreign = asnd(0xFF, Body::Other(MessageType(argument), &[]));
                (foreign[12], foreign[13]) = (0x08, argument & 0x06);
                foreign
            }
            // More than Ethernet takes, and more than a node says that it takes.
            _ => {
                let data = vec![argument; 6 * usize::from(argument)];
                let poll = Preq { flags: Flags::DATA_VALID, pdo_version, data: &data };
                self.of_managing(self.node, Body::Preq(poll))
            }
        }
    }

    fn ident(&self, argument: u8, state: NmtStateCode) -> Body<'static> {
        let mut bytes = [0; 158];
        bytes[2] = state.0;
        // FeatureFlags, PollInSize, PollOutSize.
        bytes[6..10].copy_from_slice(&(u32::from(argument) << 12).to_le_bytes());
        (bytes[12], bytes[14]) = (argument >> 3, argument >> 3);
        Body::IdentResponse(IdentResponse::parse(&bytes).expect("a whole one"))
    }

    fn sdo_frame(&self, is_response: bool, number: u8, con: u8, command: Option<SdoCommand<'_>>) -> Vec<u8> {
        let connection = if con == 1 { Con::Initialisation } else { Con::Valid };
        let receive = if con == 1 && !is_response { Con::None } else { connection };
        let sequence = SdoSequence {
            receive: SequenceHalf { number: 0, connection: receive },
            send: SequenceHalf { number: number & 0x3F, connection },
        };
        let body = Body::Sdo(Sdo { sequence, command });
        match is_response {
            true => self.of_node(0xF0, body),
            false => self.of_managing(self.node, body),
        }
    }

    fn of_managing(&self, to: u8, body: Body<'_>) -> Vec<u8> {
        self.emit(self.managing, NodeId::MANAGING_NODE, to, body)
    }

    fn of_node(&self, to: u8, body: Body<'_>) -> Vec<u8> {
        self.emit(self.node, NodeId(self.node), to, body)
    }

    fn emit(&self, mac: u8, from: NodeId, to: u8, body: Body<'_>) -> Vec<u8> {
        let destination = match body {
            Body::Soc(_) => group::SOC,
            Body::Preq(_) => MacAddress([2, 0, 0, 0, 0, self.node]),
            Body::Pres(_) => group::PRES,
            Body::Soa(_) => group::SOA,
            _ => group::ASND,
        };
        let source = MacAddress([2, 0, 0, 0, 0, mac]);
        let mut buffer = [0; 2 * MAX_FRAME];
        Frame { destination, source, to: NodeId(to), from, body }.emit(&mut buffer).expect("room").to_vec()
    }
}

/// That a capture has cut off.
const BEYOND: usize = 100;
/// Bits of a head.
const BACK: u8 = 0x20;
const CUT: u8 = 0x10;
/// What is left of a frame that is cut: SoC and SoA, but not all of a poll.
const FIRST: usize = 40;
const PADDED: usize = 60;
/// The numbers of NMT commands to all of a destination, and to those in a list.
const PLAIN: u8 = 0x20;
const EXTENDED: u8 = 0x40;
const TEN_YEARS: Duration = Duration::from_secs(315_360_000);
/// That no sum of times overflows.
const LATEST: Duration = Duration::from_secs(6_000_000_000);
const STATES: [NmtStateCode; 8] = [
    NmtStateCode::PRE_OPERATIONAL_1,
    NmtStateCode::PRE_OPERATIONAL_2,
    NmtStateCode::READY_TO_OPERATE,
    NmtStateCode::OPERATIONAL,
    NmtStateCode::STOPPED,
    NmtStateCode::BASIC_ETHERNET,
    NmtStateCode::NOT_ACTIVE,
    NmtStateCode(0x42),
];
const DATA: [u8; 32] = [
    0x06, 0x62, 0x01, 0x00, 1, 2, 3, 4, 5, 6, 7, 0xFF, 0x55, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_session_is_read_from_its_bytes() {
        let soc = Ends::of(0).exchange(1, 3);
        let cut = soc[..30].to_vec();
        let bytes = session_bytes([(Duration::from_millis(7), &*soc), (Duration::from_millis(10), &*cut)]);
        let sent = read(&mut Unstructured::new(&bytes), 10);
        let expected = [
            Sent { at: Duration::ZERO, bytes: soc, beyond: 0 },
            Sent { at: Duration::from_millis(3), bytes: cut, beyond: 0 },
        ];
        assert_eq!(sent, expected);
    }

    #[test]
    fn the_clock_goes_back_but_not_before_the_beginning() {
        let read = read(&mut Unstructured::new(&[0x45, 0x80, 0, 0, 0x41, 0xA0, 0, 0, 0xFF, 0xA0, 0, 0]), 10);
        let times: Vec<_> = read.iter().map(|sent| sent.at.as_millis()).collect();
        assert_eq!(times, [5, 4, 0]);
    }

    #[test]
    fn an_earlier_frame_comes_back_changed() {
        let read = read(&mut Unstructured::new(&[0, 0x80, 0, 1, 0, 0xC0, 14, 0x04]), 10);
        assert_eq!((read[0].bytes[14], read[1].bytes[14]), (0x01, 0x05));
    }
}
