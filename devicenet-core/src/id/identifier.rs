//! The eleven bits: taking apart and building.

use core::fmt;

use link_core::{Frame, StandardId, frame::standard_id};

use super::MacId;

/// An 11-bit identifier as DeviceNet reads it: message group, Message ID, MAC ID.
///
/// Every 11-bit value is one, [`MessageGroup::Invalid`] included, so nothing is lost by the conversion.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(transparent))]
pub struct Identifier(u16);

/// The part of the identifier range that a message belongs to.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum MessageGroup {
    /// 0x000-0x3FF: I/O of slaves, and connections opened dynamically.
    Group1,
    /// 0x400-0x5FF: the predefined master/slave connection set, and the duplicate MAC ID check.
    Group2,
    /// 0x600-0x7BF: explicit messages, connected and unconnected (UCMM).
    Group3,
    /// 0x7C0-0x7EF: the offline connection set.
    Group4,
    /// 0x7F0-0x7FF: never sent.
    Invalid,
}

impl MessageGroup {
    /// 1 to 4; `None` for the invalid range.
    #[must_use]
    pub const fn number(self) -> Option<u8> {
        match self {
            Self::Group1 => Some(1),
            Self::Group2 => Some(2),
            Self::Group3 => Some(3),
            Self::Group4 => Some(4),
            Self::Invalid => None,
        }
    }
}

impl Identifier {
    /// The identifier of that value; `None` for more than eleven bits.
    #[must_use]
    pub const fn new(raw: u16) -> Option<Self> {
        if raw <= MAX { Some(Self(raw)) } else { None }
    }

    /// The identifier of a frame that can be a DeviceNet message: `None` for remote frames and 29-bit identifiers,
    /// which DeviceNet never uses and every node ignores.
    #[must_use]
    pub fn of_frame(frame: &Frame) -> Option<Self> {
        frame.standard_data_id().map(Self::from)
    }

    /// Group 1: `(message << 6) | source`; `None` for a Message ID above 15.
    #[must_use]
    pub const fn group1(message: u8, source: MacId) -> Option<Self> {
        if message <= 0xF { Some(Self::message_first(GROUP_1, message, source)) } else { None }
    }

    /// Group 2: `0x400 | (mac << 3) | message`; `None` for a Message ID above 7.
    #[must_use]
    pub const fn group2(mac: MacId, message: u8) -> Option<Self> {
        if message <= 7 { Some(Self::mac_first(mac, message)) } else { None }
    }

    /// Group 3: `0x600 | (message << 6) | source`; `None` for a Message ID above 6.
    #[must_use]
    pub const fn group3(message: u8, source: MacId) -> Option<Self> {
        if message <= 6 { Some(Self::message_first(GROUP_3, message, source)) } else { None }
    }

    /// Group 4: `0x7C0 | message`; `None` for a Message ID above 0x2F.
    #[must_use]
    pub const fn group4(message: u8) -> Option<Self> {
        if message <= 0x2F { Some(Self(GROUP_4 | widen(message))) } else { None }
    }

    /// `0x300 + slave`: I/O Multicast Poll response.
    #[must_use]
    pub const fn multicast_poll_response(slave: MacId) -> Self {
        Self::message_first(GROUP_1, 0xC, slave)
    }

    /// `0x340 + slave`: I/O Change-of-State or Cyclic message of a slave.
    #[must_use]
    pub const fn change_of_state(slave: MacId) -> Self {
        Self::message_first(GROUP_1, 0xD, slave)
    }

    /// `0x380 + slave`: I/O Bit-Strobe response.
    #[must_use]
    pub const fn bit_strobe_response(slave: MacId) -> Self {
        Self::message_first(GROUP_1, 0xE, slave)
    }

    /// `0x3C0 + slave`: I/O Poll response, or acknowledge of the master's COS/cyclic message.
    #[must_use]
    pub const fn poll_response(slave: MacId) -> Self {
        Self::message_first(GROUP_1, 0xF, slave)
    }

    /// `0x400 + 8 master`: I/O Bit-Strobe command. The MAC ID is the *master's*.
    #[must_use]
    pub const fn bit_strobe_command(master: MacId) -> Self {
        Self::mac_first(master, 0)
    }

    /// `0x401 + 8 group`: I/O Multicast Poll command.
    #[must_use]
    pub const fn multicast_poll_command(group: MacId) -> Self {
        Self::mac_first(group, 1)
    }

    /// `0x402 + 8 slave`: the master's acknowledge of the slave's COS/cyclic message.
    #[must_use]
    pub const fn change_of_state_acknowledge(slave: MacId) -> Self {
        Self::mac_first(slave, 2)
    }

    /// `0x403 + 8 slave`: explicit response, connected or to the Group 2 unconnected port.
    #[must_use]
    pub const fn explicit_response(slave: MacId) -> Self {
        Self::mac_first(slave, 3)
    }

