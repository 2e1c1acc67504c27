//! What network access tells the application, and what it counts.

use core::fmt;

use link_core::link::LinkCommandKind;
use link_core::{BitRate, Frame, TxOutcome};

use super::state::{Cause, StateKind};
use crate::id::OperationalAddress;
use crate::message::{DeviceIdentity, Hello, ParseError, Roam};

/// What happened.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AccessEvent {
    /// Another state. On line begins, or communication ends: delete all connections when `from` is
    /// [`StateKind::Online`].
    StateChanged {
        /// The state that was left.
        from: StateKind,
        /// The state that was entered.
        to: StateKind,
        /// Why.
        cause: Cause,
    },
    /// The rate of the bus is known; `None` for that of the link, which nobody told.
    BitRateLocked(Option<BitRate>),
    /// A network manager gave the device an address.
    AddressAssigned {
        /// It says Hello with it now.
        address: OperationalAddress,
    },
    /// Another node has the address of this one, which gives it up and starts anew without one.
    AddressTaken {
        /// The address that was given up.
        address: OperationalAddress,
        /// Who has it.
        by: DeviceIdentity,
    },
    /// Another device wants the address of this one, and is being told that it is taken.
    Defended {
        /// Who wants it.
        against: DeviceIdentity,
    },
    /// A Hello with the address and the identity of this node: the port delivers the node's own frames back, or the
    /// identity was given to two devices. It changes nothing.
    OwnIdentity(Hello),
    /// A ROAM for this device was not obeyed.
    RoamRefused {
        /// What it asks for.
        requested: OperationalAddress,
        /// Why it was not obeyed.
        why: RoamRefusal,
    },
    /// Nobody acknowledges the Hello: alone on the bus, among detectors, or the wrong bit rate. Told once for each Hello;
    /// the controller goes on.
    NotAcknowledged,
    /// A frame was given back unsent although nobody asked for it.
    NotSent {
        /// Which.
        what: Outgoing,
        /// What the controller says.
        outcome: TxOutcome,
    },
    /// A Hello or ROAM cannot be read, and was ignored. [`error`](AccessEvent::error) says what is wrong with it.
    BadFrame(Frame),
    /// Frames were lost before they could be looked at: another owner of the address may have gone unnoticed.
    FramesLost {
        /// How many, 0 if the controller does not count.
        count: u32,
    },
    /// The port cannot do what it was asked.
    LinkRefused(LinkCommandKind),
}

impl AccessEvent {
    /// What is wrong with a [`BadFrame`](Self::BadFrame).
    #[must_use]
    pub fn error(&self) -> Option<ParseError> {
        let Self::BadFrame(frame) = self else { return None };
        let hello = Hello::of_frame(frame).and_then(Result::err);
        hello.or_else(|| Roam::of_frame(frame).and_then(Result::err))
    }
}

/// Why a ROAM for this device was not obeyed.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum RoamRefusal {
    /// It has an address **\[P\]**, or has not finished its two Hellos **\[D\]**.
    NotInStandby,
    /// It asks for address 127, which is none **\[D\]**.
    NoAddress,
}

/// The frames that network access sends.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Outgoing {
    /// One of the two Hello requests, or that which answers a Mini-who.
    Hello,
    /// The Hello request once more, against another node that joins.
    HelloAgain,
    /// Hello response.
    HelloResponse,
}

/// What network access counted. Every counter stays at its maximum.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Counters {
    /// Hello requests of others for the own address, against which it was defended.
    pub challenges: u16,
    /// Hello responses that were sent, announcements included.
    pub responses: u16,
    /// Requests, Mini-whos and announcements that one message answers together with an earlier one.
    pub merged: u16,
    /// How often the address was given up because another node has it.
    pub addresses_lost: u16,
    /// Hellos with the own address and the own identity.
    pub own_identity: u16,
    /// Mini-whos that were answered.
    pub mini_whos: u16,
    /// ROAMs that were obeyed.
    pub roams: u16,
    /// ROAMs for other devices: one byte of the identity that differs is enough.
    pub roams_for_others: u16,
    /// ROAMs for this device that were not obeyed.
    pub roams_refused: u16,
    /// Hellos and ROAMs that cannot be read.
    pub bad_frames: u16,
    /// Frames discarded because the node does not listen to them in its state.
    pub discarded: u32,
    /// Attempts to send a Hello that nobody acknowledged, as far as the controller tells.
    pub unacknowledged: u32,
    /// Errors seen while the bit rate was being detected.
    pub detection_errors: u32,
    /// Frames that were given back unsent although nobody asked for it.
    pub not_sent: u16,
    /// Frames lost before they could be looked at.
    pub frames_lost: u32,
    /// Link commands that were refused.
    pub refused: u16,
    /// Answers to transmissions that were not under way: the port breaks the contract.
    pub stray_tx_done: u16,
    /// Events that were lost because nobody fetched them.
    pub events_lost: u16,
}

/// One line, in the words of a trace.
impl fmt::Display for AccessEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StateChanged { from, to, cause } => write!(f, "{from} -> {to}: {cause}"),
            Self::BitRateLocked(Some(rate)) => write!(f, "bit rate {rate}"),
            Self::BitRateLocked(None) => f.write_str("bit rate of the link"),
            Self::AddressAssigned { address } => write!(f, "OA {address} assigned"),
            Self::AddressTaken { address, by } => write!(f, "OA {address} is taken by {by}"),
            Self::Defended { against } => write!(f, "OA defended against {against}"),
            Self::OwnIdentity(hello) => write!(f, "own identity in {hello}"),
            Self::RoamRefused { requested, why: RoamRefusal::NotInStandby } => {
                write!(f, "ROAM to OA {requested} refused: not in Standby")
            }
            Self::RoamRefused { requested, why: RoamRefusal::NoAddress } => {
                write!(f, "ROAM to OA {requested} refused: that is none")
            }
            Self::NotAcknowledged => f.write_str("nobody acknowledges: alone on the bus, or wrong bit rate"),
            Self::NotSent { what, outcome } => write!(f, "{what} not sent: {outcome:?}"),
            Self::BadFrame(frame) => {
                write!(f, "bad frame {frame}")?;
                self.error().map_or(Ok(()), |error| write!(f, ": {error}"))
            }
            Self::FramesLost { count } => write!(f, "{count} frames lost"),
            Self::LinkRefused(kind) => write!(f, "{kind:?} refused"),
        }
    }
}

impl fmt::Display for Outgoing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Hello => "Hello request",
            Self::HelloAgain => "Hello request once more",
            Self::HelloResponse => "Hello response",
        })
    }
}
