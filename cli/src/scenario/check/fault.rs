//! `[[fault]]`

use core::ops::Range;
use core::time::Duration;

use link_core::Instant;
use toml::Spanned;

use super::{Checker, list};
use crate::scenario::diagnostic::ScenarioError;
use crate::scenario::model::{Fault, FaultKind, Node, NodeIndex};
use crate::scenario::raw::RawFault;
use crate::scenario::values::Time;

impl Checker<'_> {
    /// All of them: the bus can be split in two, not in three, and a clock has one speed.
    pub(super) fn faults(
        &self,
        tables: &[Spanned<RawFault>],
        nodes: &[Node],
    ) -> Result<Vec<Fault>, ScenarioError> {
        let mut faults: Vec<Fault> = Vec::new();
        for table in tables {
            if faults.len() == MOST_FAULTS {
                return self.fail(
                    &table.span(),
                    format!("there are too many faults; expected at most {MOST_FAULTS}"),
                );
            }
            let fault = self.fault(table)?;
            for other in faults.iter().filter(|other| overlap(other, &fault)) {
                self.bear(&fault.kind, &other.kind, nodes, &table.span())?;
            }
            faults.push(fault);
        }
        Ok(faults)
    }

    /// Refuses what cannot be at the same time.
    fn bear(
        &self,
        fault: &FaultKind,
        other: &FaultKind,
        nodes: &[Node],
        table: &Range<usize>,
    ) -> Result<(), ScenarioError> {
        match (fault, other) {
            (FaultKind::Segment { .. }, FaultKind::Segment { .. }) => self.fail(
                table,
                "there is another segment at this time; expected one after the other, with all its nodes in one",
            ),
            (FaultKind::Clock { nodes: these, .. }, FaultKind::Clock { nodes: those, .. }) => {
                match these.iter().find(|node| those.contains(node)).and_then(|node| nodes.get(node.0)) {
                    None => Ok(()),
                    Some(node) => self.fail(
                        table,
                        format!(
                            "the clock of `{}` has another fault at this time; expected one after the other",
                            node.name
                        ),
                    ),
                }
            }
            _ => Ok(()),
        }
    }

    fn fault(&self, table: &Spanned<RawFault>) -> Result<Fault, ScenarioError> {
        let (raw, span) = (table.get_ref(), table.span());
        let from = match &raw.from {
            Some(from) => self.moment("from", from)?,
            None => Instant::ZERO,
        };
        let to = raw.to.as_ref().map(|to| self.moment("to", to)).transpose()?;
        if let (Some(to), Some(place)) = (to, &raw.to)
            && to <= from
        {
            return self.fail(&place.span(), "`to` is not after `from`; expected a later time");
        }
        Ok(Fault { from, to, kind: self.fault_kind(raw, &span)? })
    }

    fn fault_kind(&self, raw: &RawFault, table: &Range<usize>) -> Result<FaultKind, ScenarioError> {
        let kind = self.required(raw.kind.as_ref(), table, "`kind` of the fault")?;
        if let Some(keys) = fault_keys(kind.get_ref()) {
            self.only(raw, &keys, &format!("the fault `{}`", kind.get_ref()))?;
        }
        match kind.get_ref().as_str() {
            "bit_error" => self.bit_error(raw, table),
            "lost_frame" => Ok(FaultKind::LostFrame {
                rate: raw.rate.as_ref().map(|rate| self.probability(rate)).transpose()?.unwrap_or(1.0),
                id: match &raw.id {
                    Some(id) => Some(self.number("id", id, 0, 0x7FF, "an 11-bit identifier, 0 to 0x7FF")?),
                    None => None,
                },
                overrun: raw.overrun.as_ref().is_some_and(|flag| *flag.get_ref()),
                nodes: self.some_nodes(raw, table)?,
            }),
            "noise" => {
                let gap = self.required(raw.gap.as_ref(), table, "`gap`, the mean time between bursts,")?;
                let length = self.required(raw.length.as_ref(), table, "`length` of a burst")?;
                Ok(FaultKind::Noise {
                    gap: self.span("gap", gap, "without a gap the bursts never end")?,
                    length: self.span("length", length, "a burst of no length disturbs nothing")?,
                    nodes: self.fault_nodes(raw)?,
                })
            }
            "babble" => self.babble(raw),
            "clock" => {
                let ppm = self.required(raw.ppm.as_ref(), table, "`ppm`, how much the clock is off,")?;
                Ok(FaultKind::Clock { ppm: self.ppm("ppm", ppm)?, nodes: self.some_nodes(raw, table)? })
            }
            "segment" => Ok(FaultKind::Segment { nodes: self.some_nodes(raw, table)? }),
            other => {
                self.fail(&kind.span(), format!("there is no fault `{other}`; expected {}", list(FAULTS)))
            }
        }
    }

    /// Of one frame, or at a rate.
    fn bit_error(&self, raw: &RawFault, table: &Range<usize>) -> Result<FaultKind, ScenarioError> {
        let nodes = self.fault_nodes(raw)?;
        match (&raw.rate, &raw.bit, &raw.frame) {
            (Some(rate), None, None) => Ok(FaultKind::BitErrors { rate: self.probability(rate)?, nodes }),
            (None, Some(bit), frame) => Ok(FaultKind::BitError {
                frame: match frame {
                    Some(frame) => {
                        self.number("frame", frame, 0, i64::MAX, "the number of a frame, from 0")?
                    }
                    None => 0,
                },
                bit: self.number("bit", bit, 0, 159, "the number of a bit, 0 to 159")?,
                nodes,
            }),
            (None, None, _) => self.fail(table, "`rate` per bit, or `bit` of one frame, is missing"),
            (Some(rate), Some(_), _) | (Some(rate), None, Some(_)) => self.fail(
                &rate.span(),
                "there are both `rate`, of every bit, and `bit` or `frame`, of one; expected one of them",
            ),
        }
    }

    fn babble(&self, raw: &RawFault) -> Result<FaultKind, ScenarioError> {
        match (&raw.pull, &raw.every) {
            (None, None) => Ok(FaultKind::Babble { pull: FOR_GOOD, every: FOR_GOOD }),
            (Some(pull), Some(every)) => {
                let pull = self.span("pull", pull, "a pull of no length disturbs nothing")?;
                if every.get_ref().0 <= pull {
                    return self.fail(
                        &every.span(),
                        "`every` is not longer than `pull`; expected a longer time, or neither of them for a bus that \
                         is dominant for good",
                    );
                }
                Ok(FaultKind::Babble { pull, every: every.get_ref().0 })
            }
            (Some(one), None) | (None, Some(one)) => self.fail(
                &one.span(),
                "there is only one of `pull` and `every`; expected both, or neither for a bus that is dominant for \
                 good",
            ),
        }
    }

    /// A time that is not zero.
    fn span(&self, key: &str, time: &Spanned<Time>, why: &str) -> Result<Duration, ScenarioError> {
        match *time.get_ref() {
            Time(Duration::ZERO) => {
                self.fail(&time.span(), format!("`{key}` is 0s, and {why}; expected a longer time"))
            }
            Time(time) => Ok(time),
        }
    }

    fn some_nodes(&self, raw: &RawFault, table: &Range<usize>) -> Result<Vec<NodeIndex>, ScenarioError> {
        let nodes = self.fault_nodes(raw)?;
        if nodes.is_empty() {
            return self.fail(table, "the fault has neither `node` nor `nodes`; expected whom it is about");
        }
        Ok(nodes)
    }

    fn fault_nodes(&self, raw: &RawFault) -> Result<Vec<NodeIndex>, ScenarioError> {
        if let (Some(_), Some(nodes)) = (&raw.node, &raw.nodes) {
            return self.fail(&nodes.span(), "there are both `node` and `nodes`; expected one of them");
        }
        let listed = raw.nodes.as_ref().map(|nodes| nodes.get_ref().as_slice()).unwrap_or_default();
        if let (Some(nodes), []) = (&raw.nodes, listed) {
            return self.fail(&nodes.span(), "`nodes` is empty; expected one or more, or no `nodes`");
        }
        let mut found = Vec::new();
        for name in raw.node.iter().chain(listed) {
            found.extend(self.named(name)?);
        }
        found.sort_unstable();
        found.dedup();
        Ok(found)
    }
}

fn overlap(one: &Fault, other: &Fault) -> bool {
    // The end of the run may come later than the scenario says.
    let end = |fault: &Fault| fault.to.unwrap_or(Instant::MAX);
    one.from < end(other) && other.from < end(one)
}

/// The keys that a kind of fault takes; `None` if there is no such kind.
pub(super) fn fault_keys(kind: &str) -> Option<Vec<&'static str>> {
    let own: &[&str] = match kind {
        "bit_error" => &["rate", "bit", "frame", "node", "nodes"],
        "lost_frame" => &["rate", "id", "overrun", "node", "nodes"],
        "noise" => &["gap", "length", "node", "nodes"],
        "babble" => &["pull", "every"],
        "clock" => &["ppm", "node", "nodes"],
        "segment" => &["node", "nodes"],
        _ => return None,
    };
    Some([ANY_FAULT, own].concat())
}

pub(in crate::scenario) const FAULTS: &[&str] =
    &["bit_error", "lost_frame", "noise", "babble", "clock", "segment"];
const MOST_FAULTS: usize = 4096;
const FOR_GOOD: Duration = Duration::from_secs(1);
const ANY_FAULT: &[&str] = &["from", "to", "kind"];
