//! The scan list: what a master exchanges with each slave, and how it knows the right one.

use cip_core::code::{DeviceType, InstanceId, VendorId};
use cip_core::fragment::IO_MESSAGE_MAX;
use cip_core::identity::Revision;
use cip_core::message::AllocationChoice;

use crate::id::MacId;

/// One slave.
///
/// An entry without I/O connections is a node that only explicit messages are sent to.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ScanEntry {
    /// The slave.
    pub mac_id: MacId,
    /// What it must be.
    pub key: ElectronicKey,
    /// Poll.
    pub poll: Option<PollConnection>,
    /// Bit-strobe.
    pub bit_strobe: Option<BitStrobeConnection>,
    /// Change of state, or cyclic.
    pub change_of_state: Option<ChangeOfStateConnection>,
    /// Multicast poll; the master's MAC ID names the group.
    pub multicast_poll: Option<PollConnection>,
    /// Whether its polls are sent in every scan.
    pub rate: ScanRate,
    /// Whether a new device may take its place by itself, if its key names at least vendor and product code.
    pub replaceable: bool,
}

/// What must be equal in the Identity object. Fields that are `None` are not looked at.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ElectronicKey {
    /// Attribute 1.
    pub vendor: Option<VendorId>,
    /// Attribute 2.
    pub device_type: Option<DeviceType>,
    /// Attribute 3.
    pub product_code: Option<u16>,
    /// Attribute 4: the major revision must be equal, the minor revision equal or higher.
    pub revision: Option<Revision>,
}

impl ElectronicKey {
    /// Whether a revision is good enough.
    #[must_use]
    pub fn accepts_revision(&self, found: Revision) -> bool {
        self.revision.is_none_or(|key| found.major == key.major && found.minor >= key.minor)
    }
}

/// A poll or multicast poll connection. Sizes are seen from the slave.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PollConnection {
    /// Bytes in the response, the master's input.
    pub produce: u16,
    /// Bytes in the command, the master's output.
    pub consume: u16,
    /// Expected packet rate in ms; 0: no time-out.
    pub expected_packet_rate: u16,
}

/// A bit-strobe connection. The slave consumes one bit.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BitStrobeConnection {
    /// Bytes in the response, 0-8.
    pub produce: u16,
    /// Expected packet rate in ms; 0: no time-out.
    pub expected_packet_rate: u16,
}

/// A change-of-state or cyclic connection. Sizes are seen from the slave.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ChangeOfStateConnection {
    /// Cyclic instead of change of state.
    pub cyclic: bool,
    /// Whether each message is acknowledged.
    pub acknowledged: bool,
    /// Bytes that the slave sends.
    pub produce: u16,
    /// Bytes that the master sends, at its expected packet rate and when they change. With poll, the poll command
    /// carries them instead.
    pub consume: u16,
    /// Expected packet rate in ms: the longest time between two messages; 0: only changes.
    pub expected_packet_rate: u16,
    /// Production inhibit time of the slave in ms, at most the expected packet rate; 0: none.
    pub inhibit: u16,
}

/// How often a slave is polled.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum ScanRate {
    /// In every scan.
    #[default]
    Foreground,
    /// Once in as many scans as the foreground to background poll ratio says.
    Background,
}

/// Why an entry cannot be in the scan list: scanner status 71.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ScanListError {
    /// A master has no business with itself.
    #[error("MAC ID {0} is the master's own: give the slave another")]
    OwnMacId(MacId),
    /// Two entries for one slave.
    #[error("MAC ID {0} is in the scan list already: remove that entry first")]
    AlreadyListed(MacId),
    /// More slaves than the machine was made for.
    #[error("the scan list is full: it holds {0} slaves")]
    Full(usize),
    /// A connection that the machine has no room for, or that no connection can carry.
    #[error("{connection} connection of {size} bytes: at most {most} fit")]
    TooLong {
        /// Which connection.
        connection: IoInstance,
        /// The size asked for.
        size: u16,
        /// The greatest size.
        most: usize,
    },
    /// The inhibit time delays beyond the expected packet rate.
    #[error("inhibit time {inhibit} ms exceeds the expected packet rate {rate} ms: make it shorter")]
    InhibitTooLong {
        /// The inhibit time.
        inhibit: u16,
        /// The expected packet rate.
        rate: u16,
    },
    /// All slaves of the multicast poll group receive the same command.
    #[error("a multicast poll command of {found} bytes, but the group's has {expected}: make them equal")]
    GroupSize {
        /// As the slaves in the list have it.
        expected: u16,
        /// In the new entry.
        found: u16,
    },
    /// Nobody knows that MAC ID.
    #[error("MAC ID {0} is not in the scan list: add it first")]
    NotListed(MacId),
    /// The configuration does not fit.
    #[error("the attribute writes take more than {0} bytes")]
    TooManyWrites(usize),
}

/// An I/O connection instance of the predefined set.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum IoInstance {
    /// Instance 2; with change of state or cyclic also the direction to the slave.
    Poll,
    /// Instance 3.
    BitStrobe,
    /// Instance 4.
    ChangeOfState,
    /// Instance 5.
    MulticastPoll,
}

