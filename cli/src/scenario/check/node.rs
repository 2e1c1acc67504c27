//! `[[node]]`

use core::ops::Range;
use core::time::Duration;

use link_core::BitRate;
use toml::Spanned;

use super::{Checker, list};
use crate::scenario::diagnostic::ScenarioError;
use crate::scenario::model::{Kind, Node, NodeIndex, Recorded, Role};
use crate::scenario::raw::{RawIdentity, RawNode};
use crate::scenario::replay;
use crate::scenario::values::RateSetting;

impl Checker<'_> {
    /// Checks one table and appends its nodes: one, or as many as `count` says.
    pub(super) fn node(
        &mut self,
        table: &Spanned<RawNode>,
        bus_rate: BitRate,
        nodes: &mut Vec<Node>,
    ) -> Result<(), ScenarioError> {
        let (raw, span) = (table.get_ref(), table.span());
        let name = self.required(raw.name.as_ref(), &span, "`name` of the node")?;
        if name.get_ref().is_empty() || name.get_ref().chars().any(|c| c.is_whitespace() || c.is_control()) {
            return self.fail(
                &name.span(),
                format!("the name is {:?}; expected one or more characters without spaces", name.get_ref()),
            );
        }
        let role = self.role(raw, &span)?;
        let bit_rate = match &raw.bit_rate {
            None => bus_rate,
            // It is what the detection begins with.
            Some(setting) if *setting.get_ref() == RateSetting::Auto && role.is(Kind::Server) => {
                BitRate::K125
            }
            Some(setting) => self.rate_setting(setting)?,
        };
        let node = Node {
            name: name.get_ref().clone(),
            role,
            power_up: raw.power_up.as_ref().map(|time| *time.get_ref()).unwrap_or_default(),
            reaction: raw.reaction.as_ref().map(|time| *time.get_ref()).unwrap_or_default(),
            bit_rate,
            clock_ppm: raw.clock_ppm.as_ref().map(|ppm| self.ppm("clock_ppm", ppm)).transpose()?.unwrap_or(0),
        };
        let Some(count) = &raw.count else {
            let index = self.add(node, name, nodes)?;
            return self.call(name.get_ref(), name, vec![index]);
        };
        let copies = self.copies(&node, count, raw.identity.as_ref())?;
        let mut group = Vec::new();
        for copy in copies {
            let own = copy.name.clone();
            let index = self.add(copy, name, nodes)?;
            self.call(&own, name, vec![index])?;
            group.push(index);
        }
        self.call(name.get_ref(), name, group)
    }

    fn add(
        &self,
        node: Node,
        place: &Spanned<String>,
        nodes: &mut Vec<Node>,
    ) -> Result<NodeIndex, ScenarioError> {
        let index = NodeIndex(nodes.len());
        if index.0 >= MOST_NODES {
            return self
                .fail(&place.span(), format!("there are too many nodes; expected at most {MOST_NODES}"));
        }
        nodes.push(node);
        Ok(index)
    }

    /// Gives nodes a name, which nobody else may have: neither a node nor all those of a `count`.
    fn call(
        &mut self,
        name: &str,
        place: &Spanned<String>,
        nodes: Vec<NodeIndex>,
    ) -> Result<(), ScenarioError> {
        if self.names.contains_key(name) {
            return self.fail(
                &place.span(),
                format!("there are two nodes `{name}`; expected a name of its own for each"),
            );
        }
        self.names.insert(name.to_owned(), nodes);
        Ok(())
    }

    /// The nodes of a `count`: named `name-1`, `name-2` and so on, each with the next serial number.
    fn copies(
        &self,
        node: &Node,
        count: &Spanned<i64>,
        identity: Option<&Spanned<RawIdentity>>,
    ) -> Result<Vec<Node>, ScenarioError> {
        let number: u32 = self.number("count", count, 1, 127, "a number of nodes, 1 to 127")?;
        let width = number.to_string().len();
        let mut copies = Vec::new();
        for n in 0..number {
            let mut copy = Node { name: format!("{}-{:0width$}", node.name, n + 1), ..node.clone() };
            if let (Some(device), Some(identity)) = (copy.role.identity_mut(), identity) {
                let Some(serial) = device.serial.checked_add(n) else {
                    return self.fail(
                        &identity.span(),
                        format!(
                            "the serial numbers of {number} nodes rise beyond 0xFFFF_FFFF; expected a lower first"
                        ),
                    );
                };
                device.serial = serial;
            }
            copies.push(copy);
        }
        Ok(copies)
    }

    fn role(&self, raw: &RawNode, table: &Range<usize>) -> Result<Role, ScenarioError> {
        let role = self.required(raw.role.as_ref(), table, "`role` of the node")?;
        if let Some(keys) = role_keys(role.get_ref()) {
            self.only(raw, &keys, &format!("the role `{}`", role.get_ref()))?;
        }
        match role.get_ref().as_str() {
            "access" => self.access(raw, table).map(Role::Access),
            "tool" => self.access(raw, table).map(Role::Tool),
            "slave" => Ok(Role::Slave(Box::new(self.slave(raw, table)?))),
            "master" => Ok(Role::Master(Box::new(self.master(raw, table)?))),
            "device" => Ok(Role::Device(Box::new(self.nex_device(raw, table)?))),
            "manager" => Ok(Role::Manager(Box::new(self.nex_manager(raw, table)?))),
            "replay" => self.replay(raw, table),
            "listener" => Ok(Role::Listener),
            "external" => Ok(Role::External),
            "babbler" => {
                let frame =
                    self.frame(self.required(raw.frame.as_ref(), table, "`frame`, what it sends,")?)?;
                let period = raw.period.as_ref().map_or(Duration::ZERO, |period| period.get_ref().0);
                Ok(Role::Babbler { frame, period })
            }
            other => self.fail(&role.span(), format!("there is no role `{other}`; expected {}", list(ROLES))),
        }
    }

    fn replay(&self, raw: &RawNode, table: &Range<usize>) -> Result<Role, ScenarioError> {
        let frames = match (&raw.file, &raw.log) {
            (Some(file), None) => {
                let path = self.folder.join(file.get_ref());
                let opened = std::fs::read(&path);
                let bytes = match opened {
                    Ok(bytes) => bytes,
                    Err(error) => {
                        return self.fail(
                            &file.span(),
                            format!(
                                "the recording {} cannot be read: {error}; expected a candump log",
                                path.display()
                            ),
                        );
                    }
                };
                replay::frames(&path.display().to_string(), &bytes)
                    .or_else(|error| self.fail(&file.span(), error))?
            }
            (None, Some(log)) => replay::frames("`log`", log.get_ref().trim_start().as_bytes())
                .or_else(|error| self.fail(&log.span(), error))?,
            (Some(_), Some(log)) => {
                return self.fail(&log.span(), "there are both `file` and `log`; expected one of them");
            }
            (None, None) => {
                return self.fail(table, "a replay has neither `file` nor `log`; expected one of them");
            }
        };
        let Some(only) = &raw.only else { return self.played(frames, table) };
        let mut kept = Vec::new();
        for id in only.get_ref() {
            match u32::try_from(*id) {
                Ok(id) if id <= 0x1FFF_FFFF => kept.push(id),
                _ => {
                    return self.fail(
                        &only.span(),
                        format!("`only` has {id}; expected identifiers, 0 to 0x1FFF_FFFF"),
                    );
                }
            }
        }
        let is_kept = |played: &Recorded| kept.contains(&played.frame.raw_id());
        self.played(frames.into_iter().filter(is_kept).collect(), &only.span())
    }

    fn played(&self, frames: Vec<Recorded>, place: &Range<usize>) -> Result<Role, ScenarioError> {
        if frames.is_empty() {
            return self.fail(place, "nothing of the recording is left to be played; expected a frame");
        }
        Ok(Role::Replay(frames))
    }
}

