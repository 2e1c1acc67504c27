//! `[[action]]`

use devicenet_core::message::DeviceIdentity;
use devicenex_core::OperationalAddress;
use link_core::{BitRate, Instant};

use super::{Kind, NodeIndex};

/// `[[action]]`
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Action {
    /// When.
    pub at: Instant,
    /// To whom; several when the node has a `count`.
    pub nodes: Vec<NodeIndex>,
    /// What.
    pub what: Do,
}

/// What an action does.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Do {
    /// Takes the plug out of the bus; the node keeps its power.
    Cut,
    /// Puts it back.
    Plug,
    /// Switches the node off.
    PowerOff,
    /// Switches it on.
    PowerOn,
    /// Both, one after the other.
    PowerCycle,
    /// Turns the MAC ID switch.
    SetMac(u8),
    /// A device takes another operational address, or none.
    SetOa(OperationalAddress),
    /// A manager gives a node on line another address: from which, to which.
    Readdress(OperationalAddress, OperationalAddress),
    /// Turns the bit rate switch.
    SetBitRate(BitRate),
    /// Resets the device, as its Identity object's Reset service does.
    Reset,
    /// A slave has other input data.
    SetInput(Vec<u8>),
    /// A master has other output data.
    SetOutput(Output),
    /// A master goes to run mode.
    GoRun,
    /// A master goes to idle mode.
    GoIdle,
    /// A tool takes the offline connection set.
    Claim,
    /// A tool gives it up.
    Release,
    /// A tool asks who is faulted.
    Who,
    /// A tool makes the indicator of a faulted device flash.
    Identify(DeviceIdentity),
    /// A tool gives a faulted device another MAC ID.
    Recover(DeviceIdentity, u8),
}

/// What a master sends, and to whom.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Output {
    /// To the slave with this MAC ID.
    Slave(u8, Vec<u8>),
    /// The bit of the slave with this MAC ID in the bit-strobe command.
    StrobeBit(u8, bool),
    /// To all that share its multicast poll.
    Multicast(Vec<u8>),
}

impl Do {
    /// The name in the file.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Cut => "cut",
            Self::Plug => "plug",
            Self::PowerOff => "power_off",
            Self::PowerOn => "power_on",
            Self::PowerCycle => "power_cycle",
            Self::SetMac(_) => "set_mac",
            Self::SetOa(_) => "set_oa",
            Self::Readdress(..) => "readdress",
            Self::SetBitRate(_) => "set_bit_rate",
            Self::Reset => "reset",
            Self::SetInput(_) => "set_input",
            Self::SetOutput(_) => "set_output",
            Self::GoRun => "go_run",
            Self::GoIdle => "go_idle",
            Self::Claim => "claim",
            Self::Release => "release",
            Self::Who => "who",
            Self::Identify(_) => "identify",
            Self::Recover(..) => "recover",
        }
    }

    /// To whom it can be done.
    #[must_use]
    pub const fn kind(&self) -> Kind {
        match self {
            Self::Cut
            | Self::Plug
            | Self::PowerOff
            | Self::PowerOn
            | Self::PowerCycle
            | Self::SetBitRate(_) => Kind::Any,
            Self::SetMac(_) => Kind::DeviceNet,
            Self::SetOa(_) => Kind::Device,
            Self::Readdress(..) => Kind::Manager,
            Self::Reset => Kind::Access,
            Self::SetInput(_) => Kind::Server,
            Self::SetOutput(_) | Self::GoRun | Self::GoIdle => Kind::Master,
            Self::Claim | Self::Release | Self::Who | Self::Identify(_) | Self::Recover(..) => Kind::Tool,
        }
    }
}
