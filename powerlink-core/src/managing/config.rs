//! What the managing node is told at the start.

use core::time::Duration;

use super::error::{ConfigError, Direction};
use super::timing::{poll_time, slot_time, wire_time};
use crate::dictionary::ObjectAddress;
use crate::ethernet::MAX_PROCESS_DATA;
use crate::pdo::MappingEntry;
use crate::wire::{ConfigurationStamp, InitiateSize, PdoVersion};
use crate::{MacAddress, NodeId};

/// What the managing node is told at the start. Its address has no default; the times are those of EPSG DS 301.
///
/// A time-out is counted from the end of the question on the wire to the begin of the answer. Where a node is a program on a
/// computer, 25 µs are too short: give it milliseconds.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// The address of its adapter.
    pub mac: MacAddress,
    /// 0x1006: from one SoC to the next, in whole microseconds. Default: 20 ms.
    pub cycle: Duration,
    /// 0x1F89/1: how long it listens for another managing node. Default: 1 s.
    pub wait_not_active: Duration,
    /// How long nodes may take to reset before they are asked for an IdentResponse. Default: 100 ms.
    pub wait_after_reset: Duration,
    /// 0x1F89/3: how long the reduced cycle lasts at least. Default: 500 ms.
    pub wait_pre_operational_1: Duration,
    /// 0x1F89/5: how long a node may take to follow a command. Default: 500 ms.
    pub command_timeout: Duration,
    /// When a command that a node does not follow is sent again. Default: 100 ms, five cycles.
    pub command_repeat: Duration,
    /// 0x1F8A/1: from SoC to the first PReq. Default: 1 µs.
    pub wait_soc_preq: Duration,
    /// 0x1F8A/2: until an invited node begins to answer. Default: 100 µs.
    pub async_slot: Duration,
    /// 0x1F98/8: the longest payload of an asynchronous frame. Default: 300.
    pub async_mtu: u16,
    /// 0x1F98/7: so many cycles are a multiplexed cycle. Default: 0, none.
    pub multiplexed_cycles: u8,
    /// 0x1F98/9: PS toggles in every so many cycles. Default: 2.
    pub prescaler: u16,
    /// How often nodes that are not polled are asked for their status; those that are polled, too. Default: 5 s.
    pub status_period: Duration,
    /// StatusRequests without an answer after which a node is lost. Default: 5.
    pub status_threshold: u8,
    /// PRes with a wrong state after which a node is lost. Default: 5, the cycles that a node may take to follow a command.
    pub state_threshold: u8,
    /// Cycles in `ReadyToOperate` before nodes are started. Default: 5.
    pub check_cycles: u16,
    /// When a refused node is tried again. Default: 5 s.
    pub retry_after: Duration,
    /// When an SDO frame that is not answered is sent again, two times. Default: 1 s.
    pub sdo_timeout: Duration,
    /// Whether SegmentSize of the first SDO segment counts the size of all data. Default: it does.
    pub initiate_size: InitiateSize,
    /// NMT commands that nodes ask for are carried out. Default: yes.
    pub follows_requests: bool,
    /// Node 253 is asked for an IdentResponse as well. Default: no.
    pub asks_diagnostic_device: bool,
}

