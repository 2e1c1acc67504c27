//! `[[fault]]`

use core::ops::Range;
use core::time::Duration;

use toml::Spanned;

use super::{Checker, list};
use crate::scenario::diagnostic::ScenarioError;
use crate::scenario::model::{Fault, FaultKind, NodeIndex};
use crate::scenario::raw::RawFault;

impl Checker<'_> {
    /// All of them: the bus can be split in two, not in three.
    pub(super) fn faults(&self, tables: &[Spanned<RawFault>]) -> Result<Vec<Fault>, ScenarioError> {
        let mut faults: Vec<Fault> = Vec::new();
        for table in tables {
            let fault = self.fault(table)?;
            let splits = |fault: &Fault| matches!(fault.kind, FaultKind::Segment { .. });
            let end = |fault: &Fault| fault.to.unwrap_or(self.end);
            let overlaps = |other: &Fault| other.from < end(&fault) && fault.from < end(other);
            if splits(&fault) && faults.iter().any(|other| splits(other) && overlaps(other)) {
                return self.fail(
                    &table.span(),
                    "there is another segment at this time; expected one after the other, with all its nodes in one",
                );
            }
            faults.push(fault);
        }
        Ok(faults)
    }

    fn fault(&self, table: &Spanned<RawFault>) -> Result<Fault, ScenarioError> {
        let (raw, span) = (table.get_ref(), table.span());
        let from = match &raw.from {
            Some(from) => self.moment("from", from)?,
            None => link_core::Instant::ZERO,
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
        let only = |own: &[&str]| {
            let keys = [ANY_FAULT, own].concat();
            self.only(raw, &keys, &format!("the fault `{}`", kind.get_ref()))
        };
        match kind.get_ref().as_str() {
            "bit_error" if raw.bit.is_some() => {
                only(&["frame", "bit", "node", "nodes"])?;
                Ok(FaultKind::BitError {
                    frame: match &raw.frame {
                        Some(frame) => {
                            self.number("frame", frame, 0, i64::MAX, "the number of a frame, from 0")?
                        }
                        None => 0,
                    },
                    bit: self.number(
                        "bit",
                        self.required(raw.bit.as_ref(), table, "`bit`")?,
                        0,
                        159,
                        "the number of a bit, 0 to 159",
                    )?,
                    nodes: self.fault_nodes(raw)?,
                })
            }
            "bit_error" => {
                only(&["rate", "node", "nodes"])?;
                let rate =
                    self.required(raw.rate.as_ref(), table, "`rate` per bit, or `bit` of one frame,")?;
                Ok(FaultKind::BitErrors { rate: self.probability(rate)?, nodes: self.fault_nodes(raw)? })
            }
            "lost_frame" => {
                only(&["rate", "id", "overrun", "node", "nodes"])?;
                Ok(FaultKind::LostFrame {
                    rate: raw.rate.as_ref().map(|rate| self.probability(rate)).transpose()?.unwrap_or(1.0),
                    id: match &raw.id {
                        Some(id) => {
                            Some(self.number("id", id, 0, 0x7FF, "an 11-bit identifier, 0 to 0x7FF")?)
                        }
                        None => None,
                    },
                    overrun: raw.overrun.as_ref().is_some_and(|flag| *flag.get_ref()),
                    nodes: self.some_nodes(raw, table)?,
                })
            }
            "noise" => {
                only(&["gap", "length", "node", "nodes"])?;
                let gap = self.required(raw.gap.as_ref(), table, "`gap`, the mean time between bursts,")?;
                let length = self.required(raw.length.as_ref(), table, "`length` of a burst")?;
                Ok(FaultKind::Noise {
                    gap: gap.get_ref().0,
                    length: length.get_ref().0,
                    nodes: self.fault_nodes(raw)?,
                })
            }
            "babble" => {
                only(&["pull", "every"])?;
                let pull = raw.pull.as_ref().map_or(FOR_GOOD, |pull| pull.get_ref().0);
                Ok(FaultKind::Babble {
                    pull,
                    every: raw.every.as_ref().map_or(pull, |every| every.get_ref().0),
                })
            }
            "clock" => {
                only(&["ppm", "node", "nodes"])?;
                let ppm = self.required(raw.ppm.as_ref(), table, "`ppm`, how much the clock is off,")?;
                Ok(FaultKind::Clock { ppm: self.ppm("ppm", ppm)?, nodes: self.some_nodes(raw, table)? })
            }
            "segment" => {
                only(&["node", "nodes"])?;
                Ok(FaultKind::Segment { nodes: self.some_nodes(raw, table)? })
            }
            other => {
                self.fail(&kind.span(), format!("there is no fault `{other}`; expected {}", list(FAULTS)))
            }
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
        let listed = raw.nodes.as_ref().map(|nodes| nodes.get_ref().as_slice()).unwrap_or_default();
        let mut found = Vec::new();
        for name in raw.node.iter().chain(listed) {
            found.extend(self.named(name)?);
        }
        found.sort_unstable();
        found.dedup();
        Ok(found)
    }
}

pub(in crate::scenario) const FAULTS: &[&str] =
    &["bit_error", "lost_frame", "noise", "babble", "clock", "segment"];
const FOR_GOOD: Duration = Duration::from_secs(1);
const ANY_FAULT: &[&str] = &["from", "to", "kind"];
