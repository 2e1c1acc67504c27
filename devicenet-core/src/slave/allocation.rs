//! Allocate and Release of the predefined connection set, with every check in its order.

use cip_core::code::{AdditionalCode, GeneralStatus};
use cip_core::codec::Writer;
use cip_core::connection::{ExplicitCause, ExplicitState, IoCause, IoState, PredefinedConnection};
use cip_core::message::{AllocationChoice, BodyFormat};
use cip_core::object::{Failure, exact};

use super::application::{Application, IoKind};
use super::config::Options;
use super::dynamic::Group;
use super::machine::changes;
use super::node::{BOTH, Changed, Node, Parent};
use super::server::offered;
use crate::id::MacId;

/// Who asks, and where.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct Requester {
    pub(super) mac: MacId,
    pub(super) door: Door,
    /// Of the connection.
    pub(super) format: BodyFormat,
}

/// The way on which a request came.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Door {
    /// The Group 2 unconnected port.
    Unconnected,
    /// Instance 1.
    Predefined,
    /// A connection that was opened through the UCMM.
    Dynamic(u8),
}

impl<A: Application, const DYNAMIC: usize> Node<A, DYNAMIC> {
    /// Allocate_Master/Slave_Connection_Set. The first condition that holds gives the answer, and then nothing changes:
    ///
    /// | # | Condition | General / additional |
    /// |---|---|---|
    /// | 0 | not two bytes of data | 0x13, 0x15 |
    /// | 1 | owned by another master | 0x0C / 0x01 |
    /// | 2 | nothing chosen | 0x09 / 0x02 |
    /// | 3 | acknowledge suppression without change of state or cyclic | 0x09 / 0x02 |
    /// | 4 | a connection that this device does not have | 0x02 / 0x02 |
    /// | 5 | on the unconnected port, with no explicit connection chosen or existing | 0x09 / 0x02 |
    /// | 6 | a connection that is allocated already | 0x0B / 0x02 |
    /// | 7 | change of state and cyclic together | 0x09 / 0x02 |
    /// | 8 | bit 7 of the choice, bit 6 or 7 of the allocator, an allocator other than the requester where that matters | 0x09 / 0x02 |
    /// | 9 | an identifier is used by a connection opened through the UCMM | 0x02 / 0x04 |
    ///
    /// `offer`: the connections that the device has.
    pub(super) fn allocate(
        &mut self,
        offer: AllocationChoice,
        requester: Requester,
        data: &[u8],
        out: &mut Writer<'_>,
    ) -> Result<(), Failure> {
        let [choice, allocator] = exact(data)?;
        let choice = AllocationChoice::from_bits_retain(choice);
        let master = self.check_allocate(offer, requester, choice, allocator)?;
        // The only data of the response; without room for it nothing has been allocated.
        out.u8(match requester.door {
            Door::Dynamic(_) if DYNAMIC > 0 => requester.format.code(),
            Door::Unconnected | Door::Predefined | Door::Dynamic(_) => BodyFormat::Class8Instance8.code(),
        })?;
        if self.master.is_none() {
            self.release_timed_out();
            self.held = AllocationChoice::empty();
            if A::IO.contains(AllocationChoice::MULTICAST_POLL) {
                self.group = self.foreign_group.unwrap_or(master);
            }
        }
        self.master = Some(master);
        self.parent = match requester.door {
            Door::Dynamic(index)
                if DYNAMIC > 0
                    && !choice.contains(AllocationChoice::EXPLICIT)
                    && self.explicit.state() == ExplicitState::NonExistent =>
            {
                Parent::Dynamic(index)
            }
            Door::Unconnected | Door::Predefined | Door::Dynamic(_) => Parent::Predefined,
        };
        self.create(choice);
        self.allocation_changed();
        self.changed.insert(Changed::CONNECTIONS);
        Ok(())
    }

