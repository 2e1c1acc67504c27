//! NMTCommand and NMTRequest.

use core::fmt;

use link_core::codec::{Full, ParseError, Reader, Tail, Wire, Writer};

use super::{ErrorCode, NmtCommandId};
use crate::NodeId;

/// NMTCommand, an ASnd of the managing node to one node or to all.
///
/// | Offset | Content |
/// |---|---|
/// | 18 | command |
/// | 19 | reserved |
/// | 20.. | up to 32 bytes of command data; nothing tells them from padding |
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct NmtCommand<'a> {
    /// The command.
    pub command: NmtCommandId,
    /// Its data, and padding.
    pub data: &'a [u8],
}

/// NMTRequest, an ASnd to the managing node: a node asks for an NMT command.
///
/// | Offset | Content |
/// |---|---|
/// | 18 | requested command |
/// | 19 | the node for which it is |
/// | 20.. | up to 32 bytes of command data; nothing tells them from padding |
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct NmtRequest<'a> {
    /// The command that is asked for.
    pub command: NmtCommandId,
    /// For whom.
    pub target: NodeId,
    /// Its data, and padding.
    pub data: &'a [u8],
}

/// The nodes that an extended command is for: node n is bit n mod 8 of byte n div 8.
///
/// ```
/// use powerlink_core::{NodeId, wire::NodeList};
///
/// let list = NodeList::of(&[0x00, 0x04]);
/// assert!(list.contains(NodeId(10)) && !list.contains(NodeId(2)));
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
pub struct NodeList(pub [u8; 32]);

impl NodeList {
    /// The list in command data; bytes that are missing name nobody.
    #[must_use]
    pub fn of(data: &[u8]) -> Self {
        let mut list = [0; 32];
        list.iter_mut().zip(data).for_each(|(byte, &given)| *byte = given);
        Self(list)
    }

    /// Whether a node is named.
    #[must_use]
    pub fn contains(&self, node: NodeId) -> bool {
        self.0.get(usize::from(node.0 >> 3)).is_some_and(|byte| byte & bit(node) != 0)
    }

    /// Names a node.
    pub fn insert(&mut self, node: NodeId) {
        if let Some(byte) = self.0.get_mut(usize::from(node.0 >> 3)) {
            *byte |= bit(node);
        }
    }
}

impl NmtCommand<'_> {
    /// Whether `node` is meant: every plain command, and extended ones whose list names it.
    #[must_use]
    pub fn is_for(&self, node: NodeId) -> bool {
        !self.command.is_extended() || NodeList::of(self.data).contains(node)
    }

    /// Why the managing node resets the node, where it tells: the first two data bytes of a plain reset.
    #[must_use]
    pub fn reason(&self) -> Option<ErrorCode> {
        let [low, high, ..] = self.data else { return None };
        let code = ErrorCode(u16::from_le_bytes([*low, *high]));
        (self.command.is_reset() && code != ErrorCode::NONE).then_some(code)
    }
}

impl<'a> Wire<'a> for NmtCommand<'a> {
    const NAME: &'static str = "NMTCommand";
    const TAIL: Tail = Tail::Open;

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        let [command, _] = reader.array("NMT command")?;
        Ok(Self { command: NmtCommandId(command), data: data(reader)? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.bytes(&[self.command.0, 0])?;
        out.bytes(self.data)
    }

    fn wire_len(&self) -> usize {
        self.data.len().saturating_add(2)
    }
}

impl<'a> Wire<'a> for NmtRequest<'a> {
    const NAME: &'static str = "NMTRequest";
    const TAIL: Tail = Tail::Open;

    fn read(reader: &mut Reader<'a>) -> Result<Self, ParseError> {
        let [command, target] = reader.array("NMT request")?;
        Ok(Self { command: NmtCommandId(command), target: NodeId(target), data: data(reader)? })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.bytes(&[self.command.0, self.target.0])?;
        out.bytes(self.data)
    }

    fn wire_len(&self) -> usize {
        self.data.len().saturating_add(2)
    }
}

/// `NMTResetNode, reason: loss of PRes threshold`
impl fmt::Display for NmtCommand<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.command)?;
        self.reason().map_or(Ok(()), |reason| write!(f, ", reason: {reason}"))
    }
}

/// `NMTRequest, NMTResetNode for node 1`
impl fmt::Display for NmtRequest<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "NMTRequest, {} for {}", self.command, self.target)
    }
}

fn data<'a>(reader: &mut Reader<'a>) -> Result<&'a [u8], ParseError> {
    reader.bytes(reader.remaining().min(MAX_COMMAND_DATA), "command data")
}

const fn bit(node: NodeId) -> u8 {
    1 << (node.0 & 0x07)
}

/// The most command data.
pub const MAX_COMMAND_DATA: usize = 32;
