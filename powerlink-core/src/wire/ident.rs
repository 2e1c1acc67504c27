//! IdentResponse: who a node is, and what it can do.

use core::fmt;
use core::net::Ipv4Addr;

use link_core::codec::{Full, ParseError, Reader, Wire, Writer};

use super::{AsyncRequest, Flags, NmtStateCode};

/// IdentResponse, an ASnd. The whole frame has 176 bytes; a managing node drops a shorter one.
///
/// | Offset | Content | Object |
/// |---|---|---|
/// | 18 | flags, 0 | |
/// | 19 | PR, RS | |
/// | 20 | NMT state | 0x1F8C |
/// | 21 | IdentResponseFlags, 0 | |
/// | 22 | EPLVersion | 0x1F83 |
/// | 23 | reserved | |
/// | 24-27 | FeatureFlags | 0x1F82 |
/// | 28-29 | MTU | 0x1F98/8 |
/// | 30-31 | PollInSize | 0x1F98/4 |
/// | 32-33 | PollOutSize | 0x1F98/5 |
/// | 34-37 | ResponseTime, ns | 0x1F98/3 |
/// | 38-39 | reserved | |
/// | 40-43 | DeviceType | 0x1000 |
/// | 44-59 | vendor ID, product code, revision, serial number | 0x1018 |
/// | 60-67 | vendor specific | |
/// | 68-75 | VerifyConfigurationDate, Time | 0x1020/1, /2 |
/// | 76-83 | ApplicationSwDate, Time | |
/// | 84-95 | IP address, subnet mask, default gateway, each the other way round than IP writes it | 0x1E40 |
/// | 96-127 | host name, padded with zeros | 0x1F9A |
/// | 128-175 | vendor specific | |
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct IdentResponse {
    /// None is used.
    pub flags: Flags,
    /// What waits for the asynchronous slot.
    pub request: AsyncRequest,
    /// The sender's state.
    pub state: NmtStateCode,
    /// 0x20 for POWERLINK V2.
    pub version: u8,
    /// What it can do.
    pub features: FeatureFlags,
    /// The most bytes of Ethernet payload of its asynchronous frames.
    pub mtu: u16,
    /// The most process data that it takes from a PReq.
    pub poll_in_size: u16,
    /// The process data of its PRes.
    pub poll_out_size: u16,
    /// From PReq to PRes, ns.
    pub response_time: u32,
    /// The low 16 bits are the number of the device profile.
    pub device_type: u32,
    /// Who it is.
    pub identity: Identity,
    /// As the vendor likes.
    pub vendor_extension_1: u64,
    /// Of the configuration that it has.
    pub configuration: ConfigurationStamp,
    /// Of the software that it has.
    pub software: ConfigurationStamp,
    /// Its place in an IP network.
    pub ip: IpParameters,
    /// Padded with zeros.
    pub host_name: [u8; 32],
    /// As the vendor likes.
    pub vendor_extension_2: [u8; 48],
}

/// The identity of a device, object 0x1018.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Identity {
    /// Given by the EPSG.
    pub vendor_id: u32,
    /// Given by the vendor.
    pub product_code: u32,
    /// High half: behaviour; low half: all else.
    pub revision: u32,
    /// Of this one device.
    pub serial_number: u32,
}

impl Identity {
    /// The revision as people write it: its halves, `2.7`.
    #[must_use]
    pub const fn revision(&self) -> Revision {
        Revision(self.revision)
    }
}

/// A revision in words: `2.7` is 0x00020007. See [`Identity::revision`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Revision(pub u32);

impl fmt::Display for Revision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.0 >> 16, self.0 & 0xFFFF)
    }
}

/// A date, in days since 1984-01-01, and a time, in ms since midnight, that tell two configurations apart: object 0x1020.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ConfigurationStamp {
    /// Days.
    pub date: u32,
    /// Milliseconds.
    pub time: u32,
}

/// Object 0x1E40.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct IpParameters {
    /// 192.168.100 and the node ID.
    pub address: Ipv4Addr,
    /// 255.255.255.0
    pub subnet_mask: Ipv4Addr,
    /// 192.168.100.254
    pub gateway: Ipv4Addr,
}

impl IpParameters {
    /// What a node has whom nobody told otherwise: 192.168.100.*node ID*, with the router as gateway.
    #[must_use]
    pub const fn of(node: crate::NodeId) -> Self {
        Self {
            address: Ipv4Addr::new(192, 168, 100, node.0),
            subnet_mask: Ipv4Addr::new(255, 255, 255, 0),
            gateway: Ipv4Addr::new(192, 168, 100, crate::NodeId::ROUTER.0),
        }
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for IpParameters {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "IP {=[u8; 4]}", self.address.octets());
    }
}

