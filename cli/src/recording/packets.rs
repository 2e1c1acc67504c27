//! The packets of pcap and pcapng files.

use std::io::Read;

use link_core::Instant;
use pcap_file::pcap::PcapReader;
use pcap_file::pcapng::PcapNgReader;
use pcap_file::pcapng::blocks::interface_description::{
    InterfaceDescriptionBlock, InterfaceDescriptionOption,
};
use pcap_file::{DataLink, Endianness, PcapError, TsResolution};

use super::error::RecordingError;
use super::frame::{ChannelId, Channels};
use super::{Parsed, socketcan};

/// A source of bytes.
type Source = Box<dyn Read>;

/// A pcap file: one link type, no interface names.
pub(super) struct Pcap {
    reader: PcapReader<Source>,
    records: u64,
}

impl Pcap {
    pub(super) fn new(source: Source) -> Result<Self, RecordingError> {
        let reader = PcapReader::new(source).map_err(|error| damage(error, 0))?;
        check_link_type(reader.header().datalink)?;
        Ok(Self { reader, records: 0 })
    }

    /// The next frame; `frames` were read before it.
    pub(super) fn next(&mut self, frames: u64) -> Option<Result<Parsed, RecordingError>> {
        let in_nanoseconds = self.reader.header().ts_resolution == TsResolution::NanoSecond;
        let packet = match self.reader.next_raw_packet()? {
            Ok(packet) => packet,
            Err(error) => return Some(Err(damage(error, frames))),
        };
        self.records += 1;
        let (scale, digits) = if in_nanoseconds { (1, 9) } else { (1000, 6) };
        let nanos = u64::from(packet.ts_sec) * 1_000_000_000 + u64::from(packet.ts_frac) * scale;
        let content =
            socketcan::parse(&packet.data).map_err(|fault| fault.in_record(self.records, &packet.data));
        Some(content.map(|content| Parsed { at: Instant::from_nanos(nanos), digits, channel: None, content }))
    }
}

/// A pcapng file: any number of interfaces, each with a clock resolution of its own.
pub(super) struct PcapNg {
    reader: PcapNgReader<Source>,
    records: u64,
    interfaces: Vec<Interface>,
}

/// What the packets of an interface need.
#[derive(Clone, Copy)]
struct Interface {
    link_type: DataLink,
    channel: Option<ChannelId>,
    clock: Clock,
}

#[derive(Clone, Copy)]
struct Clock {
    units_per_second: u64,
    offset_seconds: u64,
    digits: u8,
}

impl PcapNg {
    pub(super) fn new(source: Source) -> Result<Self, RecordingError> {
        let reader = PcapNgReader::new(source).map_err(|error| damage(error, 0))?;
        Ok(Self { reader, records: 0, interfaces: Vec::new() })
    }

    /// The next frame; `frames` were read before it.
    pub(super) fn next(
        &mut self,
        frames: u64,
        channels: &mut Channels,
    ) -> Option<Result<Parsed, RecordingError>> {
        let damaged = |what: String| Some(Err(RecordingError::Damaged { after: frames, what }));
        loop {
            let endianness = self.reader.section().endianness;
            let block = match self.reader.next_raw_block()? {
                Ok(block) => block,
                Err(error) => return Some(Err(damage(error, frames))),
            };
            match block.type_ {
                SECTION_HEADER => self.interfaces.clear(),
                INTERFACE_DESCRIPTION => {
                    drop(block);
                    let described = self.reader.interfaces().last();
                    self.interfaces
                        .extend(described.map(|description| Interface::new(description, channels)));
                }
                ENHANCED_PACKET => {
                    self.records += 1;
                    let Some(packet) = EnhancedPacket::parse(&block.body, endianness) else {
                        return damaged("a packet block is shorter than its contents".to_owned());
                    };
                    return match self.interfaces.get(packet.interface as usize) {
                        Some(interface) => Some(read(self.records, &packet, *interface)),
                        None => damaged(format!(
                            "a packet of interface {}, which is not described",
                            packet.interface
                        )),
                    };
                }
                OBSOLETE_PACKET | SIMPLE_PACKET => {
                    return damaged("a packet block without a time, or of the obsolete kind".to_owned());
                }
                // Statistics, names, comments.
                _ => {}
            }
        }
    }
}

