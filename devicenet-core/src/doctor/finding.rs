//! What the doctor has found.

use core::time::Duration;

use cip_core::code::{AdditionalCode, GeneralStatus};
use cip_core::message::AllocationChoice;
use link_core::Instant;

use super::errors::ErrorCounts;
use super::rule::{Rule, Severity};
use crate::id::MacId;
use crate::master::ScannerStatus;
use crate::message::DeviceIdentity;

/// Something that is wrong with the network, or was.
///
/// `Display` says it in words, [`advice`](Self::advice) what to check next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Finding {
    /// Its number: 1 for the first of a doctor, and never used again.
    pub id: u32,
    /// Which rule.
    pub rule: Rule,
    /// How bad it is; it can become worse.
    pub severity: Severity,
    /// Which node; `None` for what concerns the bus, or a device without a MAC ID.
    pub node: Option<MacId>,
    /// Since when: the first frame that shows it, or the first that was not answered.
    pub since: Instant,
    /// When it was last seen.
    pub last: Instant,
    /// When it was over; `None` as long as it lasts.
    pub until: Option<Instant>,
    /// How often it was seen.
    pub count: u32,
    /// The frames that show it.
    pub evidence: Evidence,
    /// What exactly was seen.
    pub facts: Facts,
    /// What was wrong before, and as a rule explains it.
    pub first_cause: Option<Rule>,
}

impl Finding {
    /// It does not last any more.
    #[must_use]
    pub const fn is_over(&self) -> bool {
        self.until.is_some()
    }

    /// It is over when it has not recurred for a while: nothing else tells its end.
    pub(super) const fn subsides(&self) -> bool {
        self.rule.subsides() || matches!(self.facts, Facts::Rejected { .. })
    }

    /// It is made of single happenings: what lies between them, or after the last, is only waited out.
    pub(super) const fn is_burst(&self) -> bool {
        self.subsides() || matches!(self.rule, Rule::ErrorFrames)
    }

    /// The code that a scanner display shows for it, if there is one.
    #[must_use]
    pub const fn scanner_status(&self) -> Option<ScannerStatus> {
        match (self.rule, self.facts) {
            (Rule::BusOff, Facts::BusOffCount(_)) => None,
            (Rule::IdentityChanged, _) if matches!(self.severity, Severity::Info) => None,
            _ => self.rule.scanner_status(),
        }
    }
}

/// Numbers of frames: the first few that show a finding, and the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Evidence {
    frames: [u64; Self::CAPACITY],
    len: u8,
}

impl Evidence {
    /// So many frames are kept.
    pub const CAPACITY: usize = 4;

    /// The numbers, as they came.
    #[must_use]
    pub fn frames(&self) -> &[u64] {
        self.frames.get(..usize::from(self.len)).unwrap_or_default()
    }

    pub(super) fn add(&mut self, n: u64) {
        if self.frames().contains(&n) {
            return;
        }
        let place = usize::from(self.len).min(Self::CAPACITY.saturating_sub(1));
        if let Some(slot) = self.frames.get_mut(place) {
            *slot = n;
        }
        if usize::from(self.len) < Self::CAPACITY {
            self.len = self.len.saturating_add(1);
        }
    }
}

/// What a node does not answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Exchange {
    /// Poll commands, and the master's change-of-state messages.
    Poll,
    /// Bit-strobe commands.
    BitStrobe,
    /// It does not send its change-of-state or cyclic messages.
    #[cfg_attr(feature = "serde", serde(rename = "cos_cyclic"))]
    ChangeOfState,
    /// Multicast poll commands.
    MulticastPoll,
    /// Explicit requests.
    Explicit,
}

/// Which part of an identity is another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum KeyField {
    /// Attribute 1.
    Vendor,
    /// Attribute 2.
    DeviceType,
    /// Attribute 3.
    ProductCode,
    /// Attribute 4: the major revision in the high byte, the minor in the low one.
    Revision,
    /// Attribute 6.
    SerialNumber,
}

/// What no DeviceNet node may send.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Foreign {
    /// A 29-bit identifier.
    ExtendedIdentifier,
    /// A remote frame.
    RemoteFrame,
    /// 0x7F0-0x7FF.
    InvalidIdentifier,
    /// Group 4, Message ID 0x00-0x2B.
    ReservedIdentifier,
    /// A CAN FD frame.
    CanFd,
}

