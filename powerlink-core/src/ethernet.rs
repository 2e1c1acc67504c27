//! What POWERLINK uses of Ethernet: addresses, the EtherType, lengths.
//!
//! # Lengths
//!
//! One frame has several limits in the literature, because each counts another part of it:
//!
//! | Bytes | of what | constant |
//! |---|---|---|
//! | 64-1518 | Ethernet frame with header and CRC, without preamble | |
//! | 60-1514 | the same without the CRC, which the adapter makes and checks: what this crate reads and writes | [`MIN_FRAME`], [`MAX_FRAME`] |
//! | 46-1500 | Ethernet payload: the frame without the 14 bytes of the Ethernet header | [`MAX_ETHERNET_PAYLOAD`] |
//! | 43-1497 | data behind the three bytes of the POWERLINK header (message type, destination, source) | [`MAX_DATA`] |
//! | 0-1490 | process data of PReq and PRes, whose own header has ten bytes, the three included | [`MAX_PROCESS_DATA`] |
//!
//! So "three bytes of header and up to 1497 of payload" and "at most 1490 bytes" are both right: 1500 - 3 and 1500 - 10.
//!
//! Frames are written with at least [`MIN_FRAME`] bytes, and read with fewer: on a virtual link nobody pads.

use core::fmt;

/// The shortest frame that a node sends.
pub const MIN_FRAME: usize = 60;
/// The longest frame.
pub const MAX_FRAME: usize = 1514;
/// Destination, source and EtherType.
pub const ETHERNET_HEADER: usize = 14;
/// The longest Ethernet payload.
pub const MAX_ETHERNET_PAYLOAD: usize = MAX_FRAME - ETHERNET_HEADER;
/// Message type, destination node, source node.
pub const POWERLINK_HEADER: usize = 3;
/// The most data behind the POWERLINK header.
pub const MAX_DATA: usize = MAX_ETHERNET_PAYLOAD - POWERLINK_HEADER;
/// The header of PReq and PRes, the POWERLINK header included.
pub const POLL_HEADER: usize = 10;
/// The most process data of PReq and PRes.
pub const MAX_PROCESS_DATA: usize = MAX_ETHERNET_PAYLOAD - POLL_HEADER;

/// EtherType of POWERLINK, the only field in network order.
pub const ETHERTYPE: u16 = 0x88AB;

/// An Ethernet address.
///
/// ```
/// use powerlink_core::MacAddress;
///
/// assert_eq!(MacAddress::SOC.to_string(), "01-11-1E-00-00-01");
/// assert!(MacAddress::SOC.is_group());
/// ```
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
pub struct MacAddress(pub [u8; 6]);

impl MacAddress {
    /// Every station.
    pub const BROADCAST: Self = Self([0xFF; 6]);
    /// Where SoC goes.
    pub const SOC: Self = Self::group(1);
    /// Where PRes goes.
    pub const PRES: Self = Self::group(2);
    /// Where SoA goes.
    pub const SOA: Self = Self::group(3);
    /// Where ASnd goes, also one for a single node.
    pub const ASND: Self = Self::group(4);

    const fn group(last: u8) -> Self {
        Self([0x01, 0x11, 0x1E, 0x00, 0x00, last])
    }

    /// Whether it is one of several stations.
    #[must_use]
    pub const fn is_group(self) -> bool {
        let [first, ..] = self.0;
        first & 0x01 != 0
    }
}

/// `01-11-1E-00-00-01`
impl fmt::Display for MacAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [a, b, c, d, e, g] = self.0;
        write!(f, "{a:02X}-{b:02X}-{c:02X}-{d:02X}-{e:02X}-{g:02X}")
    }
}

impl fmt::Debug for MacAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// JVL, *Ethernet expansion modules for MAC motors*, 5.2.2: frames of 64 to 1518 bytes, header of 3, data of 43 to 1497.
    /// EPSG object templates: 0x1F98/4 and /5 up to 1490.
    #[test]
    fn the_limits_of_manual_and_specification_fit() {
        const CRC: usize = 4;
        assert_eq!((MIN_FRAME + CRC, MAX_FRAME + CRC), (64, 1518));
        assert_eq!((MIN_FRAME - ETHERNET_HEADER - POWERLINK_HEADER, MAX_DATA), (43, 1497));
        assert_eq!((MAX_PROCESS_DATA, ETHERNET_HEADER + POLL_HEADER), (1490, 24));
    }
}