/// What one node has to be, and gets. All but the node ID has a default.
///
/// ```
/// use powerlink_core::NodeId;
/// use powerlink_core::dictionary::ObjectAddress;
/// use powerlink_core::managing::{NodePlan, ObjectWrite};
/// use powerlink_core::pdo::MappingEntry;
///
/// let byte = |index| MappingEntry { object: ObjectAddress::new(index, 1), offset: 0, length: 8 };
/// let (outputs, inputs) = ([byte(0x6200)], [byte(0x6000)]);
/// let writes = [ObjectWrite::new(ObjectAddress::new(0x1C0B, 3), &[80, 0, 0, 0])];
/// let plan = NodePlan { outputs: &outputs, inputs: &inputs, writes: &writes, ..NodePlan::new(NodeId(1)) };
/// assert_eq!(plan.output_len(), 1);
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct NodePlan<'p> {
    /// Which node.
    pub node: NodeId,
    /// The network does not start without it. Default: yes.
    pub is_mandatory: bool,
    /// It is never polled, and its supervision of PReq (0x1C0D/3) is switched off. Default: no.
    pub is_async_only: bool,
    /// It is polled in this cycle of a multiplexed cycle only, counted from 0. Default: in every cycle.
    pub multiplexed_slot: Option<u8>,
    /// 0x1F84: the device type that it must have.
    pub device_type: Option<u32>,
    /// 0x1F85
    pub vendor_id: Option<u32>,
    /// 0x1F86
    pub product_code: Option<u32>,
    /// 0x1F87
    pub revision: Option<u32>,
    /// 0x1F88
    pub serial_number: Option<u32>,
    /// 0x1F26, 0x1F27: the configuration. A node that has it already is not written again; else it is written to 0x1020 when
    /// everything else is. Default: none, the node is always written.
    pub configuration: Option<ConfigurationStamp>,
    /// 0x1F92: until the node begins its PRes. Default: 25 µs.
    pub pres_timeout: Duration,
    /// 0x1C09/3: a lost PRes counts 8, a good one takes 1 away. Default: 15, the second within eight.
    pub loss_of_pres_threshold: u32,
    /// 0x1F98/4: the most process data of its PReq. Default: 36.
    pub preq_limit: u16,
    /// 0x1F98/5: the process data of its PRes. Default: 36.
    pub pres_limit: u16,
    /// The objects in its PReq, written to 0x1600. Default: none, 0x1600 is left as it is.
    pub outputs: &'p [MappingEntry],
    /// The objects in its PRes, written to 0x1A00. Default: none, 0x1A00 is left as it is.
    pub inputs: &'p [MappingEntry],
    /// The version of the mapping in its PReq.
    pub pdo_version: PdoVersion,
    /// Objects that are written before the mapping, in this order.
    pub writes: &'p [ObjectWrite<'p>],
}

/// An object that is written to a node.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct ObjectWrite<'p> {
    /// Which.
    pub at: ObjectAddress,
    /// The value, as it stands in the frame.
    pub data: &'p [u8],
    /// The node may refuse it.
    pub may_fail: bool,
}

impl Config {
    /// A managing node with the times of the specification.
    #[must_use]
    pub const fn new(mac: MacAddress) -> Self {
        Self {
            mac,
            cycle: Duration::from_millis(20),
            wait_not_active: Duration::from_secs(1),
            wait_after_reset: Duration::from_millis(100),
            wait_pre_operational_1: Duration::from_millis(500),
            command_timeout: Duration::from_millis(500),
            command_repeat: Duration::from_millis(100),
            wait_soc_preq: Duration::from_micros(1),
            async_slot: Duration::from_micros(100),
            async_mtu: 300,
            multiplexed_cycles: 0,
            prescaler: 2,
            status_period: Duration::from_secs(5),
            status_threshold: 5,
            state_threshold: 5,
            check_cycles: 5,
            retry_after: Duration::from_secs(5),
            sdo_timeout: Duration::from_secs(1),
            initiate_size: InitiateSize::Counted,
            follows_requests: true,
            asks_diagnostic_device: false,
        }
    }

