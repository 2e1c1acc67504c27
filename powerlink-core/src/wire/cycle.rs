//! The frames of the cycle: SoC, PReq, PRes, SoA.

use core::fmt;

use link_core::codec::{Full, ParseError, Reader, Wire, Writer};
use link_core::text::ByteCount;

use super::{AsyncRequest, Flags, NmtStateCode, RequestedService};
use crate::NodeId;

/// SoC, start of cycle.
///
/// | Offset | Content |
/// |---|---|
/// | 17 | reserved |
/// | 18 | flags: MC, PS |
/// | 19 | reserved |
/// | 20-23 | NetTime, seconds |
/// | 24-27 | NetTime, nanoseconds |
/// | 28-35 | RelativeTime, µs since the managing node started |
///
/// The 24 reserved bytes behind are padding here: on a link that nobody pads the frame ends before them.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Soc {
    /// MC and PS.
    pub flags: Flags,
    /// The time of day; 0 where the managing node has none.
    pub net_time: NetTime,
    /// µs since the managing node started, grows by the cycle time.
    pub relative_time: u64,
}

/// The time of day in a network.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NetTime {
    /// Seconds since 1970.
    pub seconds: u32,
    /// Nanoseconds.
    pub nanoseconds: u32,
}

/// PReq, poll request: the managing node's data for one node.
///
/// | Offset | Content |
/// |---|---|
/// | 17 | reserved |
/// | 18 | flags: MS, EA, RD |
/// | 19 | reserved |
/// | 20 | PDO version |
/// | 21 | reserved |
/// | 22-23 | Size, the number of bytes of process data |
/// | 24.. | process data |
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Preq<'a> {
    /// MS, EA and RD.
    pub flags: Flags,
    /// The version of the mapping.
    pub pdo_version: PdoVersion,
    /// Process data.
    pub data: &'a [u8],
}

/// PRes, poll response: a node's data for all.
///
/// | Offset | Content |
/// |---|---|
/// | 17 | NMT state of the sender |
/// | 18 | flags: MS, EN, RD |
/// | 19 | PR, RS |
/// | 20 | PDO version |
/// | 21 | reserved |
/// | 22-23 | Size, the number of bytes of process data |
/// | 24.. | process data |
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Pres<'a> {
    /// The sender's state.
    pub state: NmtStateCode,
    /// MS, EN and RD.
    pub flags: Flags,
    /// What waits for the asynchronous slot.
    pub request: AsyncRequest,
    /// The version of the mapping.
    pub pdo_version: PdoVersion,
    /// Process data.
    pub data: &'a [u8],
}

/// SoA, start of the asynchronous phase: who may send now, and what.
///
/// | Offset | Content |
/// |---|---|
/// | 17 | NMT state of the managing node |
/// | 18 | flags: EA, ER, for the target |
/// | 19 | reserved |
/// | 20 | RequestedServiceID |
/// | 21 | RequestedServiceTarget, 0 for nobody |
/// | 22 | EPLVersion |
///
/// What follows is reserved, and padding here.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Soa {
    /// The managing node's state.
    pub state: NmtStateCode,
    /// EA and ER.
    pub flags: Flags,
    /// What is to be sent.
    pub service: RequestedService,
    /// Who is to send it.
    pub target: NodeId,
    /// 0x20 for POWERLINK V2.
    pub version: u8,
}

/// The version of a PDO mapping: high nibble main, low nibble sub version.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
pub struct PdoVersion(pub u8);

impl PdoVersion {
    /// The high nibble: two versions that differ in it do not fit.
    #[must_use]
    pub const fn main(self) -> u8 {
        self.0 >> 4
    }
}

/// The version byte of POWERLINK V2.
pub const POWERLINK_V2: u8 = 0x20;

impl Pres<'_> {
    /// The fields in front of `size` bytes of process data.
    #[inline]
    pub(crate) const fn fields(&self, size: u16) -> [u8; POLL_FIELDS] {
        let [low, high] = size.to_le_bytes();
        [self.state.0, self.flags.bits(), self.request.0, self.pdo_version.0, 0, low, high]
    }
}

