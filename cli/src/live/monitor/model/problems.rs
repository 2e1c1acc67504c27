//! Which problems frames have had.

use core::fmt;

use devicenet_core::doctor::Severity;

/// How many frames have had each kind of problem, of which there is a fixed number.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub(in crate::live::monitor) struct Problems(Vec<ProblemCount>);

/// Frames with a kind of problem.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(in crate::live::monitor) struct ProblemCount {
    /// A stable name.
    pub(in crate::live::monitor) code: &'static str,
    pub(in crate::live::monitor) severity: Severity,
    pub(in crate::live::monitor) frames: u64,
}

impl Problems {
    pub(super) fn add(&mut self, code: &'static str, severity: Severity) {
        match self.0.iter_mut().find(|count| count.code == code) {
            Some(count) => count.frames += 1,
            None => self.0.push(ProblemCount { code, severity, frames: 1 }),
        }
    }

    /// Frames that break the protocol.
    pub(super) fn faulty(&self) -> u64 {
        let faulty = self.0.iter().filter(|count| count.severity > Severity::Info);
        faulty.map(|count| count.frames).sum()
    }

    /// The worst first, of equal ones the most frequent.
    pub(in crate::live::monitor) fn sorted(&self) -> Vec<&ProblemCount> {
        let mut counts: Vec<&ProblemCount> = self.0.iter().collect();
        counts.sort_by_key(|count| core::cmp::Reverse((count.severity, count.frames)));
        counts
    }
}

/// `1 x reserved_bits (warning), 3 x poll_unanswered (info)`
impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, ProblemCount { code, severity, frames }) in self.sorted().into_iter().enumerate() {
            let separator = if index > 0 { ", " } else { "" };
            write!(f, "{separator}{frames} x {code} ({severity})")?;
        }
        Ok(())
    }
}
