//! Of which network a capture is.

/// The networks whose captures are read.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Network {
    /// A CAN bus: `LINKTYPE_CAN_SOCKETCAN`.
    Can,
    /// Ethernet: `LINKTYPE_ETHERNET`.
    Ethernet,
}

impl Network {
    /// Its number in the tcpdump.org list.
    pub(super) const fn link_type(self) -> u32 {
        match self {
            Self::Can => super::socketcan::LINK_TYPE,
            Self::Ethernet => 1,
        }
    }

    pub(super) fn of_link_type(number: u32) -> Option<Self> {
        [Self::Can, Self::Ethernet].into_iter().find(|network| network.link_type() == number)
    }

    /// How to get a capture of it.
    pub(super) const fn advice(self) -> &'static str {
        match self {
            Self::Can => "capture on a CAN interface, for instance `tshark -i can0 -w FILE`",
            Self::Ethernet => "capture on an Ethernet interface, for instance `tshark -i eth0 -w FILE`",
        }
    }
}
