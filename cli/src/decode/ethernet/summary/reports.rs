//! What nodes report of themselves, and why the managing node resets them.

use std::collections::BTreeMap;

use link_core::Instant;
use powerlink_core::monitor::Reading;
use powerlink_core::wire::{Body, ErrorCode};
use serde_json::{Value, json};

use crate::table::{Cell, Table};
use crate::text::{seconds_number, seconds_since};

/// Each error of a node, with the frame that told it first.
#[derive(Debug, Default)]
pub(super) struct Reports {
    told: BTreeMap<Report, Told>,
    /// For which there was no more room.
    others: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Report {
    node: u8,
    by: By,
    code: ErrorCode,
}

/// Who tells it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum By {
    /// The node, in a StatusResponse.
    Node,
    /// The managing node, which resets it.
    ManagingNode,
}

#[derive(Debug)]
struct Told {
    count: u64,
    first: u64,
    at: Instant,
    /// Decimals of a second that the recording gives.
    digits: u8,
}

impl Reports {
    pub(super) fn observe(&mut self, digits: u8, reading: &Reading<'_>) {
        match &reading.body {
            Some(Body::StatusResponse(status)) => {
                let errors = status.errors().filter(|entry| !entry.kind.is_cleared());
                errors.for_each(|entry| self.add(digits, reading, (reading.src, By::Node, entry.code)));
            }
            Some(Body::NmtCommand(command)) => {
                if let Some(code) = command.reason() {
                    self.add(digits, reading, (reading.dst, By::ManagingNode, code));
                }
            }
            _ => {}
        }
    }

    #[cold]
    fn add(
        &mut self,
        digits: u8,
        reading: &Reading<'_>,
        (node, by, code): (Option<powerlink_core::NodeId>, By, ErrorCode),
    ) {
        let Some(node) = node else { return };
        let report = Report { node: node.0, by, code };
        if let Some(told) = self.told.get_mut(&report) {
            told.count += 1;
        } else if self.told.len() < MOST {
            self.told.insert(report, Told { count: 1, first: reading.n, at: reading.at, digits });
        } else {
            self.others += 1;
        }
    }

    /// How many different ones there were.
    pub(super) fn count(&self) -> u64 {
        self.told.len() as u64 + self.others
    }

    /// With times since the begin of the capture.
    pub(super) fn table(&self, origin: Instant) -> Table {
        let mut table = Table::new(&["node", "error", "told by", "times", "first frame", "first time"]);
        for (Report { node, by, code }, Told { count, first, at, digits }) in &self.told {
            table.row(vec![
                Cell::right(node.to_string()),
                Cell::left(words(*code)),
                Cell::left(by.words()),
                Cell::right(count.to_string()),
                Cell::right(first.to_string()),
                Cell::right(seconds_since(origin, *at, *digits)),
            ]);
        }
        if self.others > 0 {
            let none = || Cell::left("-");
            table.row(vec![
                Cell::right("-"),
                Cell::left("others"),
                none(),
                Cell::right(self.others.to_string()),
            ]);
        }
        table
    }

    pub(super) fn records(&self) -> impl Iterator<Item = Value> {
        let told = self.told.iter().map(|(Report { node, by, code }, Told { count, first, at, digits })| {
            let mut record = json!({
                "node": node, "error": code, "by": by.name(), "count": count,
                "first": { "n": first, "t": seconds_number(*at, *digits) },
            });
            if let Some(name) = code.name() {
                record["error_name"] = name.into();
            }
            record
        });
        told.chain((self.others > 0).then(|| json!({ "count": self.others })))
    }
}

impl By {
    const fn words(self) -> &'static str {
        match self {
            Self::Node => "the node",
            Self::ManagingNode => "MN, which resets it",
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Node => "node",
            Self::ManagingNode => "managing_node",
        }
    }
}

/// `0x8245 loss of SoC threshold`
fn words(code: ErrorCode) -> String {
    match code.name() {
        Some(name) => format!("0x{:04X} {name}", code.0),
        None => format!("0x{:04X}", code.0),
    }
}

/// Every node with a dozen.
const MOST: usize = 4096;
