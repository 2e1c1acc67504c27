//! `[[node.planned]]`: the database of a network manager.

use cip_core::code::{AttributeId, ClassId, InstanceId, VendorId};
use devicenex_core::OperationalAddress;
use devicenex_core::message::DeviceIdentity;
use serde::Deserialize;
use toml::Spanned;

use super::Checker;
use crate::scenario::diagnostic::ScenarioError;
use crate::scenario::model::{
    Attribute, ManagerNode, NexConnection, NexNode, Node, Pattern, Planned, PlannedIo, Role, WatchdogName,
};
use crate::scenario::raw::{RawNode, RawPlanned, RawPlannedIo};
use crate::scenario::values::SlaveName;

/// A device that need not be a node.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct RawPattern {
    vendor: Option<i64>,
    product: Option<i64>,
    revision: Option<i64>,
    serial: Option<i64>,
}

impl Checker<'_> {
    /// Gives the managers their databases: these name nodes, which must be known.
    pub(super) fn plans(&self, tables: &[Spanned<RawNode>], nodes: &mut [Node]) -> Result<(), ScenarioError> {
        for raw in tables.iter().map(Spanned::get_ref) {
            let (Some(name), Some(entries)) = (&raw.name, &raw.planned) else { continue };
            for index in self.named(name)? {
                let own = nodes.get(index.0).and_then(|node| node.role.nex()).map(|node| node.oa);
                let planned = self.plan(entries.get_ref(), own, nodes)?;
                if let Some(Role::Manager(manager)) = nodes.get_mut(index.0).map(|node| &mut node.role) {
                    manager.planned = planned;
                }
            }
        }
        Ok(())
    }

    fn plan(
        &self,
        entries: &[Spanned<RawPlanned>],
        own: Option<OperationalAddress>,
        nodes: &[Node],
    ) -> Result<Vec<Planned>, ScenarioError> {
        let mut planned: Vec<Planned> = Vec::new();
        let mut tables = Vec::new();
        for entry in entries {
            for one in self.roles(entry, nodes)? {
                let place = entry.get_ref().oa.as_ref().map_or_else(|| entry.span(), Spanned::span);
                if Some(one.oa) == own {
                    return self
                        .fail(&place, format!("OA {} is the manager's own; expected another", one.oa));
                }
                if planned.iter().any(|other| other.oa == one.oa) {
                    return self.fail(&place, format!("OA {} is planned already; expected another", one.oa));
                }
                let is_same = |other: &&Planned| !one.device.any_serial && other.device == one.device;
                if let Some(other) = planned.iter().find(is_same) {
                    let device = entry.get_ref().device.as_ref().map_or(place, Spanned::span);
                    return self.fail(
                        &device,
                        format!(
                            "this device is planned for OA {} already; expected another, or every device of a product",
                            other.oa
                        ),
                    );
                }
                planned.push(one);
                tables.push(entry.get_ref());
            }
        }
        if planned.len() > MOST_PLANNED {
            let place = entries.last().map_or(0..0, Spanned::span);
            return self.fail(&place, format!("there are too many planned; expected at most {MOST_PLANNED}"));
        }
        // A device may consume from one that comes later in the file.
        for (place, raw) in tables.into_iter().enumerate() {
            for (number, table) in connections(raw).iter().enumerate() {
                let from = self.source(table, nodes, &planned)?;
                planned[place].connections[number].from = from;
            }
        }
        Ok(planned)
    }

    /// One address, or one for each node of a `count`.
    fn roles(&self, entry: &Spanned<RawPlanned>, nodes: &[Node]) -> Result<Vec<Planned>, ScenarioError> {
        let (raw, span) = (entry.get_ref(), entry.span());
        let place = self.required(raw.oa.as_ref(), &span, "`oa`, the planned address,")?;
        let first: u8 = self.number("oa", place, 0, 126, "an operational address, 0 to 126")?;
        let device = self.required(raw.device.as_ref(), &span, "`device`, for whom the address is,")?;
        let mut roles = Vec::new();
        for (device, number) in self.patterns(device, nodes)?.into_iter().zip(first..) {
            let Some(oa) = OperationalAddress::new(number).filter(|oa| !oa.is_none()) else {
                return self.fail(&place.span(), "the addresses rise beyond 126; expected a lower `oa`");
            };
            roles.push(Planned {
                oa,
                device,
                spares: self.spares(raw, nodes)?,
                connections: self.planned_connections(raw)?,
                reads: self.reads(raw)?,
            });
        }
        Ok(roles)
    }

    fn spares(&self, raw: &RawPlanned, nodes: &[Node]) -> Result<Vec<Pattern>, ScenarioError> {
        let Some(spares) = &raw.spares else { return Ok(Vec::new()) };
        let mut patterns = Vec::new();
        for spare in spares.get_ref() {
            patterns.extend(self.patterns(spare, nodes)?);
        }
        if patterns.len() > SPARES {
            return self.fail(
                &spares.span(),
                format!(
                    "there are {} spares; expected at most {SPARES}, or every device of a product",
                    patterns.len()
                ),
            );
        }
        Ok(patterns)
    }

    /// `"valve"`, or `{ vendor = 0x1234, product = 7 }`.
    fn patterns(&self, value: &Spanned<toml::Value>, nodes: &[Node]) -> Result<Vec<Pattern>, ScenarioError> {
        let span = value.span();
        if let Some(name) = value.get_ref().as_str() {
            let mut patterns = Vec::new();
            for index in self.nodes(name, &span)? {
                match nodes.get(index.0).and_then(|node| node.role.nex()) {
                    Some(node) => patterns.push(Pattern { device: node.on_the_wire(), any_serial: false }),
                    None => {
                        return self.fail(&span, format!("`{name}` is no device of DeviceNeX; expected one"));
                    }
                }
            }
            return Ok(patterns);
        }
        let raw: RawPattern = match value.get_ref().clone().try_into() {
            Ok(raw) => raw,
            Err(error) => return self.fail(&span, format!("{}; expected {DEVICE}", error.message())),
        };
        let (Some(vendor), Some(product)) = (raw.vendor, raw.product) else {
            return self.fail(&span, format!("this is no device; expected {DEVICE}"));
        };
        let number = |value: i64| Spanned::new(span.clone(), value);
        let device = DeviceIdentity {
            vendor: VendorId(self.vendor(&number(vendor))?),
            product_code: self.number("product", &number(product), 0, 0xFFFF, "a number of 16 bits")?,
            major_revision: match raw.revision {
                Some(major) => {
                    self.number("revision", &number(major), 0, 255, "a major revision, 0 to 255")?
                }
                None => 1,
            },
            serial: raw.serial.map_or(Ok(0), |serial| self.serial(&number(serial)))?,
        };
        Ok(vec![Pattern { device, any_serial: raw.serial.is_none() }])
    }

    fn planned_connections(&self, raw: &RawPlanned) -> Result<Vec<PlannedIo>, ScenarioError> {
        let mut planned: Vec<PlannedIo> = Vec::new();
        for table in connections(raw) {
            let io = self.planned_io(table)?;
            let connection = io.connection;
            if planned.len() == CONNECTIONS {
                let many = connections(raw).len();
                return self.fail(
                    &table.span(),
                    format!("there are {many} connections; expected at most {CONNECTIONS} with one device"),
                );
            }
            let is_there = planned.iter().any(|other| other.connection == connection);
            if is_there && connection != NexConnection::Dynamic {
                return self.fail(
                    &table.span(),
                    format!("`{connection}` is planned twice; a device has each but `dynamic` once"),
                );
            }
            planned.push(io);
        }
        Ok(planned)
    }

    fn planned_io(&self, table: &Spanned<RawPlannedIo>) -> Result<PlannedIo, ScenarioError> {
        let (raw, span) = (table.get_ref(), table.span());
        let place = self.required(raw.connection.as_ref(), &span, "`connection`, its name,")?;
        let found = self.name("connection", Some(place), NexConnection::ALL, NexConnection::name)?;
        let connection = found.unwrap_or(NexConnection::Dynamic);
        if connection == NexConnection::Explicit {
            return self.fail(
                &place.span(),
                "the explicit connection is not planned, the manager opens it when it needs it; expected another",
            );
        }
        if connection.consumes_only() && raw.from.is_none() {
            return self.fail(
                &place.span(),
                format!("`{connection}` consumes; expected `from`, whose data it consumes, too"),
            );
        }
        let watchdog = self.name("watchdog", raw.watchdog.as_ref(), WatchdogName::ALL, WatchdogName::name)?;
        Ok(PlannedIo {
            connection,
            epr: raw.epr.as_ref().map_or(Ok(0), |epr| self.milliseconds("epr", epr))?,
            watchdog: watchdog.unwrap_or(WatchdogName::TimeOut).action(),
            from: None,
        })
    }

    /// The first connection on which that device sends by itself.
    fn source(
        &self,
        table: &Spanned<RawPlannedIo>,
        nodes: &[Node],
        planned: &[Planned],
    ) -> Result<Option<(OperationalAddress, u8)>, ScenarioError> {
        let Some(from) = &table.get_ref().from else { return Ok(None) };
        let span = from.span();
        let Some(source) = self.entry(from, nodes, planned)? else {
            return self.fail(
                &span,
                "nobody is planned there; expected the `oa` of an entry, or the name of its device",
            );
        };
        let place = source.connections.iter().position(|io| io.connection.sends());
        match place.and_then(|place| u8::try_from(place).ok()) {
            Some(place) => Ok(Some((source.oa, place))),
            None => self.fail(
                &span,
                format!("OA {} has no connection on which it sends by itself; expected one, such as `multicast_producer`", source.oa),
            ),
        }
    }

    /// The address of a planned device, by the name of its node or as a number.
    pub(super) fn planned_oa(
        &self,
        device: &Spanned<SlaveName>,
        manager: &ManagerNode,
        nodes: &[Node],
    ) -> Result<OperationalAddress, ScenarioError> {
        match self.entry(device, nodes, &manager.planned)? {
            Some(entry) => Ok(entry.oa),
            None => self.fail(
                &device.span(),
                "the manager has no such device planned; expected the `oa` of an entry, or the name of its device",
            ),
        }
    }

    fn entry<'p>(
        &self,
        device: &Spanned<SlaveName>,
        nodes: &[Node],
        planned: &'p [Planned],
    ) -> Result<Option<&'p Planned>, ScenarioError> {
        Ok(match device.get_ref() {
            SlaveName::Mac(oa) => planned.iter().find(|entry| i64::from(entry.oa.number()) == *oa),
            SlaveName::Node(name) => {
                let first = self.nodes(name, &device.span())?.first().copied();
                let node = first.and_then(|index| nodes.get(index.0)?.role.nex()).map(NexNode::on_the_wire);
                planned.iter().find(|entry| node.is_some_and(|node| entry.device.is(&node)))
            }
        })
    }

    fn reads(&self, raw: &RawPlanned) -> Result<Vec<Attribute>, ScenarioError> {
        let Some(tables) = &raw.reads else { return Ok(Vec::new()) };
        let mut reads = Vec::new();
        for table in tables.get_ref() {
            let (raw, span) = (table.get_ref(), table.span());
            let word = |key: &str, value: &Option<Spanned<i64>>| {
                let value =
                    self.required(value.as_ref(), &span, &format!("`{key}` of the attribute that is read"))?;
                self.number::<u16>(key, value, 0, 0xFF, "0 to 255: it is read without a connection")
            };
            reads.push(Attribute {
                class: ClassId(word("class", &raw.class)?),
                instance: InstanceId(word("instance", &raw.instance)?),
                attribute: AttributeId(word("attribute", &raw.attribute)?),
            });
        }
        if reads.len() > READS {
            return self
                .fail(&tables.span(), format!("there are {} reads; expected at most {READS}", reads.len()));
        }
        Ok(reads)
    }
}

fn connections(raw: &RawPlanned) -> &[Spanned<RawPlannedIo>] {
    raw.connections.as_ref().map(|tables| tables.get_ref().as_slice()).unwrap_or_default()
}

const DEVICE: &str =
    "the name of a node, or { vendor = 0x1234, product = 7, revision = 1, serial = 0x00002345 }";
/// As many addresses as there are beside the manager's.
const MOST_PLANNED: usize = 126;
const SPARES: usize = 4;
const CONNECTIONS: usize = 4;
const READS: usize = 4;