    /// Release_Master/Slave_Connection_Set. The first condition that holds gives the answer, and then nothing changes:
    ///
    /// | # | Condition | General / additional |
    /// |---|---|---|
    /// | 0 | not one byte of data | 0x13, 0x15 |
    /// | 1 | owned by another master | 0x0C / 0x01 |
    /// | 2 | nothing chosen, or bit 7 | 0x09 / 0x02 |
    /// | 3 | a connection that this device does not have | 0x02 / 0x02 |
    /// | 4 | a connection that does not exist | 0x0B / 0x02 |
    pub(super) fn release(
        &mut self,
        offer: AllocationChoice,
        requester: Requester,
        data: &[u8],
    ) -> Result<(), Failure> {
        let [choice] = exact(data)?;
        let mut choice = AllocationChoice::from_bits_retain(choice);
        if self.options.contains(Options::RELEASE_BY_OWNER_ONLY)
            && self.master.is_some_and(|master| master != requester.mac)
        {
            return Err(CONFLICT);
        }
        if self.options.contains(Options::RELEASE_IGNORES_BIT_6) {
            choice.remove(AllocationChoice::ACK_SUPPRESSION);
        }
        if choice.is_empty() || choice.intersects(NO_CONNECTION) {
            return Err(INVALID_CHOICE);
        }
        if !offer.contains(choice) {
            return Err(NOT_OFFERED);
        }
        if !self.held.contains(choice) {
            return Err(ALREADY);
        }
        self.delete(choice);
        self.allocation_changed();
        self.changed.insert(Changed::CONNECTIONS);
        Ok(())
    }

    fn check_allocate(
        &self,
        offer: AllocationChoice,
        requester: Requester,
        choice: AllocationChoice,
        allocator: u8,
    ) -> Result<MacId, Failure> {
        if self.master.is_some_and(|master| master.number() != allocator) {
            return Err(CONFLICT);
        }
        let suppressed = choice.contains(AllocationChoice::ACK_SUPPRESSION);
        let connections = choice.difference(NO_CONNECTION);
        if choice.is_empty() || (suppressed && !choice.intersects(BOTH)) {
            return Err(INVALID_CHOICE);
        }
        if !offer.contains(connections) {
            return Err(NOT_OFFERED);
        }
        if requester.door == Door::Unconnected
            && !choice.contains(AllocationChoice::EXPLICIT)
            && self.explicit.state() == ExplicitState::NonExistent
        {
            return Err(INVALID_CHOICE);
        }
        let allocated = self.choice();
        let changes_too = changes::<A>() && allocated.intersects(BOTH) && connections.intersects(BOTH);
        if allocated.intersects(connections) || changes_too {
            return Err(ALREADY);
        }
        let master = MacId::new(allocator).ok_or(INVALID_CHOICE)?;
        let for_another =
            self.options.contains(Options::ALLOCATE_FOR_ONESELF_ONLY) && master != requester.mac;
        if (changes::<A>() && connections.contains(BOTH)) || choice.contains(RESERVED) || for_another {
            return Err(INVALID_CHOICE);
        }
        if self.are_identifiers_taken(connections, suppressed) {
            return Err(Failure::new(GeneralStatus::RESOURCE_UNAVAILABLE)
                .with_additional(AdditionalCode::RESOURCE_UNAVAILABLE));
        }
        Ok(master)
    }

    /// Whether a connection opened through the UCMM uses a Group 2 Message ID that the choice needs.
    fn are_identifiers_taken(&self, connections: AllocationChoice, suppressed: bool) -> bool {
        let needed = message_ids_of(connections, suppressed);
        self.dynamic
            .iter()
            .filter(|dynamic| dynamic.is_open() && dynamic.group == Group::Two)
            .any(|dynamic| needed & (1 << (dynamic.request & 7) | 1 << (dynamic.response & 7)) != 0)
    }

    /// The Group 2 Message IDs that the predefined set uses, as bits.
    pub(super) fn predefined_message_ids(&self) -> u8 {
        message_ids_of(self.held, self.held.contains(AllocationChoice::ACK_SUPPRESSION))
    }

