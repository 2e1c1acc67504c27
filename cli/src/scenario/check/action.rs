//! `[[action]]`

use core::ops::Range;

use devicenet_core::message::DeviceIdentity;
use devicenex_core::OperationalAddress;
use serde::Deserialize;
use toml::Spanned;

use super::{Checker, list, master};
use crate::scenario::diagnostic::ScenarioError;
use crate::scenario::model::{Action, Do, MasterNode, Node, NodeIndex, Output, Role};
use crate::scenario::raw::RawAction;
use crate::scenario::values::{SlaveName, rate};

/// The `value` of `set_output`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct RawOutput {
    slave: Option<SlaveName>,
    data: Option<String>,
    strobe_bit: Option<bool>,
    multicast: Option<String>,
}

/// The `value` of `readdress`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct RawReaddress {
    device: SlaveName,
    oa: i64,
}

/// The `value` of `recover` and `identify`: a device, by the name of its node or by what it is.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct RawDevice {
    node: Option<String>,
    vendor: Option<i64>,
    serial: Option<i64>,
    mac: Option<i64>,
}

impl Checker<'_> {
    pub(super) fn action(&self, table: &Spanned<RawAction>, nodes: &[Node]) -> Result<Action, ScenarioError> {
        let (raw, span) = (table.get_ref(), table.span());
        let at =
            self.moment("at", self.required(raw.at.as_ref(), &span, "`at`, the time of the action,")?)?;
        let name = self.required(raw.node.as_ref(), &span, "`node` of the action")?;
        let targets = self.named(name)?;
        let action = self.required(raw.action.as_ref(), &span, "`do` of the action")?;
        let one = targets.first().and_then(|index| nodes.get(index.0));
        let what = self.what(raw, action, &span, &Target { node: one, nodes })?;
        match one {
            Some(node) if !node.role.is(what.kind()) => self.unfit_action(name, action, &node.role, &what),
            Some(_) | None => Ok(Action { at, nodes: targets, what }),
        }
    }

    fn unfit_action<T>(
        &self,
        name: &Spanned<String>,
        action: &Spanned<String>,
        role: &Role,
        what: &Do,
    ) -> Result<T, ScenarioError> {
        self.fail(
            &action.span(),
            format!(
                "`{}` cannot be done to `{}`, whose role is `{}`; expected a node with the role {}",
                action.get_ref(),
                name.get_ref(),
                role.name(),
                list(what.kind().roles())
            ),
        )
    }

    fn what(
        &self,
        raw: &RawAction,
        action: &Spanned<String>,
        table: &Range<usize>,
        target: &Target<'_>,
    ) -> Result<Do, ScenarioError> {
        let plain = |what: Do| match &raw.value {
            None => Ok(what),
            Some(value) => self.fail(&value.span(), format!("`{}` takes no `value`", action.get_ref())),
        };
        match action.get_ref().as_str() {
            "cut" => plain(Do::Cut),
            "plug" => plain(Do::Plug),
            "power_off" => plain(Do::PowerOff),
            "power_on" => plain(Do::PowerOn),
            "power_cycle" => plain(Do::PowerCycle),
            "reset" => plain(Do::Reset),
            "go_run" => plain(Do::GoRun),
            "go_idle" => plain(Do::GoIdle),
            "claim" => plain(Do::Claim),
            "release" => plain(Do::Release),
            "who" => plain(Do::Who),
            "set_mac" => Ok(Do::SetMac(self.mac_id("value", &self.integer(raw, table, "the MAC ID")?)?)),
            "set_oa" => {
                let value = self.integer(raw, table, "the operational address")?;
                Ok(Do::SetOa(self.operational_address("value", &value, 127)?))
            }
            "readdress" => self.readdress(raw, table, target),
            "set_bit_rate" => Ok(Do::SetBitRate(self.bit_rate("value", &self.rate(raw, table)?)?)),
            "set_input" => self.input(raw, table, target),
            "set_output" => self.output(raw, table, target),
            "identify" => {
                let (device, value) = self.device(raw, table)?;
                match device.mac {
                    None => Ok(Do::Identify(self.who(&device, &value, target)?)),
                    Some(_) => self.fail(&value, "`identify` takes no `mac`; expected the device only"),
                }
            }
            "recover" => {
                let (device, value) = self.device(raw, table)?;
                match device.mac {
                    Some(mac) => {
                        let mac = self.mac_id("mac", &Spanned::new(value.clone(), mac))?;
                        Ok(Do::Recover(self.who(&device, &value, target)?, mac))
                    }
                    None => self.fail(&value, "`mac`, the MAC ID that the device shall have, is missing"),
                }
            }
            other => {
                self.fail(&action.span(), format!("there is no action `{other}`; expected {}", list(ACTIONS)))
            }
        }
    }

    /// A node, by its planned address or any, and its new address.
    fn readdress(
        &self,
        raw: &RawAction,
        table: &Range<usize>,
        target: &Target<'_>,
    ) -> Result<Do, ScenarioError> {
        let value = self.required(raw.value.as_ref(), table, "`value`, the node and its new address,")?;
        let span = value.span();
        let Some(Role::Manager(manager)) = target.node.map(|node| &node.role) else {
            return Ok(Do::Readdress(OperationalAddress::NONE, OperationalAddress::NONE));
        };
        let new: RawReaddress = match value.get_ref().clone().try_into() {
            Ok(new) => new,
            Err(error) => return self.fail(&span, format!("{}; expected {READDRESS}", error.message())),
        };
        let number = |number: i64| Spanned::new(span.clone(), number);
        let from = match new.device {
            SlaveName::Mac(oa) => self.operational_address("device", &number(oa), 126)?,
            device => self.planned_oa(&Spanned::new(span.clone(), device), manager, target.nodes)?,
        };
        let to = self.operational_address("oa", &number(new.oa), 127)?;
        if to == manager.node.oa {
            return self.fail(&span, format!("OA {to} is the manager's own; expected another"));
        }
        Ok(Do::Readdress(from, to))
    }

    fn operational_address(
        &self,
        key: &str,
        value: &Spanned<i64>,
        last: u8,
    ) -> Result<OperationalAddress, ScenarioError> {
        let what = if last == 127 { "0 to 126, or 127 for none" } else { "an operational address, 0 to 126" };
        let number: u8 = self.number(key, value, 0, last.into(), what)?;
        // Not above 127.
        Ok(OperationalAddress::new(number).unwrap_or(OperationalAddress::NONE))
    }

    /// The input data of a slave.
    fn input(&self, raw: &RawAction, table: &Range<usize>, target: &Target<'_>) -> Result<Do, ScenarioError> {
        let data = self.text(raw, table, "the input data in hex")?;
        match target.node.map(|node| &node.role) {
            Some(Role::Slave(slave)) => {
                let why = "as the longest connection of the slave produces";
                Ok(Do::SetInput(self.data("value", &data, slave.input.len(), why)?))
            }
            Some(Role::Device(device)) => {
                Ok(Do::SetInput(self.data("value", &data, device.input.len(), "as the device produces")?))
            }
            Some(_) | None => Ok(Do::SetInput(Vec::new())),
        }
    }

    /// The output data of a master, and to whom they go.
    fn output(
        &self,
        raw: &RawAction,
        table: &Range<usize>,
        target: &Target<'_>,
    ) -> Result<Do, ScenarioError> {
        let value = self.required(raw.value.as_ref(), table, "`value`, the output data,")?;
        let Some(Role::Master(master)) = target.node.map(|node| &node.role) else {
            return Ok(Do::SetOutput(Output::Multicast(Vec::new())));
        };
        let span = value.span();
        let bytes = |text: &str, length: usize, why: &str| {
            self.data("value", &Spanned::new(span.clone(), text.to_owned()), length, why)
        };
        let to_slave = |mac: u8, text: &str| {
            let length = master.scanned(mac).map_or(0, |slave| slave.entry.output_len());
            Ok(Do::SetOutput(Output::Slave(mac, bytes(text, length, "as the slave consumes")?)))
        };
        if let (Some(text), [only]) = (value.get_ref().as_str(), master.scan.as_slice()) {
            return to_slave(only.entry.mac_id.number(), text);
        }
        let raw: RawOutput = match value.get_ref().clone().try_into() {
            Ok(raw) => raw,
            Err(error) => return self.fail(&span, format!("{}; expected {OUTPUT}", error.message())),
        };
        match (&raw.slave, &raw.data, raw.strobe_bit, &raw.multicast) {
            (Some(slave), Some(data), None, None) => {
                to_slave(self.scanned_mac(slave, &span, master, target.nodes)?, data)
            }
            (Some(slave), None, Some(bit), None) => {
                let mac = self.scanned_mac(slave, &span, master, target.nodes)?;
                if master.scanned(mac).is_some_and(|slave| slave.entry.bit_strobe.is_none()) {
                    return self
                        .fail(&span, "`strobe_bit` is for a slave with `bit_strobe` in the scan list");
                }
                Ok(Do::SetOutput(Output::StrobeBit(mac, bit)))
            }
            (None, None, None, Some(data)) => {
                let why = "as the multicast poll of the scan list consumes";
                Ok(Do::SetOutput(Output::Multicast(bytes(data, master::multicast_size(&master.scan), why)?)))
            }
            _ => self.fail(&span, format!("this is no output; expected {OUTPUT}")),
        }
    }

    /// The MAC ID of a slave in the scan list of a master.
    pub(super) fn scanned_mac(
        &self,
        slave: &SlaveName,
        span: &Range<usize>,
        master: &MasterNode,
        nodes: &[Node],
    ) -> Result<u8, ScenarioError> {
        let mac = match slave {
            SlaveName::Mac(mac) => self.mac_id("slave", &Spanned::new(span.clone(), *mac))?,
            SlaveName::Node(name) => {
                let first = self.nodes(name, span)?.first().copied();
                match first.and_then(|NodeIndex(index)| nodes.get(index)).and_then(|node| node.role.access())
                {
                    Some(access) => access.mac,
                    None => {
                        return self.fail(span, format!("`{name}` has no MAC ID; expected a slave"));
                    }
                }
            }
        };
        if master.scanned(mac).is_none() {
            let macs: Vec<String> =
                master.scan.iter().map(|slave| slave.entry.mac_id.number().to_string()).collect();
            return self.fail(
                span,
                format!("MAC ID {mac} is not in the scan list of the master; expected {}", list(&macs)),
            );
        }
        Ok(mac)
    }

    fn device(
        &self,
        raw: &RawAction,
        table: &Range<usize>,
    ) -> Result<(RawDevice, Range<usize>), ScenarioError> {
        let value = self.required(raw.value.as_ref(), table, "`value`, the device,")?;
        match value.get_ref().clone().try_into() {
            Ok(device) => Ok((device, value.span())),
            Err(error) => self.fail(&value.span(), format!("{}; expected {DEVICE}", error.message())),
        }
    }

    fn who(
        &self,
        device: &RawDevice,
        span: &Range<usize>,
        target: &Target<'_>,
    ) -> Result<DeviceIdentity, ScenarioError> {
        let number = |value: i64| Spanned::new(span.clone(), value);
        match (&device.node, device.vendor, device.serial) {
            (Some(name), None, None) => {
                let first = self.nodes(name, span)?.first().copied();
                let node = first.and_then(|NodeIndex(index)| target.nodes.get(index));
                match node.and_then(|node| node.role.access()) {
                    Some(access) => Ok(access.on_the_wire()),
                    None => {
                        self.fail(span, format!("`{name}` has no identity; expected a node that has one"))
                    }
                }
            }
            (None, Some(vendor), Some(serial)) => {
                let vendor = self.vendor(&number(vendor))?.into();
                Ok(DeviceIdentity { vendor, serial: self.serial(&number(serial))? })
            }
            _ => self.fail(span, format!("this is no device; expected {DEVICE}")),
        }
    }

    /// A bit rate: a number, or a text with a unit.
    fn rate(&self, raw: &RawAction, table: &Range<usize>) -> Result<Spanned<i64>, ScenarioError> {
        match &raw.value {
            Some(value) if let Some(rate) = value.get_ref().as_str().and_then(rate) => {
                Ok(Spanned::new(value.span(), rate))
            }
            _ => self.integer(raw, table, "the bit rate in bit/s"),
        }
    }

    fn text(
        &self,
        raw: &RawAction,
        table: &Range<usize>,
        what: &str,
    ) -> Result<Spanned<String>, ScenarioError> {
        let value = self.required(raw.value.as_ref(), table, &format!("`value`, {what},"))?;
        match value.get_ref() {
            toml::Value::String(text) => Ok(Spanned::new(value.span(), text.clone())),
            other => {
                self.fail(&value.span(), format!("`value` is {}; expected {what}, a text", type_of(other)))
            }
        }
    }

    fn integer(
        &self,
        raw: &RawAction,
        table: &Range<usize>,
        what: &str,
    ) -> Result<Spanned<i64>, ScenarioError> {
        let value = self.required(raw.value.as_ref(), table, &format!("`value`, {what},"))?;
        match value.get_ref() {
            toml::Value::Integer(number) => Ok(Spanned::new(value.span(), *number)),
            other => {
                self.fail(&value.span(), format!("`value` is {}; expected {what}, a number", type_of(other)))
            }
        }
    }
}

/// To whom an action is done, among whom.
struct Target<'a> {
    node: Option<&'a Node>,
    nodes: &'a [Node],
}

/// `an integer`
fn type_of(value: &toml::Value) -> String {
    let name = value.type_str();
    let article = if name.starts_with(['a', 'i']) { "an" } else { "a" };
    format!("{article} {name}")
}

pub(in crate::scenario) const ACTIONS: &[&str] = &[
    "cut",
    "plug",
    "power_off",
    "power_on",
    "power_cycle",
    "set_mac",
    "set_oa",
    "readdress",
    "set_bit_rate",
    "reset",
    "set_input",
    "set_output",
    "go_run",
    "go_idle",
    "claim",
    "release",
    "who",
    "identify",
    "recover",
];
const OUTPUT: &str = "{ slave = \"valve\", data = \"01FF\" }, { slave = \"valve\", strobe_bit = true } or { multicast = \
                      \"01FF\" }";
const READDRESS: &str = "{ device = \"valve\", oa = 12 }";
const DEVICE: &str = "{ node = \"valve\", .. } or { vendor = 0x1234, serial = 0x00002345, .. }";