    /// `0x404 + 8 slave`: connected explicit request.
    #[must_use]
    pub const fn explicit_request(slave: MacId) -> Self {
        Self::mac_first(slave, 4)
    }

    /// `0x405 + 8 slave`: I/O Poll command, or the master's COS/cyclic message.
    #[must_use]
    pub const fn poll_command(slave: MacId) -> Self {
        Self::mac_first(slave, 5)
    }

    /// `0x406 + 8 slave`: request to the Group 2 unconnected port (Allocate, Release).
    #[must_use]
    pub const fn group2_unconnected_request(slave: MacId) -> Self {
        Self::mac_first(slave, 6)
    }

    /// `0x407 + 8 node`: duplicate MAC ID check, request and response, of that MAC ID.
    #[must_use]
    pub const fn duplicate_mac_check(node: MacId) -> Self {
        Self::mac_first(node, 7)
    }

    /// `0x740 + source`: UCMM response; heartbeat and shutdown of a UCMM-capable node.
    #[must_use]
    pub const fn unconnected_response(source: MacId) -> Self {
        Self::message_first(GROUP_3, 5, source)
    }

    /// `0x780 + source`: UCMM request.
    #[must_use]
    pub const fn unconnected_request(source: MacId) -> Self {
        Self::message_first(GROUP_3, 6, source)
    }

    /// 0x7EC: answer of a faulted node.
    pub const COMMUNICATION_FAULTED_RESPONSE: Self = Self(0x7EC);
    /// 0x7ED: what the owner of the offline connection set asks faulted nodes.
    pub const COMMUNICATION_FAULTED_REQUEST: Self = Self(0x7ED);
    /// 0x7EE: the owner of the offline connection set defends it.
    pub const OFFLINE_OWNERSHIP_RESPONSE: Self = Self(0x7EE);
    /// 0x7EF: a tool asks for the offline connection set.
    pub const OFFLINE_OWNERSHIP_REQUEST: Self = Self(0x7EF);

    /// The eleven bits.
    #[must_use]
    pub const fn raw(self) -> u16 {
        self.0
    }

    /// The group that the value lies in.
    #[must_use]
    pub const fn group(self) -> MessageGroup {
        match self.0 {
            0..=0x3FF => MessageGroup::Group1,
            0x400..=0x5FF => MessageGroup::Group2,
            0x600..=0x7BF => MessageGroup::Group3,
            0x7C0..=0x7EF => MessageGroup::Group4,
            _ => MessageGroup::Invalid,
        }
    }

    /// The Message ID inside the group: 0-15, 0-7, 0-6 or 0-0x2F; in the invalid range the low four bits.
    #[must_use]
    pub const fn message_id(self) -> u8 {
        match self.group() {
            MessageGroup::Group1 => low_byte(self.0 >> 6),
            MessageGroup::Group2 => low_byte(self.0) & 7,
            MessageGroup::Group3 => low_byte(self.0 >> 6) & 7,
            MessageGroup::Group4 => low_byte(self.0) & 0x3F,
            MessageGroup::Invalid => low_byte(self.0) & 0xF,
        }
    }

    /// The MAC ID in the identifier; Group 4 and the invalid range have none. Whose it is says
    /// [`Purpose::mac_id_role`](super::Purpose::mac_id_role).
    #[must_use]
    pub const fn mac_id(self) -> Option<MacId> {
        match self.group() {
            MessageGroup::Group1 | MessageGroup::Group3 => Some(MacId::from_low_bits(low_byte(self.0))),
            MessageGroup::Group2 => Some(MacId::from_low_bits(low_byte(self.0 >> 3))),
            MessageGroup::Group4 | MessageGroup::Invalid => None,
        }
    }

    /// A data frame with this identifier; `None` for more than eight bytes.
    #[must_use]
    pub fn frame(self, data: &[u8]) -> Option<Frame> {
        Frame::new(StandardId::from(self), data)
    }

    /// A frame with this identifier that has no data yet.
    #[must_use]
    pub fn empty_frame(self) -> Frame {
        Frame::empty(StandardId::from(self))
    }

    /// The same with the first `len` of eight bytes.
    #[must_use]
    pub fn frame_of(self, data: [u8; Frame::MAX_DATA], len: usize) -> Option<Frame> {
        Frame::first_of(StandardId::from(self), data, len)
    }

    const fn message_first(base: u16, message: u8, source: MacId) -> Self {
        Self(base | widen(message) << 6 | widen(source.number()))
    }

    const fn mac_first(mac: MacId, message: u8) -> Self {
        Self(GROUP_2 | widen(mac.number()) << 3 | widen(message))
    }
}

impl From<StandardId> for Identifier {
    fn from(id: StandardId) -> Self {
        Self(id.as_raw())
    }
}

impl From<Identifier> for StandardId {
    fn from(id: Identifier) -> Self {
        standard_id(id.0)
    }
}

impl From<Identifier> for link_core::Id {
    fn from(id: Identifier) -> Self {
        Self::Standard(id.into())
    }
}

