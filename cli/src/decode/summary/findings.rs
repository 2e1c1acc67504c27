//! What is wrong with a bus, and what to check next.

use core::fmt;

use devicenet_core::MacId;
use devicenet_core::doctor::{Doctor, Finding};
use link_core::Instant;
use serde::Serialize;

use crate::text::push_seconds;
use crate::verdict::{self, Seen, Verdict};

/// The findings of the doctor of a bus.
#[derive(Debug, Default)]
pub(super) struct Findings {
    found: Vec<Finding>,
    /// Decimals of a second that the recording gives.
    digits: u8,
    /// Findings for which there was no room.
    forgotten: u64,
}

impl Findings {
    /// Those of a node, or of all, that lasted at some time of a span.
    pub(super) fn of(doctor: &Doctor, digits: u8, mac: Option<u8>, span: (Instant, Instant)) -> Self {
        let is_shown = |finding: &&Finding| {
            let is_node = mac.is_none_or(|mac| finding.node.map(MacId::number) == Some(mac));
            is_node && finding.since <= span.1 && finding.until.is_none_or(|until| until >= span.0)
        };
        let found = doctor.findings().filter(is_shown).copied().collect();
        Self { found, digits, forgotten: verdict::forgotten(doctor) }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.found.is_empty() && self.forgotten == 0
    }

    pub(super) fn verdict(&self, seen: Seen) -> Verdict {
        Verdict::new(&self.found, self.forgotten, seen)
    }

    pub(super) fn records<'a>(&'a self, channel: &'a str) -> impl Iterator<Item = Record<'a>> {
        self.found.iter().map(move |finding| Record { summary: "finding", channel, finding })
    }

    /// Of those that were found, but not kept.
    pub(super) fn forgotten<'a>(&self, channel: &'a str) -> Option<Forgotten<'a>> {
        let forgotten = Forgotten { summary: "findings_forgotten", channel, count: self.forgotten };
        (self.forgotten > 0).then_some(forgotten)
    }
}

/// Two lines each: what is wrong, and what to check next; the worst first.
impl fmt::Display for Findings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut found: Vec<&Finding> = self.found.iter().collect();
        found.sort_by_key(|finding| core::cmp::Reverse(finding.severity));
        for finding in found {
            let code =
                finding.scanner_status().map_or_else(String::new, |status| format!(", code {}", status.0));
            let frames: Vec<String> = finding.evidence.frames().iter().map(ToString::to_string).collect();
            let frames = match &*frames {
                [] => String::new(),
                [one] => format!(", frame {one}"),
                some => format!(", frames {}", some.join(" ")),
            };
            let since = time(finding.since, self.digits);
            let until = finding
                .until
                .map_or_else(String::new, |until| format!(" until {}", time(until, self.digits)));
            writeln!(f, "{:7}  {finding}", finding.severity)?;
            writeln!(f, "         since {since}{until}{frames}{code}")?;
            writeln!(f, "         {}", finding.advice())?;
        }
        if self.forgotten > 0 {
            writeln!(f, "{} more were found, for which there was no room", self.forgotten)?;
        }
        Ok(())
    }
}

/// One line of the JSON summary; times in seconds, as those of the frames.
#[derive(Serialize)]
pub(super) struct Record<'a> {
    summary: &'static str,
    channel: &'a str,
    #[serde(flatten)]
    finding: &'a Finding,
}

/// The last line of the JSON summary, where findings were given up for others.
#[derive(Serialize)]
pub(super) struct Forgotten<'a> {
    summary: &'static str,
    channel: &'a str,
    count: u64,
}

fn time(at: Instant, digits: u8) -> String {
    let mut text = Vec::new();
    push_seconds(&mut text, at, digits);
    String::from_utf8_lossy(&text).into_owned()
}
