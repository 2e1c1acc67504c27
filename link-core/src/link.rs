//! What happens below the frame: controller states, error kinds, bit rate and mode.

use core::fmt;

use crate::filter::FilterSet;

/// A bit rate in bit/s.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BitRate(pub u32);

impl BitRate {
    /// 125 kbit/s, the DeviceNet default.
    pub const K125: Self = Self(125_000);
    /// 250 kbit/s.
    pub const K250: Self = Self(250_000);
    /// 500 kbit/s.
    pub const K500: Self = Self(500_000);
    /// 1 Mbit/s, the highest rate of classic CAN.
    pub const M1: Self = Self(1_000_000);

    /// The length of one bit in nanoseconds, rounded down; a rate of zero has none.
    #[must_use]
    pub fn bit_time_nanos(self) -> Option<u64> {
        1_000_000_000_u64.checked_div(u64::from(self.0))
    }
}

/// `125 kbit/s`
impl fmt::Display for BitRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.0 / 1_000, self.0 % 1_000) {
            (kilo, 0) => write!(f, "{kilo} kbit/s"),
            _ => write!(f, "{} bit/s", self.0),
        }
    }
}

/// How a controller takes part in the bus.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Mode {
    /// The rate at which it samples and sends.
    pub bit_rate: BitRate,
    /// It neither sends, nor acknowledges, nor flags errors.
    pub listen_only: bool,
}

/// What a machine asks of its controller.
///
/// A port answers each with a [`LinkEvent`]: [`ModeSet`](LinkEvent::ModeSet), [`FilterSet`](LinkEvent::FilterSet),
/// [`Up`](LinkEvent::Up) after a reset, or [`Refused`](LinkEvent::Refused) where the transport or the rights of the
/// program do not allow it.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum LinkCommand {
    /// Change bit rate and mode. Pending transmissions are dropped; their answers come before or after
    /// [`ModeSet`](LinkEvent::ModeSet).
    SetMode(Mode),
    /// Deliver only frames that pass one of these filters. A port may deliver more.
    SetFilter(FilterSet),
    /// Take the controller out of bus-off or restart it, with both error counters zero. After bus-off the bus must
    /// be seen recessive for 128 times 11 bits before [`LinkEvent::Up`] tells that it takes part again.
    Reset,
}

/// The kinds of [`LinkCommand`], for an answer.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum LinkCommandKind {
    /// [`LinkCommand::SetMode`]
    SetMode,
    /// [`LinkCommand::SetFilter`]
    SetFilter,
    /// [`LinkCommand::Reset`]
    Reset,
}

impl LinkCommand {
    /// Which command it is.
    #[must_use]
    pub const fn kind(&self) -> LinkCommandKind {
        match self {
            Self::SetMode(_) => LinkCommandKind::SetMode,
            Self::SetFilter(_) => LinkCommandKind::SetFilter,
            Self::Reset => LinkCommandKind::Reset,
        }
    }
}

/// What a controller tells its machine.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum LinkEvent {
    /// The controller takes part in the bus: after power-up, after a cable or an interface came back, and after
    /// [`LinkCommand::Reset`] once the bus-off recovery sequence was seen.
    Up,
    /// The controller no longer takes part, for a reason other than bus-off: interface down, adapter unplugged,
    /// network power lost. What was in flight is answered by [`TxOutcome::Dropped`](crate::TxOutcome::Dropped).
    Down,
    /// One of the error counters reached 96.
    ErrorWarning,
    /// One of the error counters exceeds 127: the node sends passive error flags.
    ErrorPassive,
    /// Both counters are below 128 again.
    ErrorActive,
    /// TEC exceeds 255: the node has left the bus and stays away until [`LinkCommand::Reset`].
    BusOff,
    /// An error on the bus, seen as a sender or as a receiver.
    BusError(BusErrorKind),
    /// The error counters, where the controller tells them: before the change of state to which they led, and whenever
    /// the driver likes to.
    Counters {
        /// Transmit error counter, 0 to 256.
        tec: u16,
        /// Receive error counter.
        rec: u16,
    },
    /// Frames were received and lost before they could be delivered.
    Overrun {
        /// How many, or 0 where the controller does not count.
        lost: u32,
    },
    /// [`LinkCommand::SetMode`] is in force.
    ModeSet(Mode),
    /// [`LinkCommand::SetFilter`] is in force.
    FilterSet,
    /// The command cannot be carried out here.
    Refused(LinkCommandKind),
}

/// The five errors of CAN 2.0, and what a driver cannot tell apart.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum BusErrorKind {
    /// The bus was not what was sent.
    Bit,
    /// Six equal bits where stuffing forbids them.
    Stuff,
    /// The CRC received is not the one computed.
    Crc,
    /// A fixed-form field held an illegal bit.
    Form,
    /// Nobody pulled the ACK slot dominant.
    Ack,
    /// The driver reports an error without its kind.
    Other,
}

/// `bit error`
impl fmt::Display for BusErrorKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Bit => "bit error",
            Self::Stuff => "stuff error",
            Self::Crc => "CRC error",
            Self::Form => "form error",
            Self::Ack => "ACK error",
            Self::Other => "bus error",
        })
    }
}