impl Wire<'_> for Soc {
    const NAME: &'static str = "SoC";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let [_, flags, _, s0, s1, s2, s3, n0, n1, n2, n3, r0, r1, r2, r3, r4, r5, r6, r7] =
            reader.array("SoC")?;
        let net_time = NetTime {
            seconds: u32::from_le_bytes([s0, s1, s2, s3]),
            nanoseconds: u32::from_le_bytes([n0, n1, n2, n3]),
        };
        let relative_time = u64::from_le_bytes([r0, r1, r2, r3, r4, r5, r6, r7]);
        Ok(Self { flags: Flags::from_bits_retain(flags), net_time, relative_time })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.bytes(&[0, self.flags.bits(), 0])?;
        out.u32(self.net_time.seconds)?;
        out.u32(self.net_time.nanoseconds)?;
        out.u64(self.relative_time)
    }

    fn wire_len(&self) -> usize {
        19
    }
}

impl<'a> Wire<'a> for Preq<'a> {
    const NAME: &'static str = "PReq";

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        let [_, flags, _, version, _] = reader.array("PReq header")?;
        let size = reader.u16("Size")?;
        let data = reader.bytes(size.into(), "process data")?;
        Ok(Self { flags: Flags::from_bits_retain(flags), pdo_version: PdoVersion(version), data })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.bytes(&[0, self.flags.bits(), 0, self.pdo_version.0, 0])?;
        out.u16(u16::try_from(self.data.len()).map_err(|_| Full)?)?;
        out.bytes(self.data)
    }

    fn wire_len(&self) -> usize {
        POLL_FIELDS.saturating_add(self.data.len())
    }
}

impl<'a> Wire<'a> for Pres<'a> {
    const NAME: &'static str = "PRes";

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        let [state, flags, request, version, _] = reader.array("PRes header")?;
        let size = reader.u16("Size")?;
        let data = reader.bytes(size.into(), "process data")?;
        Ok(Self {
            state: NmtStateCode(state),
            flags: Flags::from_bits_retain(flags),
            request: AsyncRequest(request),
            pdo_version: PdoVersion(version),
            data,
        })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.bytes(&self.fields(u16::try_from(self.data.len()).map_err(|_| Full)?))?;
        out.bytes(self.data)
    }

    fn wire_len(&self) -> usize {
        POLL_FIELDS.saturating_add(self.data.len())
    }
}

impl Wire<'_> for Soa {
    const NAME: &'static str = "SoA";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let [state, flags, _, service, target, version] = reader.array("SoA")?;
        Ok(Self {
            state: NmtStateCode(state),
            flags: Flags::from_bits_retain(flags),
            service: RequestedService(service),
            target: NodeId(target),
            version,
        })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        let Self { state, flags, service, target, version } = self;
        out.bytes(&[state.0, flags.bits(), 0, service.0, target.0, *version])
    }

    fn wire_len(&self) -> usize {
        6
    }
}

/// `SoC, net time 1474447956.274380797, relative 20000 us`
impl fmt::Display for Soc {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SoC, net time {}, relative {} us", self.net_time, self.relative_time)
    }
}

impl fmt::Display for NetTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{:09}", self.seconds, self.nanoseconds)
    }
}

/// `PReq, EA=0 RD=1, 8 bytes`
impl fmt::Display for Preq<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ea = u8::from(self.flags.contains(Flags::EXCEPTION_ACKNOWLEDGE));
        let rd = u8::from(self.flags.contains(Flags::DATA_VALID));
        write!(f, "PReq, EA={ea} RD={rd}, {}", ByteCount(self.data.len()))
    }
}

/// `PRes, NMT_OPERATIONAL, EN=0 RD=1, PR=0 RS=0, 8 bytes`
impl fmt::Display for Pres<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let en = u8::from(self.flags.contains(Flags::EXCEPTION_NEW));
        let rd = u8::from(self.flags.contains(Flags::DATA_VALID));
        write!(f, "PRes, {}, EN={en} RD={rd}, {}, {}", self.state, self.request, ByteCount(self.data.len()))
    }
}

/// `SoA, NMT_PRE_OPERATIONAL_1, StatusRequest for node 1, EA=0 ER=1`
impl fmt::Display for Soa {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SoA, {}, {}", self.state, self.service)?;
        if self.target == NodeId::NONE {
            return Ok(());
        }
        let ea = u8::from(self.flags.contains(Flags::EXCEPTION_ACKNOWLEDGE));
        let er = u8::from(self.flags.contains(Flags::EXCEPTION_RESET));
        write!(f, " for {}, EA={ea} ER={er}", self.target)
    }
}

/// The fields of PReq and PRes behind the POWERLINK header.
pub(crate) const POLL_FIELDS: usize = crate::ethernet::POLL_HEADER - crate::ethernet::POWERLINK_HEADER;