bitflags::bitflags! {
    /// What a node can do, object 0x1F82.
    ///
    /// Reserved bits are kept as they were read.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    pub struct FeatureFlags: u32 {
        /// Takes part in the isochronous phase.
        const ISOCHRONOUS = 1 << 0;
        /// SDO by UDP/IP.
        const SDO_UDP = 1 << 1;
        /// SDO by ASnd.
        const SDO_ASND = 1 << 2;
        /// SDO in PDOs.
        const SDO_PDO = 1 << 3;
        /// NMT info services.
        const NMT_INFO = 1 << 4;
        /// NMT commands with a node list.
        const EXTENDED_NMT = 1 << 5;
        /// The PDO mapping can be changed.
        const DYNAMIC_MAPPING = 1 << 6;
        /// NMT services by UDP/IP.
        const NMT_UDP = 1 << 7;
        /// Configuration manager.
        const CONFIGURATION_MANAGER = 1 << 8;
        /// Can be served in some cycles only.
        const MULTIPLEXED = 1 << 9;
        /// The node ID can be set by software.
        const NODE_ID_BY_SOFTWARE = 1 << 10;
        /// A managing node with basic Ethernet mode.
        const MN_BASIC_ETHERNET = 1 << 11;
        /// Routing type 1.
        const ROUTING_1 = 1 << 12;
        /// Routing type 2.
        const ROUTING_2 = 1 << 13;
        /// SDO read and write all by index.
        const SDO_ALL = 1 << 14;
        /// SDO read and write multiple parameters.
        const SDO_MULTIPLE = 1 << 15;
        /// Several ASnd in one phase.
        const MULTIPLE_ASND = 1 << 16;
        /// Ring redundancy.
        const RING_REDUNDANCY = 1 << 17;
        /// PRes chaining.
        const PRES_CHAINING = 1 << 18;
        /// Several PReq and PRes in one cycle.
        const MULTIPLE_POLL = 1 << 19;
        /// Dynamic node allocation.
        const DYNAMIC_NODE_ALLOCATION = 1 << 20;
        /// Modular device.
        const MODULAR = 1 << 21;
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for FeatureFlags {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "FeatureFlags({=u32:#x})", self.bits());
    }
}

impl Wire<'_> for IdentResponse {
    const NAME: &'static str = "IdentResponse";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let [flags, request, state, _, version, _] = reader.array("IdentResponse header")?;
        Ok(Self {
            flags: Flags::from_bits_retain(flags),
            request: AsyncRequest(request),
            state: NmtStateCode(state),
            version,
            features: FeatureFlags::from_bits_retain(reader.u32("FeatureFlags")?),
            mtu: reader.u16("MTU")?,
            poll_in_size: reader.u16("PollInSize")?,
            poll_out_size: reader.u16("PollOutSize")?,
            response_time: reader.u32("ResponseTime")?,
            device_type: {
                reader.u16("reserved")?;
                reader.u32("DeviceType")?
            },
            identity: Identity {
                vendor_id: reader.u32("vendor ID")?,
                product_code: reader.u32("product code")?,
                revision: reader.u32("revision")?,
                serial_number: reader.u32("serial number")?,
            },
            vendor_extension_1: reader.u64("vendor specific extension 1")?,
            configuration: ConfigurationStamp {
                date: reader.u32("VerifyConfigurationDate")?,
                time: reader.u32("VerifyConfigurationTime")?,
            },
            software: ConfigurationStamp {
                date: reader.u32("ApplicationSwDate")?,
                time: reader.u32("ApplicationSwTime")?,
            },
            ip: IpParameters {
                address: ip(reader, "IP address")?,
                subnet_mask: ip(reader, "subnet mask")?,
                gateway: ip(reader, "default gateway")?,
            },
            host_name: reader.array("host name")?,
            vendor_extension_2: reader.array("vendor specific extension 2")?,
        })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.bytes(&[self.flags.bits(), self.request.0, self.state.0, 0, self.version, 0])?;
        out.u32(self.features.bits())?;
        for size in [self.mtu, self.poll_in_size, self.poll_out_size] {
            out.u16(size)?;
        }
        out.u32(self.response_time)?;
        out.u16(0)?;
        out.u32(self.device_type)?;
        let Identity { vendor_id, product_code, revision, serial_number } = self.identity;
        for number in [vendor_id, product_code, revision, serial_number] {
            out.u32(number)?;
        }
        out.u64(self.vendor_extension_1)?;
        for stamp in [self.configuration, self.software] {
            out.u32(stamp.date)?;
            out.u32(stamp.time)?;
        }
        for address in [self.ip.address, self.ip.subnet_mask, self.ip.gateway] {
            out.u32(address.into())?;
        }
        out.bytes(&self.host_name)?;
        out.bytes(&self.vendor_extension_2)
    }

    fn wire_len(&self) -> usize {
        158
    }
}

/// `IdentResponse, NMT_PRE_OPERATIONAL_1, vendor 0x00000000, product 0x00000000, revision 2.7, PR=0 RS=0`
impl fmt::Display for IdentResponse {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Identity { vendor_id, product_code, .. } = self.identity;
        let revision = self.identity.revision();
        write!(
            f,
            "IdentResponse, {}, vendor 0x{vendor_id:08X}, product 0x{product_code:08X}, revision {revision}, {}",
            self.state, self.request
        )
    }
}

fn ip(reader: &mut Reader<'_>, field: &'static str) -> Result<Ipv4Addr, ParseError> {
    reader.u32(field).map(Ipv4Addr::from)
}