    fn create(&mut self, choice: AllocationChoice) {
        // The choice was checked: this tells the compiler so.
        let choice = choice.intersection(choices::<A>());
        let acknowledged = !choice.contains(AllocationChoice::ACK_SUPPRESSION);
        if choice.contains(AllocationChoice::EXPLICIT) {
            // Its state was checked.
            let _ = self.explicit_step(ExplicitCause::Opened);
        }
        let second_exists =
            matches!(self.io(IoKind::Poll).state(), IoState::Configuring | IoState::Established);
        if choice.contains(AllocationChoice::POLL) {
            if second_exists {
                self.io_mut(IoKind::Poll).promote(PredefinedConnection::Poll);
            } else {
                self.allocate_io(IoKind::Poll, PredefinedConnection::Poll);
            }
        } else if choice.intersects(BOTH) && !second_exists {
            self.held.remove(AllocationChoice::POLL);
            self.allocate_io(IoKind::Poll, towards_slave(acknowledged));
        }
        if choice.contains(AllocationChoice::BIT_STROBE) {
            self.allocate_io(IoKind::BitStrobe, PredefinedConnection::BitStrobe);
        }
        if choice.contains(AllocationChoice::CHANGE_OF_STATE) {
            self.allocate_io(IoKind::ChangeOfState, PredefinedConnection::ChangeOfState { acknowledged });
        }
        if choice.contains(AllocationChoice::CYCLIC) {
            self.allocate_io(IoKind::ChangeOfState, PredefinedConnection::Cyclic { acknowledged });
        }
        if choice.contains(AllocationChoice::MULTICAST_POLL) {
            self.allocate_io(IoKind::MulticastPoll, PredefinedConnection::MulticastPoll);
        }
        if choice.intersects(BOTH) {
            self.held.remove(BOTH | AllocationChoice::ACK_SUPPRESSION);
        }
        self.held.insert(choice);
    }

    fn delete(&mut self, choice: AllocationChoice) {
        let choice = choice.intersection(choices::<A>());
        let remaining = self.held.intersection(choices::<A>()).difference(choice);
        if choice.contains(AllocationChoice::EXPLICIT) {
            let _ = self.explicit_step(ExplicitCause::Released);
        }
        if choice.intersects(BOTH) {
            let _ = self.io_step(IoKind::ChangeOfState, IoCause::Released);
        }
        let second_needed = remaining.intersects(AllocationChoice::POLL | BOTH);
        if !second_needed {
            if choice.intersects(AllocationChoice::POLL | BOTH) {
                let _ = self.io_step(IoKind::Poll, IoCause::Released);
            }
        } else if choice.contains(AllocationChoice::POLL) {
            let acknowledged = !remaining.contains(AllocationChoice::ACK_SUPPRESSION);
            self.io_mut(IoKind::Poll).promote(towards_slave(acknowledged));
        }
        if choice.contains(AllocationChoice::BIT_STROBE) {
            let _ = self.io_step(IoKind::BitStrobe, IoCause::Released);
        }
        if choice.contains(AllocationChoice::MULTICAST_POLL) {
            let _ = self.io_step(IoKind::MulticastPoll, IoCause::Released);
        }
        self.held = remaining;
    }
}

/// Every bit that an accepted choice can have.
const fn choices<A: Application>() -> AllocationChoice {
    offered::<A>().union(AllocationChoice::ACK_SUPPRESSION)
}

/// Instance 2 where it is there for change of state or cyclic only.
const fn towards_slave(acknowledged: bool) -> PredefinedConnection {
    if acknowledged { PredefinedConnection::Poll } else { PredefinedConnection::ConsumeOnly }
}

/// Of the identifiers that carry the slave's MAC ID.
fn message_ids_of(connections: AllocationChoice, suppressed: bool) -> u8 {
    let mut ids = 0;
    if connections.contains(AllocationChoice::EXPLICIT) {
        ids |= 1 << 3 | 1 << 4;
    }
    if connections.intersects(AllocationChoice::POLL | BOTH) {
        ids |= 1 << 5;
    }
    if connections.intersects(BOTH) && !suppressed {
        ids |= 1 << 2;
    }
    ids
}

const RESERVED: AllocationChoice = AllocationChoice::from_bits_retain(0x80);
/// Bits that stand for no connection.
const NO_CONNECTION: AllocationChoice = RESERVED.union(AllocationChoice::ACK_SUPPRESSION);
const CONFLICT: Failure =
    Failure::new(GeneralStatus::OBJECT_STATE_CONFLICT).with_additional(AdditionalCode::ALLOCATION_CONFLICT);
const INVALID_CHOICE: Failure =
    Failure::new(GeneralStatus::INVALID_ATTRIBUTE_VALUE).with_additional(AdditionalCode::INVALID_CHOICE);
const NOT_OFFERED: Failure =
    Failure::new(GeneralStatus::RESOURCE_UNAVAILABLE).with_additional(AdditionalCode::INVALID_CHOICE);
const ALREADY: Failure =
    Failure::new(GeneralStatus::ALREADY_IN_REQUESTED_STATE).with_additional(AdditionalCode::INVALID_CHOICE);
