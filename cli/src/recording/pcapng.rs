//! pcapng: blocks, of which most may be skipped; any number of interfaces, each with a clock of its own.
//!
//! Every block has its type, its length, its body, and its length again. The bodies that are read:
//!
//! | type | block | byte | field |
//! |---|---|---|---|
//! | 0x0A0D0D0A | section header | 0 | magic number, which tells the byte order |
//! | | | 4 | major version |
//! | 1 | interface description | 0 | link type |
//! | | | 8 | options: 2 name, 9 resolution of times, 14 seconds to add to them (signed) |
//! | 2 | packet (obsolete) | 0 | interface, 16 bits; the rest like type 6 |
//! | 3 | simple packet | | has no time: a bad record |
//! | 5 | interface statistics | 0 | interface |
//! | | | 12 | options: 5 packets lost by the interface, 7 by the operating system |
//! | 6 | enhanced packet | 0 | interface, 32 bits |
//! | | | 4 | time, upper half first |
//! | | | 12 | length of the packet in the file |
//! | | | 20 | the packet |
//!
//! What is wrong within a block is a bad record. Only what hides the next block is fatal.
//!
//! Source: IETF draft-ietf-opsawg-pcapng.

use std::io;

use link_core::Instant;
use pcap_file::Endianness;

use super::error::{Fault, RecordingError};
use super::fields::Fields;
use super::frame::{ChannelId, Channels};
use super::network::Network;
use super::notes::Notes;
use super::window::{WINDOW, Window};
use super::{Parsed, Source};

/// Reads block after block.
pub(super) struct PcapNg {
    window: Window<Source>,
    order: Endianness,
    /// Those of the section.
    interfaces: Vec<Interface>,
    records: u64,
    /// Which packets are read.
    network: Network,
    /// The link type of the first interface of another network.
    foreign: Option<u32>,
    has_wanted: bool,
}

/// What the packets of an interface need.
enum Interface {
    Wanted {
        channel: ChannelId,
        clock: Clock,
        /// Packets lost so far.
        dropped: u64,
    },
    /// Of another kind of network.
    Foreign,
    /// What would have to be there to read its packets.
    Unreadable(&'static str),
}

#[derive(Clone, Copy)]
struct Clock {
    /// `None` for units so short that 64 bits of them are not a nanosecond.
    units_per_second: Option<u128>,
    offset_seconds: i64,
    digits: u8,
}

impl PcapNg {
    pub(super) fn new(window: Window<Source>, network: Network) -> Self {
        let (order, interfaces) = (Endianness::Little, Vec::new());
        Self { window, order, interfaces, records: 0, network, foreign: None, has_wanted: false }
    }

    /// Of which network a file is: of CAN, if one of the interfaces described before the first packet is. What is not seen at
    /// once tells nothing.
    pub(super) fn network(window: &mut Window<Source>) -> io::Result<Option<Network>> {
        let (mut order, mut at, mut found) = (Endianness::Little, 0, None);
        while at + HEAD + 4 <= WINDOW {
            let seen = window.up_to(at + HEAD + 4)?;
            let mut head = Fields::new(seen.get(at..).unwrap_or_default(), order);
            if head.bytes.starts_with(&SECTION_HEADER.to_be_bytes()) {
                let is_big = head.bytes.get(HEAD) == Some(&0x1A);
                order = if is_big { Endianness::Big } else { Endianness::Little };
                head.order = order;
            }
            let (Some(kind), Some(length)) = (head.u32_at(0), head.u32_at(4)) else { break };
            match kind {
                PACKET | SIMPLE_PACKET | ENHANCED_PACKET => break,
                INTERFACE_DESCRIPTION => {
                    match head.u16_at(HEAD).map(u32::from).and_then(Network::of_link_type) {
                        Some(Network::Can) => return Ok(Some(Network::Can)),
                        Some(Network::Ethernet) => found = Some(Network::Ethernet),
                        None => {}
                    }
                }
                _ => {}
            }
            at += (length.clamp(MIN_BLOCK, MAX_BLOCK)) as usize;
        }
        Ok(found)
    }

