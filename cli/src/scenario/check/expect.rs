//! `[[expect]]`

use core::ops::Range;

use link_core::Instant;
use toml::Spanned;

use super::nex::OPERATIONAL_ADDRESS;
use super::{Checker, list};
use crate::scenario::diagnostic::ScenarioError;
use crate::scenario::model::{
    ConnectionName, ConnectionStateName, DeviceStateName, EventName, Expectation, Kind, ModeName,
    NexConnection, Node, Protocol, Role, SlaveStateName, StateName, What, When,
};
use crate::scenario::raw::{RawExpect, Table};

impl Checker<'_> {
    pub(super) fn expectation(
        &self,
        table: &Spanned<RawExpect>,
        nodes: &[Node],
    ) -> Result<Expectation, ScenarioError> {
        let (raw, span) = (table.get_ref(), table.span());
        let when = self.when(raw, &span)?;
        let named = raw.node.as_ref().map(|name| self.named(name)).transpose()?;
        let first = named.as_ref().and_then(|nodes| nodes.first()).and_then(|index| nodes.get(index.0));
        let what = self.expected(raw, &span, first, nodes)?;
        if let (Some(event), When::At(_) | When::Always(..)) = (&raw.event, when) {
            return self.fail(
                &event.span(),
                "an event lasts no time; expected `by`, `from` and `to`, or `never` instead of `at` or `always`",
            );
        }
        let whom = match named {
            Some(named) => named,
            None if matches!(when, When::Never(..)) => {
                if !nodes.iter().any(|node| what.fits(&node.role)) {
                    return self.fail(&span, "there is no node of which this could be expected");
                }
                Vec::new()
            }
            None => {
                return self.fail(
                    &span,
                    "`node` is missing; expected whom it is about (only `never` may be about all)",
                );
            }
        };
        let mut named = whom.iter().filter_map(|index| nodes.get(index.0));
        if let Some(node) = named.find(|node| !what.fits(&node.role)) {
            return self.unfit(raw, &what, node, &span);
        }
        let line = ScenarioError::at(self.file, self.text, &span, "").line;
        Ok(Expectation { line, nodes: whom, when, what })
    }

    /// What is expected cannot come from a node of this role.
    fn unfit<T>(
        &self,
        raw: &RawExpect,
        what: &What,
        node: &Node,
        table: &Range<usize>,
    ) -> Result<T, ScenarioError> {
        let here = format!("`{}` has the role `{}` and", node.name, node.role.name());
        let Some((key, kind)) = what.keys().find(|(_, kind)| !node.role.is(*kind)) else {
            return self.fail(table, format!("{here} cannot be what is expected"));
        };
        let place =
            raw.keys().into_iter().find(|(name, _)| *name == key).map_or_else(|| table.clone(), |at| at.1);
        let roles = list(kind.roles());
        let message = match (key, &raw.event) {
            ("event", Some(event)) if event.get_ref() == EventName::Sent.name() => {
                format!("{here} never sends; expected a node with another role")
            }
            ("event", Some(event)) => {
                format!("{here} no event `{}`; expected a node with the role {roles}", event.get_ref())
            }
            ("input", _) if matches!(node.role, Role::Master(_)) => {
                "the input of a master is that of a slave; expected `slave` too".to_owned()
            }
            ("state", _) => {
                let roles = list(Kind::Access.roles());
                format!("{here} no state of network access; expected a node with the role {roles}")
            }
            (key, _) => format!("{here} no `{key}`; expected a node with the role {roles}"),
        };
        self.fail(&place, message)
    }

    /// `never` and `always`: true, or not there.
    fn is_set(&self, key: &str, flag: Option<&Spanned<bool>>) -> Result<bool, ScenarioError> {
        match flag {
            Some(flag) if !flag.get_ref() => self.fail(
                &flag.span(),
                format!("`{key}` is false, which says nothing; expected `{key} = true`, or no `{key}`"),
            ),
            flag => Ok(flag.is_some()),
        }
    }

    /// One of `by`, `at`, `never`, or `from` and `to`, the last with or without `always`.
    fn when(&self, raw: &RawExpect, table: &Range<usize>) -> Result<When, ScenarioError> {
        let never = self.is_set("never", raw.never.as_ref())?;
        let always = self.is_set("always", raw.always.as_ref())?;
        let from = raw.from.as_ref().map(|from| self.moment("from", from)).transpose()?;
        let to = raw.to.as_ref().map(|to| self.moment("to", to)).transpose()?;
        let first = from.unwrap_or(Instant::ZERO);
        if let (Some(last), Some(place)) = (to, &raw.to)
            && last < first
        {
            return self.fail(&place.span(), "`to` is before `from`; expected a later time");
        }
        let ranged = from.is_some() || to.is_some();
        match (&raw.by, &raw.at, never, always) {
            (Some(by), None, false, false) if !ranged => {
                Ok(When::Within(Instant::ZERO, Some(self.moment("by", by)?)))
            }
            (None, Some(at), false, false) if !ranged => Ok(When::At(self.moment("at", at)?)),
            (None, None, true, false) => Ok(When::Never(first, to)),
            (None, None, false, true) => Ok(When::Always(first, to)),
            (None, None, false, false) if ranged => Ok(When::Within(first, to)),
            (None, None, false, false) => self.fail(table, format!("there is no time; expected {TIMES}")),
            _ => self.fail(table, format!("there are several times; expected {TIMES}")),
        }
    }

    fn expected(
        &self,
        raw: &RawExpect,
        table: &Range<usize>,
        of: Option<&Node>,
        nodes: &[Node],
    ) -> Result<What, ScenarioError> {
        let what = What {
            state: self.state(raw, of)?,
            oa: raw.oa.as_ref().map(|oa| self.number("oa", oa, 0, 127, OPERATIONAL_ADDRESS)).transpose()?,
            tec: raw.tec.as_ref().map(|tec| *tec.get_ref()),
            rec: raw.rec.as_ref().map(|rec| *rec.get_ref()),
            bus_off: raw.bus_off.as_ref().map(|flag| *flag.get_ref()),
            connection: match speaks(of) {
                Some(Protocol::DeviceNex) => None,
                Some(Protocol::DeviceNet) | None => self.name(
                    "connection",
                    raw.connection.as_ref(),
                    ConnectionName::ALL,
                    ConnectionName::name,
                )?,
            },
            nex_connection: match speaks(of) {
                Some(Protocol::DeviceNex) => {
                    self.name("connection", raw.connection.as_ref(), NexConnection::ALL, NexConnection::name)?
                }
                Some(Protocol::DeviceNet) | None => None,
            },
            connection_state: self.name(
                "connection_state",
                raw.connection_state.as_ref(),
                ConnectionStateName::ALL,
                ConnectionStateName::name,
            )?,
            mode: self.name("mode", raw.mode.as_ref(), ModeName::ALL, ModeName::name)?,
            input: raw.input.as_ref().map(|input| self.bytes("input", input)).transpose()?,
            output: raw.output.as_ref().map(|output| self.bytes("output", output)).transpose()?,
            slave: match (&raw.slave, of.map(|node| &node.role)) {
                (Some(slave), Some(Role::Master(master))) => {
                    Some(self.scanned_mac(slave.get_ref(), &slave.span(), master, nodes)?)
                }
                (Some(slave), _) => {
                    return self
                        .fail(&slave.span(), "`slave` needs the `node` of a master; expected that too");
                }
                (None, _) => None,
            },
            slave_state: self.name(
                "slave_state",
                raw.slave_state.as_ref(),
                SlaveStateName::ALL,
                SlaveStateName::name,
            )?,
            status: raw.status.as_ref().map(|status| *status.get_ref()),
            device: match (&raw.device, of.map(|node| &node.role)) {
                (Some(device), Some(Role::Manager(manager))) => {
                    Some(self.planned_oa(device, manager, nodes)?.number())
                }
                (Some(device), _) => {
                    return self
                        .fail(&device.span(), "`device` needs the `node` of a manager; expected that too");
                }
                (None, _) => None,
            },
            device_state: self.name(
                "device_state",
                raw.device_state.as_ref(),
                DeviceStateName::ALL,
                DeviceStateName::name,
            )?,
            event: self.name("event", raw.event.as_ref(), EventName::ALL, EventName::name)?,
        };
        if what.keys().all(|(key, _)| key == "slave" || key == "device") {
            return self.fail(table, format!("nothing is expected; expected one or more of {}", list(WHAT)));
        }
        self.selected(raw, &what)?;
        Ok(what)
    }

    /// One of the states that the node can be in.
    fn state(&self, raw: &RawExpect, of: Option<&Node>) -> Result<Option<StateName>, ScenarioError> {
        let can_be = |state: &&StateName| of.is_some_and(|node| node.role.is(state.kind()));
        let own: Vec<StateName> = StateName::ALL.iter().filter(can_be).copied().collect();
        let states = if own.is_empty() { StateName::ALL } else { own.as_slice() };
        self.name("state", raw.state.as_ref(), states, StateName::name)
    }

    /// `connection` and `slave` select; what they select must be there.
    fn selected(&self, raw: &RawExpect, what: &What) -> Result<(), ScenarioError> {
        let has_connection_event = what.event.is_some_and(EventName::has_connection);
        let is_selected = what.connection_state.is_some()
            || what.mode.is_some()
            || what.input.is_some()
            || what.output.is_some()
            || has_connection_event;
        if let (Some(connection), false) = (&raw.connection, is_selected) {
            return self.fail(
                &connection.span(),
                "`connection` says nothing alone; expected `connection_state`, `mode`, `input`, `output` or an event \
                 of connections too",
            );
        }
        if let (Some(state), None, None) = (&raw.connection_state, &what.connection, &what.nex_connection) {
            return self.fail(&state.span(), "`connection_state` needs `connection`; expected that too");
        }
        if let (Some(state), None) = (&raw.slave_state, what.slave) {
            return self.fail(&state.span(), "`slave_state` needs `slave`; expected that too");
        }
        if let (Some(state), None) = (&raw.device_state, what.device) {
            return self.fail(&state.span(), "`device_state` needs `device`; expected that too");
        }
        let is_about_device = what.device_state.is_some() || what.event.is_some_and(EventName::has_device);
        if let (Some(device), false) = (&raw.device, is_about_device) {
            return self.fail(
                &device.span(),
                "`device` says nothing alone; expected `device_state` or an event of planned devices too",
            );
        }
        let is_about_slave = what.slave_state.is_some()
            || what.status.is_some()
            || what.input.is_some()
            || what.event.is_some_and(EventName::has_slave);
        if let (Some(slave), false) = (&raw.slave, is_about_slave) {
            return self.fail(
                &slave.span(),
                "`slave` says nothing alone; expected `slave_state`, `status`, `input` or an event of slaves too",
            );
        }
        Ok(())
    }
}

/// What the node speaks, if it is one.
fn speaks(node: Option<&Node>) -> Option<Protocol> {
    node.and_then(|node| node.role.protocol())
}

const TIMES: &str = "one of `by`, `at`, `from` and `to`, `always = true` or `never = true`";
const WHAT: &[&str] = &[
    "state",
    "oa",
    "tec",
    "rec",
    "bus_off",
    "connection_state",
    "mode",
    "input",
    "output",
    "slave_state",
    "status",
    "device_state",
    "event",
];