/// `group 2, message 7, MAC ID 37`; `group 4, message 0x2F`; `invalid identifier 0x7F3`.
impl fmt::Display for Identifier {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.group().number(), self.mac_id()) {
            (Some(group), Some(mac)) => {
                write!(f, "group {group}, message {}, MAC ID {mac}", self.message_id())
            }
            (Some(group), None) => write!(f, "group {group}, message 0x{:02X}", self.message_id()),
            (None, _) => write!(f, "invalid identifier 0x{:03X}", self.0),
        }
    }
}

impl fmt::Debug for Identifier {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Identifier(0x{:03X})", self.0)
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Identifier {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "0x{=u16:03X}", self.0);
    }
}

const fn widen(byte: u8) -> u16 {
    u16::from_le_bytes([byte, 0])
}

const fn low_byte(value: u16) -> u8 {
    let [low, _] = value.to_le_bytes();
    low
}

const GROUP_1: u16 = 0x000;
const GROUP_2: u16 = 0x400;
const GROUP_3: u16 = 0x600;
const GROUP_4: u16 = 0x7C0;
const MAX: u16 = 0x7FF;

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    fn mac(number: u8) -> MacId {
        MacId::new(number).unwrap()
    }

    /// Taking apart and building are inverse for all 2048 values.
    #[test]
    fn every_identifier_is_rebuilt_from_its_parts() {
        for raw in 0..=MAX {
            let id = Identifier::new(raw).unwrap();
            let rebuilt = match (id.group(), id.mac_id()) {
                (MessageGroup::Group1, Some(mac)) => Identifier::group1(id.message_id(), mac),
                (MessageGroup::Group2, Some(mac)) => Identifier::group2(mac, id.message_id()),
                (MessageGroup::Group3, Some(mac)) => Identifier::group3(id.message_id(), mac),
                (MessageGroup::Group4, None) => Identifier::group4(id.message_id()),
                (MessageGroup::Invalid, None) => {
                    Identifier::new(0x7F0 | u16::from(id.message_id())).filter(|_| raw >= 0x7F0)
                }
                parts => panic!("{parts:?}"),
            };
            assert_eq!(rebuilt, Some(id));
            assert_eq!(Identifier::from(StandardId::from(id)), id);
        }
        assert_eq!(Identifier::new(0x800), None);
    }

    #[test]
    fn parts_out_of_range_build_nothing() {
        assert_eq!(Identifier::group1(16, mac(0)), None);
        assert_eq!(Identifier::group2(mac(0), 8), None);
        assert_eq!(Identifier::group3(7, mac(0)), None, "that would be Group 4");
        assert_eq!(Identifier::group4(0x30), None, "that would be the invalid range");
    }

    /// Feasibility study of DeviceNet over Extended CAN (iCC): the check of MAC ID 37 is 0x52F. The others are
    /// computed by the formulas of CIP Vol. 3.
    #[test]
    fn mac_id_37() {
        let node = mac(37);
        for (id, raw) in [
            (Identifier::duplicate_mac_check(node), 0x52F),
            (Identifier::group2_unconnected_request(node), 0x52E),
            (Identifier::explicit_request(node), 0x52C),
            (Identifier::explicit_response(node), 0x52B),
            (Identifier::poll_command(node), 0x52D),
            (Identifier::poll_response(node), 0x3E5),
            (Identifier::change_of_state(node), 0x365),
            (Identifier::change_of_state_acknowledge(node), 0x52A),
            (Identifier::bit_strobe_command(node), 0x528),
            (Identifier::bit_strobe_response(node), 0x3A5),
            (Identifier::multicast_poll_command(node), 0x529),
            (Identifier::multicast_poll_response(node), 0x325),
            (Identifier::unconnected_request(node), 0x7A5),
            (Identifier::unconnected_response(node), 0x765),
        ] {
            assert_eq!(id.raw(), raw);
            assert_eq!(id.mac_id(), Some(node));
        }
    }

    #[test]
    fn reads_as_words() {
        let text = |raw| Identifier::new(raw).unwrap().to_string();
        assert_eq!(text(0x52F), "group 2, message 7, MAC ID 37");
        assert_eq!(text(0x3C5), "group 1, message 15, MAC ID 5");
        assert_eq!(text(0x7BF), "group 3, message 6, MAC ID 63");
        assert_eq!(text(0x7EF), "group 4, message 0x2F");
        assert_eq!(text(0x7F3), "invalid identifier 0x7F3");
    }

    #[test]
    fn remote_and_extended_frames_have_no_devicenet_identifier() {
        let id = StandardId::new(0x52F).unwrap();
        assert_eq!(Identifier::of_frame(&Frame::remote(id, 0).unwrap()), None);
        let extended = link_core::ExtendedId::new(0x52F).unwrap();
        assert_eq!(Identifier::of_frame(&Frame::new(extended, &[]).unwrap()), None);
        assert_eq!(Identifier::of_frame(&Frame::new(id, &[]).unwrap()), Identifier::new(0x52F));
    }
}