    /// The next frame, `None` at the end; `frames` were read before it. `parse` gets the packet, and the length that it had
    /// when it was captured.
    pub(super) fn next<C>(
        &mut self,
        frames: u64,
        channels: &mut Channels,
        notes: &mut Notes,
        mut parse: impl FnMut(&[u8], usize) -> Result<C, Fault>,
    ) -> Result<Option<Parsed<C>>, RecordingError> {
        loop {
            let Some((kind, length)) = self.block(frames)? else { return self.end() };
            // All of the block, or as much of it as fits.
            let seen = self.window.up_to(length)?;
            let body = Fields::new(&seen[HEAD..seen.len().min(length - TAIL)], self.order);
            let entry = match kind {
                SECTION_HEADER => {
                    self.interfaces.clear();
                    match body.u16_at(4) {
                        Some(1) => None,
                        _ => return Err(RecordingError::damaged(frames, UNKNOWN_VERSION.to_owned())),
                    }
                }
                INTERFACE_DESCRIPTION => {
                    let index = self.interfaces.len();
                    let (link_type, interface) = Interface::new(body, index, channels, self.network);
                    match interface {
                        Interface::Foreign => self.foreign = self.foreign.or(link_type),
                        Interface::Wanted { .. } | Interface::Unreadable(_) => self.has_wanted = true,
                    }
                    if index == MOST_INTERFACES {
                        return Err(RecordingError::damaged(frames, TOO_MANY_INTERFACES.to_owned()));
                    }
                    self.interfaces.push(interface);
                    None
                }
                INTERFACE_STATISTICS => {
                    let index = body.u32_at(0).and_then(|index| usize::try_from(index).ok());
                    if let Some(Interface::Wanted { dropped, .. }) =
                        index.and_then(|index| self.interfaces.get_mut(index))
                    {
                        let before = core::mem::replace(dropped, (*dropped).max(dropped_of(body)));
                        notes.dropped = notes.dropped.saturating_add(*dropped - before);
                    }
                    None
                }
                PACKET | SIMPLE_PACKET | ENHANCED_PACKET => {
                    self.records += 1;
                    packet(kind, body, &self.interfaces, self.records, notes, &mut parse)
                }
                // Names, comments, secrets.
                _ => None,
            };
            if !self.window.discard(length)? {
                return Err(RecordingError::Truncated { after: frames });
            }
            if let Some(entry) = entry {
                return entry.map(Some);
            }
        }
    }

    /// Type and length of the next block, which is there to its end; `None` at the end of the file.
    #[inline]
    fn block(&mut self, frames: u64) -> Result<Option<(u32, usize)>, RecordingError> {
        let truncated = RecordingError::Truncated { after: frames };
        let mut head = Fields::new(self.window.up_to(HEAD + 4)?, self.order);
        if head.bytes.is_empty() {
            return Ok(None);
        }
        // A type that is the same in either order.
        if head.u32_at(0) == Some(SECTION_HEADER) {
            head.order = match head.bytes.get(HEAD..) {
                Some([0x1A, 0x2B, 0x3C, 0x4D]) => Endianness::Big,
                Some([0x4D, 0x3C, 0x2B, 0x1A]) => Endianness::Little,
                Some(&[_, _, _, _]) => return Err(RecordingError::damaged(frames, NO_MAGIC.to_owned())),
                _ => return Err(truncated),
            };
            self.order = head.order;
        }
        let (Some(kind), Some(length)) = (head.u32_at(0), head.u32_at(4)) else { return Err(truncated) };
        if !(MIN_BLOCK..=MAX_BLOCK).contains(&length) || length % 4 != 0 {
            return Err(RecordingError::damaged(frames, format!("a block says that it has {length} bytes")));
        }
        let size = length as usize;
        let seen = Fields::new(self.window.up_to(size)?, self.order);
        match seen.u32_at(size - TAIL) {
            Some(again) if again == length => Ok(Some((kind, size))),
            Some(again) => Err(RecordingError::damaged(
                frames,
                format!("a block says at its beginning that it has {length} bytes, at its end {again}"),
            )),
            None if self.window.is_at_end() => Err(truncated),
            // More than fits, and nothing that is read: its end is not looked at.
            None => Ok(Some((kind, size))),
        }
    }