    /// The longest that a cycle with these nodes can take.
    #[must_use]
    pub fn needed(&self, plans: &[NodePlan<'_>]) -> Duration {
        let polls = |cycle: u8| {
            plans
                .iter()
                .filter(|plan| !plan.is_async_only && plan.multiplexed_slot.is_none_or(|slot| slot == cycle))
                .map(poll_time)
                .fold(Duration::ZERO, Duration::saturating_add)
        };
        let polls = (0..self.multiplexed_cycles.max(1)).map(polls).max().unwrap_or_default();
        let begin = wire_time(0).saturating_add(self.wait_soc_preq);
        begin.saturating_add(polls).saturating_add(slot_time(self))
    }

    /// The cycle length as 0x1006 has it.
    pub(super) fn cycle_micros(&self) -> Option<u32> {
        let micros = u32::try_from(self.cycle.as_micros()).ok()?;
        (Duration::from_micros(micros.into()) == self.cycle).then_some(micros)
    }

    pub(super) fn check(&self, plans: &[NodePlan<'_>], data: usize, sdo: usize) -> Result<(), ConfigError> {
        if self.cycle_micros().is_none() {
            return Err(ConfigError::CycleLength { cycle: self.cycle });
        }
        for (place, plan) in plans.iter().enumerate() {
            plan.check(self, data, sdo)?;
            if plans.iter().skip(place.saturating_add(1)).any(|other| other.node == plan.node) {
                return Err(ConfigError::Twice(plan.node));
            }
        }
        let needed = self.needed(plans);
        if needed > self.cycle {
            return Err(ConfigError::Cycle { cycle: self.cycle, needed });
        }
        Ok(())
    }
}

impl<'p> NodePlan<'p> {
    /// A mandatory node that may be any device, and gets the cycle length only.
    #[must_use]
    pub const fn new(node: NodeId) -> Self {
        Self {
            node,
            is_mandatory: true,
            is_async_only: false,
            multiplexed_slot: None,
            device_type: None,
            vendor_id: None,
            product_code: None,
            revision: None,
            serial_number: None,
            configuration: None,
            pres_timeout: Duration::from_micros(25),
            loss_of_pres_threshold: 15,
            preq_limit: 36,
            pres_limit: 36,
            outputs: &[],
            inputs: &[],
            pdo_version: PdoVersion(0),
            writes: &[],
        }
    }

    /// The bytes of process data that the mapping of its PReq needs.
    #[must_use]
    pub fn output_len(&self) -> usize {
        self.outputs.iter().map(end).max().unwrap_or(0)
    }

    fn check(&self, config: &Config, data: usize, sdo: usize) -> Result<(), ConfigError> {
        let node = self.node;
        if !matches!(node.0, 1..=239) {
            return Err(ConfigError::Node(node));
        }
        let room = data.min(MAX_PROCESS_DATA);
        let directions = [
            (Direction::Outputs, self.preq_limit, self.outputs),
            (Direction::Inputs, self.pres_limit, self.inputs),
        ];
        for (direction, limit, mapping) in directions {
            if usize::from(limit) > room || limit < MIN_LIMIT {
                return Err(ConfigError::DataLimit { node, direction, limit, room });
            }
            let (mapped, most) = (mapping.len(), usize::from(MOST_MAPPED));
            if mapped > most {
                return Err(ConfigError::TooManyMapped { node, direction, mapped, room: most });
            }
            let mut ends = mapping.iter().map(|mapped| (mapped.object, end(mapped))).enumerate();
            if let Some((entry, (at, len))) = ends.find(|(_, (_, end))| *end > usize::from(limit)) {
                return Err(ConfigError::Mapping { node, direction, entry, at, len, limit });
            }
        }
        let room = sdo.saturating_sub(ADDRESS);
        let mut writes = self.writes.iter().map(|write| (write.at, write.data.len())).enumerate();
        if let Some((write, (at, len))) = writes.find(|(_, (_, len))| *len > room) {
            return Err(ConfigError::Value { node, write, at, len, room });
        }
        match self.multiplexed_slot {
            Some(slot) if slot >= config.multiplexed_cycles => {
                Err(ConfigError::MultiplexedSlot { node, slot, cycles: config.multiplexed_cycles })
            }
            Some(_) | None => Ok(()),
        }
    }
}

impl<'p> ObjectWrite<'p> {
    /// A value that the node has to take.
    #[must_use]
    pub const fn new(at: ObjectAddress, data: &'p [u8]) -> Self {
        Self { at, data, may_fail: false }
    }
}

/// Where an object ends in process data, in bytes.
fn end(entry: &MappingEntry) -> usize {
    usize::from(entry.offset).saturating_add(usize::from(entry.length)).div_ceil(8)
}

/// The least that 0x1F98/4 and /5 can be.
const MIN_LIMIT: u16 = 36;
/// The sub-indices of a mapping object, of 0x01 to 0xFE.
pub(super) const MOST_MAPPED: u8 = 254;
/// Index, sub-index and a reserved byte, before a value.
pub(super) const ADDRESS: usize = 4;