impl IoInstance {
    /// In the order of their instance numbers.
    pub const ALL: [Self; 4] = [Self::Poll, Self::BitStrobe, Self::ChangeOfState, Self::MulticastPoll];

    /// The instance of the Connection object.
    #[must_use]
    pub const fn instance(self) -> InstanceId {
        InstanceId(match self {
            Self::Poll => 2,
            Self::BitStrobe => 3,
            Self::ChangeOfState => 4,
            Self::MulticastPoll => 5,
        })
    }

    pub(super) const fn index(self) -> usize {
        match self {
            Self::Poll => 0,
            Self::BitStrobe => 1,
            Self::ChangeOfState => 2,
            Self::MulticastPoll => 3,
        }
    }
}

impl core::fmt::Display for IoInstance {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Poll => "poll",
            Self::BitStrobe => "bit-strobe",
            Self::ChangeOfState => "COS/cyclic",
            Self::MulticastPoll => "multicast poll",
        })
    }
}

/// What is agreed with a slave about one instance. Sizes are `None` where nothing is expected of them.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct Agreed {
    pub(super) produce: Option<u16>,
    pub(super) consume: Option<u16>,
    pub(super) expected_packet_rate: u16,
    pub(super) inhibit: u16,
}

impl ScanEntry {
    /// An entry without I/O and without a key.
    #[must_use]
    pub fn explicit_only(mac_id: MacId) -> Self {
        Self {
            mac_id,
            key: ElectronicKey::default(),
            poll: None,
            bit_strobe: None,
            change_of_state: None,
            multicast_poll: None,
            rate: ScanRate::Foreground,
            replaceable: false,
        }
    }

    /// The I/O part of the allocation choice.
    #[must_use]
    pub fn choice(&self) -> AllocationChoice {
        let mut choice = AllocationChoice::empty();
        choice.set(AllocationChoice::POLL, self.poll.is_some());
        choice.set(AllocationChoice::BIT_STROBE, self.bit_strobe.is_some());
        choice.set(AllocationChoice::MULTICAST_POLL, self.multicast_poll.is_some());
        if let Some(change) = self.change_of_state {
            choice.set(AllocationChoice::CYCLIC, change.cyclic);
            choice.set(AllocationChoice::CHANGE_OF_STATE, !change.cyclic);
            choice.set(AllocationChoice::ACK_SUPPRESSION, !change.acknowledged);
        }
        choice
    }

    /// What the entry wants of an instance; `None` if the instance is not used.
    pub(super) fn agreed(&self, instance: IoInstance) -> Option<Agreed> {
        let polled = |poll: PollConnection| Agreed {
            produce: Some(poll.produce),
            consume: Some(poll.consume),
            expected_packet_rate: poll.expected_packet_rate,
            inhibit: 0,
        };
        match instance {
            IoInstance::Poll => match (self.poll, self.change_of_state) {
                (Some(poll), _) => Some(polled(poll)),
                (None, Some(change)) => Some(Agreed {
                    produce: None,
                    consume: Some(change.consume),
                    expected_packet_rate: change.expected_packet_rate,
                    inhibit: 0,
                }),
                (None, None) => None,
            },
            IoInstance::BitStrobe => self.bit_strobe.map(|strobe| Agreed {
                produce: Some(strobe.produce),
                consume: None,
                expected_packet_rate: strobe.expected_packet_rate,
                inhibit: 0,
            }),
            IoInstance::ChangeOfState => self.change_of_state.map(|change| Agreed {
                produce: Some(change.produce),
                consume: None,
                expected_packet_rate: change.expected_packet_rate,
                inhibit: change.inhibit,
            }),
            IoInstance::MulticastPoll => self.multicast_poll.map(polled),
        }
    }

    /// The bytes that the master sends to this slave alone.
    #[must_use]
    pub fn output_len(&self) -> usize {
        self.agreed(IoInstance::Poll).and_then(|agreed| agreed.consume).unwrap_or(0).into()
    }

    /// Refuses what cannot work. `room` is the longest message that the machine holds.
    pub(super) fn check(&self, room: usize) -> Result<(), ScanListError> {
        for instance in IoInstance::ALL {
            let Some(agreed) = self.agreed(instance) else { continue };
            let most = match instance {
                IoInstance::BitStrobe => BIT_STROBE_MAX.min(room),
                IoInstance::Poll | IoInstance::ChangeOfState | IoInstance::MulticastPoll => {
                    IO_MESSAGE_MAX.min(room)
                }
            };
            for size in [agreed.produce, agreed.consume].into_iter().flatten() {
                if usize::from(size) > most {
                    return Err(ScanListError::TooLong { connection: instance, size, most });
                }
            }
            let (inhibit, rate) = (agreed.inhibit, agreed.expected_packet_rate);
            if rate != 0 && inhibit > rate {
                return Err(ScanListError::InhibitTooLong { inhibit, rate });
            }
        }
        Ok(())
    }
}

/// A bit-strobe response is one frame.
const BIT_STROBE_MAX: usize = 8;