    /// At the end of the file it is known whether there was an interface of the network.
    fn end<C>(&self) -> Result<Option<Parsed<C>>, RecordingError> {
        match self.foreign {
            Some(number) if !self.has_wanted => Err(RecordingError::link_type(number, self.network)),
            _ => Ok(None),
        }
    }
}

/// What a packet block holds; nothing for one of another network.
#[inline]
fn packet<C>(
    kind: u32,
    body: Fields<'_>,
    interfaces: &[Interface],
    record: u64,
    notes: &mut Notes,
    parse: impl FnOnce(&[u8], usize) -> Result<C, Fault>,
) -> Option<Result<Parsed<C>, RecordingError>> {
    let fault = |at, expected| Some(Err(Fault { at, expected }.in_record(record, body.bytes)));
    let index = match kind {
        SIMPLE_PACKET => Some(0),
        PACKET => body.u16_at(0).map(u32::from),
        _ => body.u32_at(0),
    };
    let Some(index) = index else { return fault(body.bytes.len(), WHOLE_BLOCK) };
    let (channel, clock) = match usize::try_from(index).ok().and_then(|index| interfaces.get(index)) {
        Some(Interface::Foreign) => {
            notes.foreign += 1;
            return None;
        }
        Some(Interface::Unreadable(expected)) => return fault(0, expected),
        None => return fault(0, "an interface that was described before"),
        Some(_) if kind == SIMPLE_PACKET => {
            return fault(0, "a packet with a time, an Enhanced Packet Block");
        }
        Some(Interface::Wanted { channel, clock, .. }) => (*channel, clock),
    };
    let (Some(high), Some(low), Some(length), Some(original)) =
        (body.u32_at(4), body.u32_at(8), body.u32_at(12), body.u32_at(16))
    else {
        return fault(body.bytes.len(), WHOLE_BLOCK);
    };
    let data = usize::try_from(length).ok().and_then(|length| body.bytes.get(20..)?.get(..length));
    let Some(data) = data else { return fault(12, "a length that fits into the block") };
    let Some(at) = clock.instant(u64::from(high) << 32 | u64::from(low)) else {
        return fault(4, "a time from 1970 to 2554");
    };
    Some(match parse(data, original as usize) {
        Ok(content) => Ok(Parsed { at, digits: clock.digits, channel: Some(channel), content }),
        Err(fault) => Err(fault.in_record(record, data)),
    })
}

impl Interface {
    /// From the body of its description.
    fn new(body: Fields<'_>, index: usize, channels: &mut Channels, network: Network) -> (Option<u32>, Self) {
        let link_type = body.u16_at(0).map(u32::from);
        match link_type {
            Some(number) if number == network.link_type() => {}
            Some(_) => return (link_type, Self::Foreign),
            None => return (link_type, Self::Unreadable(DESCRIPTION)),
        }
        (link_type, Self::wanted(body, index, channels).unwrap_or_else(Self::Unreadable))
    }