/// The keys that a role takes; `None` if there is no such role.
pub(super) fn role_keys(role: &str) -> Option<Vec<&'static str>> {
    let own: [&[&str]; 2] = match role {
        "access" | "tool" => [DEVICE, &[]],
        "slave" => [DEVICE, SLAVE],
        "master" => [DEVICE, MASTER],
        "device" => [NEX, &["produce", "consume", "input"]],
        "manager" => [NEX, MANAGER],
        "replay" => [&["file", "log", "only"], &[]],
        "listener" | "external" => [&[], &[]],
        "babbler" => [&["frame", "period"], &[]],
        _ => return None,
    };
    Some([ANY_ROLE, own[0], own[1]].concat())
}

pub(in crate::scenario) const ROLES: &[&str] = Kind::Any.roles();
const ANY_ROLE: &[&str] = &["name", "count", "role", "power_up", "reaction", "bit_rate", "clock_ppm"];
const DEVICE: &[&str] =
    &["protocol", "mac", "identity", "port", "boi", "quick_connect", "offline_set", "switches"];
const NEX: &[&str] = &["protocol", "oa", "identity", "port", "boi", "hello_wait", "announcement"];
const MANAGER: &[&str] = &[
    "mini_who",
    "idle_mini_who",
    "roam_tries",
    "connect_tries",
    "spare_wait",
    "learning",
    "takeover_after",
    "rejoin_after",
    "planned",
];
const SLAVE: &[&str] = &[
    "poll",
    "bit_strobe",
    "cos",
    "cyclic",
    "multicast_poll",
    "input",
    "ucmm",
    "unconnected_port",
    "heartbeat",
    "shutdown_message",
];
const MASTER: &[&str] = &[
    "scan",
    "run",
    "interscan_delay",
    "response_wait",
    "background_ratio",
    "first_contact",
    "retry_after",
    "retry_at_most",
    "replacement",
    "replacement_retry",
    "multicast_output",
];
const MOST_NODES: usize = 256;
