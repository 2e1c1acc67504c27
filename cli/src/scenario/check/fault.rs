//! `[[fault]]`

use core::ops::Range;
use core::time::Duration;

use toml::Spanned;

use super::{Checker, list};
use crate::scenario::diagnostic::ScenarioError;
use crate::scenario::model::{Fault, FaultKind, NodeIndex};
use crate::scenario::raw::RawFault;

impl Checker<'_> {
    pub(super) fn fault(&self, table: &Spanned<RawFault>) -> Result<Fault, ScenarioError> {
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
            "bit_error" => {
                only(&["rate", "node", "nodes"])?;
                let rate = self.required(raw.rate.as_ref(), table, "`rate`, the probability per bit,")?;
                Ok(FaultKind::BitError { rate: self.probability(rate)?, nodes: self.fault_nodes(raw)? })
            }
            "lost_frame" => {
                only(&["rate", "node", "nodes"])?;
                let rate = raw.rate.as_ref().map(|rate| self.probability(rate)).transpose()?.unwrap_or(1.0);
                Ok(FaultKind::LostFrame { rate, nodes: self.some_nodes(raw, table)? })
            }
            "noise" => only(&[]).map(|()| FaultKind::Noise),
            "babble" => {
                only(&["frame", "period"])?;
                let frame =
                    self.frame(self.required(raw.frame.as_ref(), table, "`frame`, what is sent,")?)?;
                let period = raw.period.as_ref().map_or(Duration::ZERO, |period| period.get_ref().0);
                Ok(FaultKind::Babble { frame, period })
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

const FAULTS: &[&str] = &["bit_error", "lost_frame", "noise", "babble", "clock", "segment"];
const ANY_FAULT: &[&str] = &["from", "to", "kind"];
