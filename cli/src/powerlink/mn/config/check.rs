//! What a network file means, and what in it cannot be.

use core::ops::Range;
use core::time::Duration;
use std::collections::BTreeSet;

use link_core::text::ByteCount;
use powerlink_core::dictionary::ObjectAddress;
use powerlink_core::managing::{Config, NodePlan};
use powerlink_core::pdo::MappingEntry;
use powerlink_core::wire::{ConfigurationStamp, PdoVersion};
use powerlink_core::{MacAddress, NodeId};
use toml::Spanned;

use super::places::NodePlaces;
use super::{Network, Node, Places, Write};
use crate::powerlink::mn::raw::{RawMapped, RawNetwork, RawNode, RawWrite};
use crate::scenario::{ScenarioError, Time, toml_error};
use crate::text::{hex_bytes, unsigned};

/// The network in a text.
pub(super) fn parse(file: &str, text: &str) -> Result<Network, ScenarioError> {
    let raw: RawNetwork = toml::from_str(text).map_err(|error| toml_error(file, text, &error))?;
    let check = Check { file, text };
    if raw.node.is_empty() {
        return Err(ScenarioError::of_file(file, "there is no [[node]]; expected at least one"));
    }
    check.numbers(&raw.node)?;
    let config = check.config(&raw)?;
    let times = NodeTimes {
        pres_timeout: raw.pres_timeout.as_ref().map_or(PRES_TIMEOUT, time),
        soc_tolerance: check.nanos(raw.loss_of_soc_tolerance.as_ref(), LOSS_OF_SOC_TOLERANCE)?,
    };
    let nodes: Vec<_> = raw.node.iter().map(|node| check.node(node, times)).collect::<Result<_, _>>()?;
    let (nodes, places) = nodes.into_iter().unzip();
    let cycle = raw.cycle.as_ref().map(Spanned::span);
    let places = Places { file: file.to_owned(), text: text.to_owned(), cycle, nodes: places };
    Ok(Network { config, nodes, places })
}

/// What the file says for every node, unless the node has its own.
#[derive(Clone, Copy)]
struct NodeTimes {
    pres_timeout: Duration,
    /// ns
    soc_tolerance: u32,
}

struct Check<'a> {
    file: &'a str,
    text: &'a str,
}

