//! What is around the message: Ethernet, and a VLAN tag.

use link_core::codec::{ParseError, Reader};

use crate::ethernet::{ETHERNET_HEADER, ETHERTYPE};
use crate::wire::MessageType;
use crate::{MacAddress, NodeId};

/// The headers of a frame, of whatever protocol.
///
/// | Offset | Content |
/// |---|---|
/// | 0-5 | destination MAC address |
/// | 6-11 | source MAC address |
/// | 12-15 | only with a VLAN tag: 0x8100, priority and VLAN ID, in network order |
/// | 12-13, 16-17 | EtherType, in network order; below 0x0600 the length of an IEEE 802.3 frame |
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Envelope {
    /// Destination MAC address.
    pub destination: MacAddress,
    /// Source MAC address.
    pub source: MacAddress,
    /// The VLAN ID, where there is a tag.
    pub vlan: Option<u16>,
    /// What the frame carries.
    pub ethertype: u16,
}

impl Envelope {
    /// Reads the headers; the payload remains in `reader`.
    pub(super) fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let destination = MacAddress(reader.array("destination MAC")?);
        let source = MacAddress(reader.array("source MAC")?);
        let mut ethertype = u16::from_be_bytes(reader.array("EtherType")?);
        let mut vlan = None;
        if ethertype == VLAN {
            vlan = Some(u16::from_be_bytes(reader.array("VLAN tag")?) & VLAN_ID);
            ethertype = u16::from_be_bytes(reader.array("EtherType")?);
        }
        Ok(Self { destination, source, vlan, ethertype })
    }

    /// Whether it carries POWERLINK.
    #[must_use]
    pub const fn is_powerlink(&self) -> bool {
        self.ethertype == ETHERTYPE
    }

    /// The bytes of the headers.
    #[must_use]
    pub const fn header_len(&self) -> usize {
        if self.vlan.is_some() { TAGGED } else { ETHERNET_HEADER }
    }

    /// The protocol, where its EtherType is a known one.
    #[must_use]
    pub const fn protocol(&self) -> Option<&'static str> {
        Some(match self.ethertype {
            0..0x0600 => "IEEE 802.3",
            0x0800 => "IPv4",
            0x0806 => "ARP",
            0x86DD => "IPv6",
            ETHERTYPE => "POWERLINK",
            0x8892 => "PROFINET",
            0x88A4 => "EtherCAT",
            0x88CC => "LLDP",
            0x88F7 => "PTP",
            _ => return None,
        })
    }
}

/// The header of POWERLINK.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Ends {
    pub(super) message_type: MessageType,
    pub(super) to: NodeId,
    pub(super) from: NodeId,
}

impl Ends {
    pub(super) fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let [message_type, to, from] = reader.array("POWERLINK header")?;
        let message_type = MessageType(message_type & MESSAGE_TYPE);
        Ok(Self { message_type, to: NodeId(to), from: NodeId(from) })
    }
}

/// EtherType of a VLAN tag, IEEE 802.1Q.
const VLAN: u16 = 0x8100;
const VLAN_ID: u16 = 0x0FFF;
const TAGGED: usize = ETHERNET_HEADER + 4;
/// Bit 7 is reserved.
const MESSAGE_TYPE: u8 = 0x7F;
