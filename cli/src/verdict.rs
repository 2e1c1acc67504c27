//! Whether a bus is healthy: one rule, for the screen, for lines, for summaries, and for the exit code.
//!
//! | State | When | Exit code |
//! |---|---|---|
//! | `wrong` | an error or a warning lasts | 1 |
//! | `was_wrong` | none lasts, but there was one, or a frame that breaks the protocol | 1 |
//! | `unread` | nothing was wrong in what could be read | 1 |
//! | `silent` | there was no frame | 0 |
//! | `healthy` | none of these | 0 |
//!
//! What is only worth knowing, which is a finding or the problem of a frame of the severity `info`, is counted and shown, and changes
//! nothing.

use core::fmt;

use devicenet_core::doctor::{Doctor, Finding, Severity};
use serde::Serialize;

use crate::text::count;

/// What is to be said of a bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize)]
pub(crate) struct Verdict {
    state: State,
    /// Findings that last.
    errors: u64,
    warnings: u64,
    infos: u64,
    /// Errors and warnings that are over, and findings that there was no room for.
    over: u64,
    /// Frames that break the protocol.
    faulty_frames: u64,
    /// Lines or records that could not be read.
    unread: u64,
}

/// The verdict in a word.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum State {
    Wrong,
    WasWrong,
    Unread,
    #[default]
    Silent,
    Healthy,
}

/// What is counted besides findings.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(crate) struct Seen {
    /// Frames of any kind, error frames included.
    pub(crate) frames: u64,
    pub(crate) faulty_frames: u64,
    pub(crate) unread: u64,
}

impl Verdict {
    /// Of some of the findings of a doctor.
    pub(crate) fn new<'a>(
        findings: impl IntoIterator<Item = &'a Finding>,
        forgotten: u64,
        seen: Seen,
    ) -> Self {
        let Seen { frames, faulty_frames, unread } = seen;
        let mut verdict = Self { over: forgotten, faulty_frames, unread, ..Self::default() };
        for finding in findings {
            match (finding.severity, finding.is_over()) {
                (Severity::Error, false) => verdict.errors += 1,
                (Severity::Warning, false) => verdict.warnings += 1,
                (Severity::Info, false) => verdict.infos += 1,
                (Severity::Error | Severity::Warning, true) => verdict.over += 1,
                (Severity::Info, true) => {}
            }
        }
        verdict.state = if verdict.errors + verdict.warnings > 0 {
            State::Wrong
        } else if verdict.over + faulty_frames > 0 {
            State::WasWrong
        } else if unread > 0 {
            State::Unread
        } else if frames == 0 {
            State::Silent
        } else {
            State::Healthy
        };
        verdict
    }

    /// Of all that a doctor has found.
    pub(crate) fn of(doctor: &Doctor, seen: Seen) -> Self {
        Self::new(doctor.findings(), forgotten(doctor), seen)
    }

    pub(crate) const fn state(&self) -> State {
        self.state
    }

    /// The worst severity that lasts, or lasted.
    pub(crate) const fn severity(&self) -> Option<Severity> {
        match self.state {
            State::Wrong if self.errors > 0 => Some(Severity::Error),
            State::Wrong | State::WasWrong | State::Unread => Some(Severity::Warning),
            State::Silent | State::Healthy => None,
        }
    }

    /// Whether the exit code is 1.
    pub(crate) const fn is_bad(&self) -> bool {
        match self.state {
            State::Wrong | State::WasWrong | State::Unread => true,
            State::Silent | State::Healthy => false,
        }
    }

    /// In so many columns, if it can be said in them: `1 error, 2 warnings, 3 over`, or the first of that. There is always one word.
    pub(crate) fn fit(&self, width: usize) -> String {
        let parts = self.parts(false);
        let mut kept = (1..=parts.len()).rev().map(|most| parts[..most].join(", "));
        kept.clone().find(|words| words.chars().count() <= width).or(kept.next_back()).unwrap_or_default()
    }

    /// The most important first.
    fn parts(&self, is_long: bool) -> Vec<String> {
        let over = if is_long {
            format!("{} over", count(self.over, "finding"))
        } else {
            format!("{} over", self.over)
        };
        let unread = match (is_long, self.unread) {
            (true, 1) => "1 line or record not read".to_owned(),
            (true, number) => format!("{number} lines or records not read"),
            (false, number) => format!("{number} unread"),
        };
        let word = match self.state {
            State::Wrong | State::WasWrong | State::Unread => None,
            State::Silent => Some("silent"),
            State::Healthy => Some("healthy"),
        };
        let counted = [
            (self.errors, count(self.errors, "error")),
            (self.warnings, count(self.warnings, "warning")),
            (self.over, over),
            (self.faulty_frames, count(self.faulty_frames, "faulty frame")),
            (self.unread, unread),
            (self.infos, count(self.infos, "info")),
        ];
        let counted = counted.into_iter().filter(|(number, _)| *number > 0).map(|(_, words)| words);
        word.map(str::to_owned).into_iter().chain(counted).collect()
    }
}