impl Interface {
    fn new(description: &InterfaceDescriptionBlock<'_>, channels: &mut Channels) -> Self {
        let mut clock = Clock { units_per_second: 1_000_000, offset_seconds: 0, digits: 6 };
        let mut channel = None;
        for option in &description.options {
            match option {
                InterfaceDescriptionOption::IfName(name) => {
                    channel = channels.intern(name.trim_end_matches('\0').as_bytes());
                }
                InterfaceDescriptionOption::IfTsResol(code) => {
                    let (base, exponent) = if code & 0x80 == 0 { (10u64, *code) } else { (2, code & 0x7F) };
                    clock.units_per_second = base.checked_pow(u32::from(exponent)).unwrap_or(u64::MAX);
                    clock.digits = if base == 10 { exponent.min(9) } else { 9 };
                }
                InterfaceDescriptionOption::IfTsOffset(seconds) => clock.offset_seconds = *seconds,
                _ => {}
            }
        }
        Self { link_type: description.linktype, channel, clock }
    }
}

impl Clock {
    fn instant(self, units: u64) -> Instant {
        let nanos = u128::from(units) * 1_000_000_000 / u128::from(self.units_per_second);
        let offset = u128::from(self.offset_seconds) * 1_000_000_000;
        Instant::from_nanos(u64::try_from(nanos + offset).unwrap_or(u64::MAX))
    }
}

fn read(record: u64, packet: &EnhancedPacket<'_>, interface: Interface) -> Result<Parsed, RecordingError> {
    check_link_type(interface.link_type)?;
    let content = socketcan::parse(packet.data).map_err(|fault| fault.in_record(record, packet.data))?;
    let (at, digits) = (interface.clock.instant(packet.units), interface.clock.digits);
    Ok(Parsed { at, digits, channel: interface.channel, content })
}

/// The fields of an Enhanced Packet Block that are read; its options are not.
struct EnhancedPacket<'a> {
    interface: u32,
    /// Time in units of the interface's clock.
    units: u64,
    data: &'a [u8],
}

impl<'a> EnhancedPacket<'a> {
    fn parse(body: &'a [u8], endianness: Endianness) -> Option<Self> {
        let field = |index: usize| {
            let bytes = *body.get(index * 4..)?.first_chunk::<4>()?;
            Some(match endianness {
                Endianness::Big => u32::from_be_bytes(bytes),
                Endianness::Little => u32::from_le_bytes(bytes),
            })
        };
        let units = u64::from(field(1)?) << 32 | u64::from(field(2)?);
        let length = field(3)? as usize;
        Some(Self { interface: field(0)?, units, data: body.get(20..)?.get(..length)? })
    }
}

fn check_link_type(link_type: DataLink) -> Result<(), RecordingError> {
    // The upper bits of the field say how long the frame check sequence is.
    match u32::from(link_type) & 0xFFFF {
        socketcan::LINK_TYPE => Ok(()),
        number => Err(RecordingError::LinkType { number, name: link_type_name(number) }),
    }
}

/// Those that users meet.
fn link_type_name(number: u32) -> &'static str {
    match number {
        1 => "Ethernet",
        101 => "raw IP",
        113 => "Linux cooked capture",
        189 | 220 => "USB",
        190 => "CAN 2.0b, obsolete",
        276 => "Linux cooked capture v2",
        _ => "unknown",
    }
}

#[cold]
fn damage(error: PcapError, after: u64) -> RecordingError {
    match error {
        PcapError::IncompleteBuffer => RecordingError::Truncated { after },
        PcapError::IoError(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => {
            RecordingError::Truncated { after }
        }
        PcapError::IoError(error) => RecordingError::Io(error),
        other => RecordingError::Damaged { after, what: other.to_string() },
    }
}

/// Block types of pcapng.
const SECTION_HEADER: u32 = 0x0A0D_0D0A;
const INTERFACE_DESCRIPTION: u32 = 1;
const OBSOLETE_PACKET: u32 = 2;
const SIMPLE_PACKET: u32 = 3;
const ENHANCED_PACKET: u32 = 6;
