//! The identifiers that a connection uses.

use cip_core::code::InstanceId;

use crate::id::{Framing, Group, Identifier, MessageId, OperationalAddress, Route};
use crate::message::GroupSelect;

/// Where a node produces: the group of a connection request or response, and a Message ID that the group has.
///
/// With the address of the node and, for 29 bits, the instance of its connection that is an identifier:
///
/// ```
/// use cip_core::code::InstanceId;
/// use devicenex_core::connection::{GroupMessage, requester_instance};
/// use devicenex_core::id::{MessageId, OperationalAddress};
/// use devicenex_core::message::GroupSelect;
///
/// let (manager, device) = (OperationalAddress::new(1).unwrap(), OperationalAddress::new(67).unwrap());
/// let at = GroupMessage::new(GroupSelect::IMPLICIT_29, MessageId::new(2).unwrap())?;
/// // The device answers polls on its connection 3; the manager polls it, and nobody else.
/// assert_eq!(at.produced(device, InstanceId(3)).to_string(), "02860003");
/// assert_eq!(at.produced(manager, requester_instance(device, InstanceId(3))).to_string(), "0202C303");
/// # Ok::<(), devicenex_core::connection::InvalidGroup>(())
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GroupMessage {
    select: GroupSelect,
    message: MessageId,
}

/// A reserved group, or a Message ID that the group does not have.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, thiserror::Error)]
#[error("{select} has no Message ID {message}")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct InvalidGroup {
    /// The group.
    pub select: GroupSelect,
    /// The Message ID.
    pub message: MessageId,
}

impl GroupMessage {
    /// Joins them.
    ///
    /// # Errors
    /// If the group is reserved, or does not have the Message ID: Group 1 has 0 to 7, Group 2 0 to 3, Group 3 0 to 2, implicit
    /// messages with 29 bits 0 to 15, explicit ones 0 to 7.
    pub fn new(select: GroupSelect, message: MessageId) -> Result<Self, InvalidGroup> {
        let last = match select {
            GroupSelect::IMPLICIT_29 => Some(15),
            GroupSelect::EXPLICIT_29 => Some(7),
            select => select.standard().map(Group::last_message),
        };
        let exists = last.is_some_and(|last| message.number() <= last);
        if exists { Ok(Self { select, message }) } else { Err(InvalidGroup { select, message }) }
    }

    /// The group.
    #[must_use]
    pub const fn select(self) -> GroupSelect {
        self.select
    }

    /// The Message ID.
    #[must_use]
    pub const fn message(self) -> MessageId {
        self.message
    }

    /// The Message IDs of the group, beginning with this one.
    pub fn alternatives(self) -> impl Iterator<Item = Self> {
        let others = (0..=0xF).filter_map(MessageId::new);
        let others = others.filter_map(move |message| Self::new(self.select, message).ok());
        core::iter::once(self).chain(others.filter(move |other| *other != self))
    }

    /// The identifier of an implicit message; the instance has no place in one of 11 bits.
    #[must_use]
    pub fn produced(self, source: OperationalAddress, instance: InstanceId) -> Identifier {
        self.standard(source).unwrap_or_else(|| Identifier::implicit(self.message, source, instance))
    }

    /// The identifier of the acknowledge of an implicit message.
    #[must_use]
    pub fn acknowledge(self, source: OperationalAddress, instance: InstanceId) -> Identifier {
        self.standard(source)
            .unwrap_or_else(|| Identifier::implicit_acknowledge(self.message, source, instance))
    }

    fn standard(self, source: OperationalAddress) -> Option<Identifier> {
        Identifier::standard(self.select.standard()?, self.message, source)
    }
}

impl GroupSelect {
    /// The group of 11-bit identifiers that it stands for.
    #[must_use]
    pub const fn standard(self) -> Option<Group> {
        match self {
            Self::GROUP_1 => Some(Group::Group1),
            Self::GROUP_2 => Some(Group::Group2),
            Self::GROUP_3 => Some(Group::Group3),
            _ => None,
        }
    }
}

impl From<Group> for GroupSelect {
    fn from(group: Group) -> Self {
        match group {
            Group::Group1 => Self::GROUP_1,
            Group::Group2 => Self::GROUP_2,
            Group::Group3 => Self::GROUP_3,
        }
    }
}

/// What stands in the place of the instance, in the identifier of an implicit message from a requester to its target
/// **\[D\]**.
///
/// | Bits | Content |
/// |---|---|
/// | 15 | 1, so that it is no instance of the requester |
/// | 14-8 | address of the target |
/// | 7-0 | the target's instance |
#[must_use]
pub const fn requester_instance(target: OperationalAddress, instance: InstanceId) -> InstanceId {
    let [instance, _] = instance.0.to_le_bytes();
    InstanceId(u16::from_le_bytes([instance, target.number() | 0x80]))
}

/// The identifier of an explicit message on a connection, as a connection ID has it: F and X are 0.
pub(crate) fn explicit(message: MessageId, route: Route) -> Option<Identifier> {
    Identifier::explicit(message, route, Framing::Complete { transaction: 0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(number: u8) -> MessageId {
        MessageId::new(number).unwrap()
    }

    /// How many Message IDs each group has: the table of 11-bit identifiers, and classes 0mmmm and 10mmm.
    #[test]
    fn groups_have_as_many_messages_as_their_layout() {
        let count = |number| {
            let select = GroupSelect::new(number).unwrap();
            let valid = (0..16).filter(|&id| GroupMessage::new(select, message(id)).is_ok());
            valid.count()
        };
        assert_eq!([0, 1, 2, 3, 4, 5, 6, 7].map(count), [8, 4, 0, 3, 16, 8, 0, 0]);
    }

    #[test]
    fn the_alternatives_of_a_message_are_the_others_of_its_group() {
        let at = GroupMessage::new(GroupSelect::GROUP_3, message(1)).unwrap();
        let numbers: std::vec::Vec<_> = at.alternatives().map(|at| at.message().number()).collect();
        assert_eq!(numbers, [1, 0, 2]);
    }

    /// By hand: 29 bits `00010 0000001 1 1 1000011 00001001`, 11 bits Group 1 `0 010 0000001`.
    #[test]
    fn acknowledges_of_a_requester() {
        let (manager, device) = (OperationalAddress::new(1).unwrap(), OperationalAddress::new(67).unwrap());
        let instance = requester_instance(device, InstanceId(9));
        let extended = GroupMessage::new(GroupSelect::IMPLICIT_29, message(2)).unwrap();
        assert_eq!(
            u32::from(crate::connection::ConnectionId::from(extended.acknowledge(manager, instance))),
            0x8203_C309
        );
        let standard = GroupMessage::new(GroupSelect::GROUP_1, message(2)).unwrap();
        assert_eq!(
            u32::from(crate::connection::ConnectionId::from(standard.acknowledge(manager, instance))),
            0x101
        );
    }
}