/// Findings that were found, but not kept.
pub(crate) fn forgotten(doctor: &Doctor) -> u64 {
    doctor.forgotten().past + doctor.forgotten().present
}

/// In full: `healthy`, `1 error, 2 warnings, 3 findings over`, `silent: no frame was heard`.
impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.parts(true).join(", "))?;
        if self.state == State::Silent { f.write_str(": no frame was heard") } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use devicenet_core::MacId;
    use devicenet_core::doctor::DoctorConfig;
    use link_core::{Instant, LinkEvent};

    use super::*;

    fn verdict(events: &[(u8, LinkEvent)], seen: Seen) -> (State, bool, String) {
        let mut doctor = Box::new(Doctor::new(DoctorConfig::default()));
        for (index, (mac, event)) in (0..).zip(events) {
            doctor.link_of(MacId::new(*mac), Instant::from_millis(index), None, *event);
        }
        let verdict = Verdict::of(&doctor, seen);
        (verdict.state(), verdict.is_bad(), verdict.to_string())
    }

    const FRAMES: Seen = Seen { frames: 9, faulty_frames: 0, unread: 0 };

    #[test]
    fn what_lasts_comes_before_what_is_over() {
        use LinkEvent::{BusOff, ErrorPassive, Up};
        let ill = [(1, BusOff), (2, ErrorPassive), (3, ErrorPassive), (4, BusOff), (4, Up)];
        assert_eq!(verdict(&ill, FRAMES), (State::Wrong, true, "1 error, 2 warnings, 1 finding over".into()));
        assert_eq!(verdict(&ill[3..], FRAMES), (State::WasWrong, true, "1 finding over".into()));
        assert_eq!(verdict(&[], FRAMES), (State::Healthy, false, "healthy".into()));
    }

    #[test]
    fn frames_that_were_not_read_and_frames_that_were_not_there() {
        let seen = |frames, faulty_frames, unread| verdict(&[], Seen { frames, faulty_frames, unread });
        assert_eq!(seen(0, 0, 0), (State::Silent, false, "silent: no frame was heard".into()));
        assert_eq!(seen(0, 0, 1), (State::Unread, true, "1 line or record not read".into()));
        assert_eq!(seen(0, 0, 2), (State::Unread, true, "2 lines or records not read".into()));
        assert_eq!(seen(3, 1, 0), (State::WasWrong, true, "1 faulty frame".into()));
    }

    #[test]
    fn the_first_is_said_where_there_is_room_for_no_more() {
        use LinkEvent::{BusOff, ErrorPassive, Up};
        let mut doctor = Box::new(Doctor::new(DoctorConfig::default()));
        for (mac, event) in [(1, BusOff), (2, ErrorPassive), (3, BusOff), (3, Up)] {
            doctor.link_of(MacId::new(mac), Instant::ZERO, None, event);
        }
        let verdict = Verdict::of(&doctor, FRAMES);
        assert_eq!(
            [30, 20, 8, 1].map(|width| verdict.fit(width)),
            ["1 error, 1 warning, 1 over", "1 error, 1 warning", "1 error", "1 error"]
        );
    }
}
