//! Which problems a bus has: of each kind how many, and the first.

use devicenet_core::doctor::Severity;
use link_core::Instant;
use serde::Serialize;

use crate::decode::meaning::Meaning;
use crate::recording::RecordedFrame;
use crate::table::{Cell, Table};
use crate::text::{seconds, seconds_number, seconds_since};

/// One entry for each kind of problem, of which there is a fixed number.
#[derive(Debug, Default)]
pub(in crate::decode) struct Problems(Vec<Entry>);

#[derive(Debug)]
struct Entry {
    code: &'static str,
    severity: Severity,
    count: u64,
    first: First,
}

/// The first frame with a problem of a kind.
#[derive(Debug)]
struct First {
    n: u64,
    at: Instant,
    /// Decimals of a second that the recording gives.
    digits: u8,
    words: String,
}

impl Problems {
    /// Counts the problem of a frame, if it has one.
    #[inline]
    pub(super) fn observe(&mut self, frame: &RecordedFrame, meaning: &Meaning<'_>) {
        if let Some(code) = meaning.problem_code() {
            self.add((code, meaning.severity()), (frame.n, frame.at, frame.digits), || meaning.problem());
        }
    }

    /// Counts a problem of a kind, of the frame with this number, time, and decimals of a second.
    #[cold]
    pub(in crate::decode) fn add(
        &mut self,
        (code, severity): (&'static str, Severity),
        (n, at, digits): (u64, Instant, u8),
        words: impl FnOnce() -> String,
    ) {
        if let Some(entry) = self.0.iter_mut().find(|entry| entry.code == code) {
            entry.count += 1;
            return;
        }
        self.0.push(Entry { code, severity, count: 1, first: First { n, at, digits, words: words() } });
    }

    pub(in crate::decode) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Frames that break the protocol.
    pub(in crate::decode) fn faulty(&self) -> u64 {
        let faulty = self.0.iter().filter(|entry| entry.severity > Severity::Info);
        faulty.map(|entry| entry.count).sum()
    }

    /// The most frequent first; equally frequent ones as they came.
    fn sorted(&self) -> Vec<&Entry> {
        let mut entries: Vec<_> = self.0.iter().collect();
        entries.sort_by_key(|entry| core::cmp::Reverse(entry.count));
        entries
    }

    /// With times as they are recorded, or since a moment.
    pub(in crate::decode) fn table(&self, origin: Option<Instant>) -> Table {
        let mut table =
            Table::new(&["problem", "severity", "frames", "first frame", "first time", "first in words"]);
        for Entry { code, severity, count, first } in self.sorted() {
            let time = match origin {
                Some(origin) => seconds_since(origin, first.at, first.digits),
                None => seconds(first.at, first.digits),
            };
            table.row(vec![
                Cell::left(*code),
                Cell::left(severity.name()),
                Cell::right(count.to_string()),
                Cell::right(first.n.to_string()),
                Cell::right(time),
                Cell::left(first.words.clone()),
            ]);
        }
        table
    }

    pub(in crate::decode) fn records<'a>(&'a self, channel: &'a str) -> impl Iterator<Item = Record<'a>> {
        self.sorted().into_iter().map(move |Entry { code, severity, count, first }| Record {
            summary: "problem",
            channel,
            problem: code,
            severity: *severity,
            frames: *count,
            first: FirstRecord { n: first.n, t: seconds_number(first.at, first.digits), text: &first.words },
        })
    }
}

/// One line of the JSON summary.
#[derive(Serialize)]
pub(in crate::decode) struct Record<'a> {
    summary: &'static str,
    channel: &'a str,
    problem: &'static str,
    severity: Severity,
    frames: u64,
    first: FirstRecord<'a>,
}

/// Number, time in seconds and problem of a frame.
#[derive(Serialize)]
struct FirstRecord<'a> {
    n: u64,
    t: f64,
    text: &'a str,
}