    fn wanted(body: Fields<'_>, index: usize, channels: &mut Channels) -> Result<Self, &'static str> {
        let mut clock = Clock { units_per_second: Some(1_000_000), offset_seconds: 0, digits: 6 };
        let mut name = &[][..];
        for option in options(body, 8) {
            let (code, value) = option.ok_or(DESCRIPTION)?;
            match code {
                IF_NAME => name = value.bytes.split(|byte| *byte == 0).next().unwrap_or_default(),
                IF_TSRESOL => {
                    let &[code] = value.bytes else { return Err(DESCRIPTION) };
                    let (base, exponent) = if code & 0x80 == 0 { (10u128, code) } else { (2, code & 0x7F) };
                    clock.units_per_second = base.checked_pow(u32::from(exponent));
                    clock.digits = if base == 10 { exponent.min(9) } else { 9 };
                }
                IF_TSOFFSET => clock.offset_seconds = value.u64().ok_or(DESCRIPTION)?.cast_signed(),
                _ => {}
            }
        }
        let unnamed = format!("if{index}");
        let name = if name.is_empty() { unnamed.as_bytes() } else { name };
        let channel = channels.intern(name).ok_or(Channels::LIMIT)?;
        Ok(Self::Wanted { channel, clock, dropped: 0 })
    }
}

impl Clock {
    /// A time in units of this clock; `None` when it is before 1970 or after 2554.
    #[inline]
    fn instant(&self, units: u64) -> Option<Instant> {
        let nanos = self.units_per_second.map_or(0, |second| u128::from(units) * 1_000_000_000 / second);
        let offset = i128::from(self.offset_seconds) * 1_000_000_000;
        let nanos = i128::try_from(nanos).ok()?.checked_add(offset)?;
        u64::try_from(nanos).ok().map(Instant::from_nanos)
    }
}

/// What the statistics of an interface say was lost.
fn dropped_of(body: Fields<'_>) -> u64 {
    let counts = options(body, 12).flatten().filter(|(code, _)| matches!(*code, ISB_IFDROP | ISB_OSDROP));
    counts.filter_map(|(_, value)| value.u64()).fold(0, u64::saturating_add)
}

/// The options from a place in a body on: code and value, `None` where the list is broken. It ends with its end mark or
/// with the body.
fn options<'a>(body: Fields<'a>, at: usize) -> impl Iterator<Item = Option<(u16, Fields<'a>)>> {
    let mut rest = body.bytes.get(at..).unwrap_or_default();
    core::iter::from_fn(move || {
        let head = Fields::new(rest, body.order);
        if rest.is_empty() || head.u16_at(0) == Some(END_OF_OPTIONS) {
            return None;
        }
        let option = head.u16_at(0).zip(head.u16_at(2)).and_then(|(code, length)| {
            let value = rest.get(4..)?.get(..usize::from(length))?;
            Some((code, Fields::new(value, body.order)))
        });
        rest = match option {
            Some((_, value)) => rest.get(4 + value.bytes.len().next_multiple_of(4)..).unwrap_or_default(),
            None => &[],
        };
        Some(option)
    })
}

/// Type and length before the body, the length after it.
const HEAD: usize = 8;
const TAIL: usize = 4;
const MIN_BLOCK: u32 = 12;
/// Wireshark's bound: more is no length.
const MAX_BLOCK: u32 = 16 * 1024 * 1024;
/// Of a section. Each is kept, also those of other networks, so that there must be a limit.
const MOST_INTERFACES: usize = 4096;
/// Block types.
const SECTION_HEADER: u32 = 0x0A0D_0D0A;
const INTERFACE_DESCRIPTION: u32 = 1;
const PACKET: u32 = 2;
const SIMPLE_PACKET: u32 = 3;
const INTERFACE_STATISTICS: u32 = 5;
const ENHANCED_PACKET: u32 = 6;
/// Options.
const END_OF_OPTIONS: u16 = 0;
const IF_NAME: u16 = 2;
const IF_TSRESOL: u16 = 9;
const IF_TSOFFSET: u16 = 14;
const ISB_IFDROP: u16 = 5;
const ISB_OSDROP: u16 = 7;
/// What is expected or wrong.
const WHOLE_BLOCK: &str = "a packet block with all its fields";
const DESCRIPTION: &str = "an interface whose description can be read";
const UNKNOWN_VERSION: &str = "a section of another version than 1";
const TOO_MANY_INTERFACES: &str = "more than 4096 interfaces are described in one section";
const NO_MAGIC: &str = "a section without its magic number";