impl Check<'_> {
    fn fail<T>(&self, span: &Range<usize>, message: impl Into<String>) -> Result<T, ScenarioError> {
        Err(ScenarioError::at(self.file, self.text, span, message))
    }

    fn config(&self, raw: &RawNetwork) -> Result<Config, ScenarioError> {
        let mut config = Config::new(MacAddress::default());
        config.async_slot = ASYNC_SLOT;
        let times = [
            (&mut config.cycle, &raw.cycle),
            (&mut config.wait_not_active, &raw.wait_not_active),
            (&mut config.wait_after_reset, &raw.wait_after_reset),
            (&mut config.wait_pre_operational_1, &raw.wait_pre_operational_1),
            (&mut config.command_timeout, &raw.command_timeout),
            (&mut config.command_repeat, &raw.command_repeat),
            (&mut config.wait_soc_preq, &raw.wait_soc_preq),
            (&mut config.async_slot, &raw.async_slot),
            (&mut config.status_period, &raw.status_period),
            (&mut config.retry_after, &raw.retry_after),
            (&mut config.sdo_timeout, &raw.sdo_timeout),
        ];
        for (place, value) in times {
            value.as_ref().map(time).into_iter().for_each(|value| *place = value);
        }
        self.number(&mut config.async_mtu, raw.async_mtu.as_ref(), 300, 1500)?;
        self.number(&mut config.multiplexed_cycles, raw.multiplexed_cycles.as_ref(), 0, 255)?;
        self.number(&mut config.prescaler, raw.prescaler.as_ref(), 0, 1000)?;
        self.number(&mut config.status_threshold, raw.status_threshold.as_ref(), 1, 255)?;
        self.number(&mut config.state_threshold, raw.state_threshold.as_ref(), 1, 255)?;
        self.number(&mut config.check_cycles, raw.check_cycles.as_ref(), 0, 65_535)?;
        // However long a cycle is, a node needs some of them to follow, and to answer.
        let some_cycles =
            config.cycle.saturating_mul(SOME_CYCLES * u32::from(config.multiplexed_cycles.max(1)));
        if raw.command_timeout.is_none() {
            config.command_timeout = config.command_timeout.max(some_cycles);
        }
        if raw.sdo_timeout.is_none() {
            config.sdo_timeout = config.sdo_timeout.max(some_cycles);
        }
        config.follows_requests = raw.follows_requests.unwrap_or(config.follows_requests);
        config.asks_diagnostic_device = raw.asks_diagnostic_device.unwrap_or(config.asks_diagnostic_device);
        Ok(config)
    }

    /// Every node has a number of its own.
    fn numbers(&self, nodes: &[Spanned<RawNode>]) -> Result<(), ScenarioError> {
        let mut known = BTreeSet::new();
        let mut ids = nodes.iter().filter_map(|node| node.get_ref().node.as_ref());
        match ids.find(|id| !known.insert(*id.get_ref())) {
            Some(id) => self.fail(&id.span(), format!("node {} is there twice", id.get_ref())),
            None => Ok(()),
        }
    }

    fn node(&self, table: &Spanned<RawNode>, times: NodeTimes) -> Result<(Node, NodePlaces), ScenarioError> {
        let (raw, span) = (table.get_ref(), table.span());
        let Some(id) = &raw.node else {
            return self.fail(&span, "`node`, the number of the node, is missing");
        };
        let mut number = 0_u8;
        self.number(&mut number, Some(id), 1, 239)?;
        let mut plan = NodePlan::new(NodeId(number));
        plan.is_mandatory = raw.mandatory.unwrap_or(plan.is_mandatory);
        plan.is_async_only = raw.async_only.unwrap_or(plan.is_async_only);
        plan.multiplexed_slot = self.optional(raw.multiplexed_slot.as_ref())?;
        if let Some(identity) = &raw.identity {
            plan.device_type = self.optional(identity.device_type.as_ref())?;
            plan.vendor_id = self.optional(identity.vendor.as_ref())?;
            plan.product_code = self.optional(identity.product.as_ref())?;
            plan.revision = self.optional(identity.revision.as_ref())?;
            plan.serial_number = self.optional(identity.serial.as_ref())?;
        }
        if let Some(stamp) = &raw.configuration {
            let (mut date, mut time) = (0, 0);
            self.number(&mut date, stamp.date.as_ref(), 0, u32::MAX.into())?;
            self.number(&mut time, stamp.time.as_ref(), 0, u32::MAX.into())?;
            plan.configuration = Some(ConfigurationStamp { date, time });
        }
        plan.pres_timeout = raw.pres_timeout.as_ref().map_or(times.pres_timeout, time);
        let threshold = raw.loss_of_pres_threshold.as_ref();
        self.number(&mut plan.loss_of_pres_threshold, threshold, 0, u32::MAX.into())?;
        self.number(&mut plan.preq_limit, raw.preq_limit.as_ref(), 36, LIMIT)?;
        self.number(&mut plan.pres_limit, raw.pres_limit.as_ref(), 36, LIMIT)?;
        let mut version = 0_u8;
        self.number(&mut version, raw.pdo_version.as_ref(), 0, 255)?;
        plan.pdo_version = PdoVersion(version);
        let map_outputs = self.mapping(&raw.map_outputs, ("preq_limit", plan.preq_limit))?;
        let map_inputs = self.mapping(&raw.map_inputs, ("pres_limit", plan.pres_limit))?;
        let polled = raw.map_outputs.iter().chain(&raw.map_inputs).map(Spanned::span).next();
        if let Some(span) = polled.filter(|_| plan.is_async_only) {
            return self.fail(&span, "a node with `async_only` is not polled, and has no process data");
        }
        let outputs = self.bytes(raw.outputs.as_ref())?;
        let mapped = NodePlan { outputs: &map_outputs, ..plan }.output_len();
        if let Some(given) =
            raw.outputs.as_ref().filter(|_| !map_outputs.is_empty() && outputs.len() != mapped)
        {
            let given_len = ByteCount(outputs.len());
            return self.fail(
                &given.span(),
                format!("{given_len}; `map_outputs` of this node has {}", ByteCount(mapped)),
            );
        }
        if let Some(given) = raw.outputs.as_ref().filter(|_| outputs.len() > plan.preq_limit.into()) {
            let limit = plan.preq_limit;
            return self.fail(
                &given.span(),
                format!("{} bytes; `preq_limit` of this node is {limit}", outputs.len()),
            );
        }
        let tolerance = self.nanos(raw.loss_of_soc_tolerance.as_ref(), times.soc_tolerance)?;
        // First, so that what the file writes itself is the last word. A node that refuses keeps its own.
        let tolerance = (tolerance > 0).then(|| Write {
            at: SOC_TOLERANCE,
            data: tolerance.to_le_bytes().to_vec(),
            may_fail: true,
        });
        let writes = raw.write.iter().map(|write| self.write(write));
        let places = NodePlaces {
            node: plan.node,
            multiplexed_slot: raw.multiplexed_slot.as_ref().map(Spanned::span),
            map_outputs: raw.map_outputs.iter().map(Spanned::span).collect(),
            map_inputs: raw.map_inputs.iter().map(Spanned::span).collect(),
            writes: tolerance
                .iter()
                .map(|_| span.clone())
                .chain(raw.write.iter().map(Spanned::span))
                .collect(),
            table: span,
        };
        let writes = tolerance.map(Ok).into_iter().chain(writes).collect::<Result<_, _>>()?;
        Ok((Node { plan, map_outputs, map_inputs, writes, outputs }, places))
    }

    /// Objects follow one another without a gap where no offset is given. No bit is two objects', and the limit of the node,
    /// in bytes, has room for all.
    fn mapping(
        &self,
        items: &[Spanned<RawMapped>],
        (key, limit): (&str, u16),
    ) -> Result<Vec<MappingEntry>, ScenarioError> {
        let mut end = 0_u16;
        let mut entries: Vec<MappingEntry> = Vec::new();
        for item in items {
            let (raw, span) = (item.get_ref(), item.span());
            let object = self.object(raw.object.as_ref(), &span)?;
            let (mut length, mut offset) = (0_u16, end);
            let Some(bits) = &raw.bits else {
                return self.fail(&span, "`bits`, the length of the object, is missing");
            };
            self.number(&mut length, Some(bits), 1, 11_920)?;
            self.number(&mut offset, raw.offset.as_ref(), 0, 11_919)?;
            end = offset.saturating_add(length);
            let bytes = end.div_ceil(8);
            if bytes > limit {
                return self.fail(&span, format!("it ends at byte {bytes}; `{key}` of this node is {limit}"));
            }
            let is_apart = |other: &MappingEntry| {
                end <= other.offset || offset >= other.offset.saturating_add(other.length)
            };
            if let Some(other) = entries.iter().find(|other| !is_apart(other)) {
                let last = other.offset.saturating_add(other.length) - 1;
                let message = format!("bits {} to {last} are those of {}", other.offset, other.object);
                return self.fail(&span, message);
            }
            entries.push(MappingEntry { object, offset, length });
        }
        Ok(entries)
    }

    fn write(&self, item: &Spanned<RawWrite>) -> Result<Write, ScenarioError> {
        let (raw, span) = (item.get_ref(), item.span());
        let at = self.object(raw.object.as_ref(), &span)?;
        let data = match (&raw.value, &raw.size, &raw.data) {
            (None, None, Some(_)) => self.bytes(raw.data.as_ref())?,
            (Some(value), Some(size), None) => self.value(value, size)?,
            _ => return self.fail(&span, "expected either `data`, or `value` and `size` in bytes"),
        };
        Ok(Write { at, data, may_fail: raw.may_fail.unwrap_or(false) })
    }

    /// Little-endian.
    fn value(&self, value: &Spanned<i64>, size: &Spanned<i64>) -> Result<Vec<u8>, ScenarioError> {
        let mut len = 0_u8;
        self.number(&mut len, Some(size), 1, 8)?;
        let number = *value.get_ref();
        let bits = 8 * u32::from(len);
        let fits = bits == 64 || (-(1_i64 << (bits - 1))..1_i64 << bits).contains(&number);
        if !fits {
            return self.fail(&value.span(), format!("{number} does not fit into {}", ByteCount(len.into())));
        }
        Ok(number.to_le_bytes().into_iter().take(len.into()).collect())
    }

    fn object(
        &self,
        name: Option<&Spanned<String>>,
        table: &Range<usize>,
    ) -> Result<ObjectAddress, ScenarioError> {
        let Some(name) = name else { return self.fail(table, "`object` is missing") };
        let address = name.get_ref().split_once('/').and_then(|(index, sub)| {
            // Nobody writes an index in decimal: one without 0x is a slip.
            let index = unsigned(index).filter(|_| index.to_ascii_lowercase().starts_with("0x"))?;
            let sub = unsigned(sub)?;
            Some(ObjectAddress::new(u16::try_from(index).ok()?, u8::try_from(sub).ok()?))
        });
        match address {
            Some(address) => Ok(address),
            None => {
                self.fail(&name.span(), "expected index and sub-index of an object, such as \"0x6200/1\"")
            }
        }
    }

    fn bytes(&self, text: Option<&Spanned<String>>) -> Result<Vec<u8>, ScenarioError> {
        let Some(text) = text else { return Ok(Vec::new()) };
        match hex_bytes(text.get_ref()) {
            Some(bytes) => Ok(bytes),
            None => {
                self.fail(&text.span(), "expected an even number of hexadecimal digits, such as \"01ff\"")
            }
        }
    }

    fn optional<T: TryFrom<i64> + Default + TryFrom<u64>>(
        &self,
        value: Option<&Spanned<i64>>,
    ) -> Result<Option<T>, ScenarioError> {
        let Some(value) = value else { return Ok(None) };
        match T::try_from(*value.get_ref()) {
            Ok(number) => Ok(Some(number)),
            Err(_) => {
                let most = u64::MAX >> (64 - 8 * size_of::<T>());
                self.fail(&value.span(), format!("{} is out of range; expected 0 to {most}", value.get_ref()))
            }
        }
    }

    /// A time that an object of 32 bits has in nanoseconds.
    fn nanos(&self, value: Option<&Spanned<Time>>, default: u32) -> Result<u32, ScenarioError> {
        let Some(value) = value else { return Ok(default) };
        match u32::try_from(time(value).as_nanos()) {
            Ok(nanos) => Ok(nanos),
            Err(_) => self.fail(&value.span(), "expected at most 4.2s"),
        }
    }

    /// Sets `place`, if there is a value.
    fn number<T: TryFrom<i64>>(
        &self,
        place: &mut T,
        value: Option<&Spanned<i64>>,
        least: i64,
        most: i64,
    ) -> Result<(), ScenarioError> {
        let Some(value) = value else { return Ok(()) };
        let number = *value.get_ref();
        match T::try_from(number).ok().filter(|_| (least..=most).contains(&number)) {
            Some(number) => *place = number,
            None => {
                return self
                    .fail(&value.span(), format!("{number} is out of range; expected {least} to {most}"));
            }
        }
        Ok(())
    }
}

fn time(value: &Spanned<Time>) -> Duration {
    value.get_ref().0
}

/// Programs on computers need longer than the 25 and 100 us of the specification.
/// In which a node follows a command, and answers over SDO.
const SOME_CYCLES: u32 = 10;
const PRES_TIMEOUT: Duration = Duration::from_millis(1);
const ASYNC_SLOT: Duration = Duration::from_millis(1);
/// In ns; as the network of openPOWERLINK's demonstration has it. SoC comes late where a computer sends it or hears it.
const LOSS_OF_SOC_TOLERANCE: u32 = 50_000_000;
const SOC_TOLERANCE: ObjectAddress = ObjectAddress::new(0x1C14, 0);
/// The most process data.
const LIMIT: i64 = 1490;
