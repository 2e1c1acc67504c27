//! What a node is told at the start.

use crate::cycle::PollWithoutSoc;
use crate::dictionary::{Device, ObjectAddress, Values};
use crate::pdo::MappingEntry;
use crate::wire::{InitiateSize, MIN_ENTRIES};
use crate::{MacAddress, NodeId};

/// What a node is told at the start. Its node, MAC address and device have no defaults.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Config {
    pub(super) node: NodeId,
    /// The address of its adapter.
    pub mac: MacAddress,
    /// What it is.
    pub device: Device,
    /// Power-on values of what can be written.
    pub values: Values,
    /// What is mapped at power-on.
    pub mapping: DefaultMapping,
    /// Where the protocol leaves a choice.
    pub options: Options,
}

/// What a node maps until the managing node says otherwise.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub struct DefaultMapping {
    /// 0x1600: objects in PReq.
    pub receive: &'static [MappingEntry],
    /// 0x1A00: objects in PRes.
    pub transmit: &'static [MappingEntry],
}

/// Where the public material leaves a choice, or nodes differ.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Options {
    /// Who says that the application is ready to operate.
    pub readiness: Readiness,
    /// PReq and PRes in `NotActive` start the time of 0x1F99 anew; else it runs through. Default: yes.
    pub poll_restarts_basic_ethernet: bool,
    /// PReq and PRes lead out of `NotActive` as SoA does (CT2). Default: no.
    pub poll_ends_not_active: bool,
    /// PRes leads out of `BasicEthernet` (CT12). Default: yes.
    pub pres_ends_basic_ethernet: bool,
    /// Where the cycle goes on a PReq or PRes before SoC. Default: it stays.
    pub poll_without_soc: PollWithoutSoc,
    /// Too many lost SoAs are a cycle error. Default: yes.
    pub reacts_to_loss_of_soa: bool,
    /// Too much jitter of SoC is a cycle error. Default: no, it is counted.
    pub reacts_to_jitter: bool,
    /// Too many collisions are a cycle error. Default: no, they are counted.
    pub reacts_to_collisions: bool,
    /// The answer to the StatusRequest that changes ER has the new EC already. Default: yes.
    pub clears_before_answer: bool,
    /// Errors in a StatusResponse, 2 to 13. Default: 2, a frame of 72 bytes.
    pub status_entries: usize,
    /// Whether SegmentSize of the first SDO segment counts the size of all data. Default: it does.
    pub initiate_size: InitiateSize,
    /// Which version of a mapping process data must have. Default: the main version.
    pub version_check: VersionCheck,
    /// NMTStartNode is followed only after a PReq with valid data. Default: no.
    pub start_needs_valid_data: bool,
}

/// Who says that the application is ready to operate.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Readiness {
    /// It always is.
    #[default]
    Automatic,
    /// It says so each time in `PreOperational2`: [`ControlledNode::ready`](super::ControlledNode::ready).
    ByApplication,
}

/// Which version of a mapping process data must have.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum VersionCheck {
    /// The same main version.
    #[default]
    Main,
    /// The same version.
    Exact,
    /// Any.
    None,
}

/// A node cannot be made so.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ConfigError {
    /// The node ID is not one of a controlled node.
    #[error("{0} is not a controlled node: use 1 to 239, 253 or 254")]
    Node(NodeId),
    /// The default mapping cannot be used.
    #[error("the default mapping cannot be used: {0}")]
    Mapping(crate::wire::AbortCode),
    /// A power-on value is not one that its object may have.
    #[error("the value of {0} is not in its range")]
    Value(ObjectAddress),
    /// The process data of the PRes do not fit.
    #[error("PRes of {limit} bytes of process data: the node has room for {room}, and needs at least 36")]
    PresLimit {
        /// What the values say.
        limit: u16,
        /// What the node has.
        room: usize,
    },
}

impl Config {
    /// A node with the values and choices of the specification, which maps nothing.
    ///
    /// # Errors
    /// [`ConfigError::Node`] if the node ID is not one of a controlled node.
    pub fn new(node: NodeId, mac: MacAddress, device: Device) -> Result<Self, ConfigError> {
        if !node.is_controlled_node() {
            return Err(ConfigError::Node(node));
        }
        let (values, mapping, options) = (Values::default(), DefaultMapping::default(), Options::default());
        Ok(Self { node, mac, device, values, mapping, options })
    }

    /// Its node ID.
    #[must_use]
    pub const fn node(&self) -> NodeId {
        self.node
    }
}

impl Default for Options {
    fn default() -> Self {
        Self {
            readiness: Readiness::Automatic,
            poll_restarts_basic_ethernet: true,
            poll_ends_not_active: false,
            pres_ends_basic_ethernet: true,
            poll_without_soc: PollWithoutSoc::Stay,
            reacts_to_loss_of_soa: true,
            reacts_to_jitter: false,
            reacts_to_collisions: false,
            clears_before_answer: true,
            status_entries: MIN_ENTRIES,
            initiate_size: InitiateSize::Counted,
            version_check: VersionCheck::Main,
            start_needs_valid_data: false,
        }
    }
}