/// What exactly was seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Facts {
    /// Nothing but that it is so.
    #[default]
    None,
    /// Nothing came for longer than a peer waits.
    Silence {
        /// Of what.
        exchange: Exchange,
        /// How long a peer waits.
        #[cfg_attr(feature = "serde", serde(serialize_with = "super::json::span"))]
        patience: Duration,
    },
    /// Requests without an answer.
    Requests {
        /// Who has asked last.
        by: Option<MacId>,
        /// How often.
        count: u16,
    },
    /// An answer was late.
    Wait {
        /// The longest wait for an answer.
        #[cfg_attr(feature = "serde", serde(serialize_with = "super::json::span"))]
        longest: Duration,
        /// When the peer gives up.
        #[cfg_attr(feature = "serde", serde(serialize_with = "super::json::span"))]
        patience: Duration,
    },
    /// Slaves without their master.
    Abandoned {
        /// The first of them.
        slave: MacId,
        /// How many.
        slaves: u8,
    },
    /// Two devices with one MAC ID.
    Rivals {
        /// The one that has it, if it is known.
        holder: Option<DeviceIdentity>,
        /// The one that wants it, if it is known.
        rival: Option<DeviceIdentity>,
    },
    /// Two devices that want one MAC ID, which none of them has yet.
    Contenders {
        /// The one that has checked it first.
        first: DeviceIdentity,
        /// The other one.
        second: DeviceIdentity,
    },
    /// A device, whatever its MAC ID.
    Device(DeviceIdentity),
    /// A heartbeat with a fault.
    Heartbeat {
        /// Attribute 8 of the Identity object.
        state: u8,
        /// The fault flags.
        flags: u8,
    },
    /// Attribute 5 of the Identity object, with a fault.
    Status(u16),
    /// A part of the identity is another one than before, or than expected.
    Identity {
        /// Which.
        field: KeyField,
        /// As it was, or should be.
        expected: u32,
        /// As it is.
        found: u32,
    },
    /// The master has read a part of the identity, and let the slave go each time.
    Rejected {
        /// Who, if it is known.
        master: Option<MacId>,
        /// What it has read last.
        field: KeyField,
        /// The value.
        found: u32,
    },
    /// The master has read the size of an I/O connection, and let the slave go each time.
    RejectedSize {
        /// Who, if it is known.
        master: Option<MacId>,
        /// Of which connection.
        exchange: Exchange,
        /// What the slave produces; else what it consumes.
        is_produced: bool,
        /// Bytes.
        found: u16,
    },
    /// An error response.
    Refusal {
        /// To whom.
        master: Option<MacId>,
        /// What it wanted, if the request was seen.
        #[cfg_attr(
            feature = "serde",
            serde(skip_serializing_if = "Option::is_none", serialize_with = "super::json::choice")
        )]
        choice: Option<AllocationChoice>,
        /// General status.
        status: GeneralStatus,
        /// Additional code.
        additional: AdditionalCode,
    },
    /// Whose a slave is, and who else wants it.
    Masters {
        /// The owner, if it is known.
        owner: Option<MacId>,
        /// The other one, if it is known.
        other: Option<MacId>,
    },
    /// The identifier that two nodes send.
    Identifier(u16),
    /// What kind of foreign frame.
    Foreign(Foreign),
    /// Bus load.
    Load {
        /// The highest in a window, in thousandths.
        peak_permille: u16,
    },
    /// Errors on the bus: the most in a window.
    Errors {
        /// How many of which kind.
        kinds: ErrorCounts,
        /// How long the window is.
        #[cfg_attr(feature = "serde", serde(serialize_with = "super::json::span"))]
        window: Duration,
    },
    /// Attempts to send in a row that nobody has acknowledged.
    Attempts(u32),
    /// The bus-off counter that a node has told.
    BusOffCount(u8),
    /// Frames that were lost; 0 if the controller does not count them.
    Lost(u32),
    /// Bytes.
    Length {
        /// The connection size.
        expected: u16,
        /// What came.
        found: u16,
    },
    /// Fragment counts.
    Fragments {
        /// The one before.
        after: u8,
        /// The one found.
        found: u8,
    },
    /// A shutdown code.
    ShutdownCode(u16),
}

/// What has become of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum ChangeKind {
    /// It begins, or is there again.
    Begins,
    /// It is worse than it was.
    Escalates,
    /// It is over.
    Ends,
}

/// News of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Change {
    /// What has become of it.
    pub kind: ChangeKind,
    /// The finding as it is now.
    pub finding: Finding,
}
