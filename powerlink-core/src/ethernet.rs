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

pub use link_core::ethernet::{
    HEADER as ETHERNET_HEADER, MAX_FRAME, MAX_PAYLOAD as MAX_ETHERNET_PAYLOAD, MIN_FRAME, MacAddress,
};

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

/// The addresses to which all stations listen.
pub mod group {
    use super::MacAddress;

    /// Where SoC goes.
    pub const SOC: MacAddress = address(1);
    /// Where PRes goes.
    pub const PRES: MacAddress = address(2);
    /// Where SoA goes.
    pub const SOA: MacAddress = address(3);
    /// Where ASnd goes, also one for a single node.
    pub const ASND: MacAddress = address(4);

    const fn address(last: u8) -> MacAddress {
        MacAddress([0x01, 0x11, 0x1E, 0x00, 0x00, last])
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
