//! How busy the bus was over time, in memory that does not grow with the run.

use link_core::Instant;

/// Sums of time, in cells of equal length that begin at zero. When a run outgrows them, ten become one.
#[derive(Clone, Debug)]
pub(super) struct Load {
    /// The length of a cell, in nanoseconds.
    cell: u64,
    cells: Vec<Busy>,
}

/// What of a span the bus was not idle, in nanoseconds.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Busy {
    /// With frames, error frames, and attempts that were broken off.
    pub(super) all: u64,
    /// With error frames.
    pub(super) errors: u64,
}

impl Busy {
    fn add(&mut self, other: Self) {
        self.all += other.all;
        self.errors += other.errors;
    }
}

impl Default for Load {
    fn default() -> Self {
        Self { cell: SHORTEST, cells: Vec::new() }
    }
}

impl Load {
    /// The bus was not idle.
    pub(super) fn add(&mut self, from: Instant, to: Instant, is_error: bool) {
        let (mut from, to) = (from.as_nanos(), to.as_nanos());
        while to.saturating_sub(1) / self.cell >= MOST_CELLS {
            self.merge();
        }
        while from < to {
            let index = from / self.cell;
            let until = to.min((index + 1) * self.cell);
            let index = usize::try_from(index).unwrap_or(usize::MAX);
            if self.cells.len() <= index {
                self.cells.resize(index + 1, Busy::default());
            }
            let all = until - from;
            self.cells[index].add(Busy { all, errors: if is_error { all } else { 0 } });
            from = until;
        }
    }

    /// The same in at most so many slices, up to `end`: their length in nanoseconds, and what each has. Exact, because a
    /// slice is a number of cells.
    pub(super) fn slices(&self, end: Instant, most: u64) -> (u64, Vec<Busy>) {
        let cells_each = end.as_nanos().div_ceil(most).div_ceil(self.cell).max(1);
        let chunk = usize::try_from(cells_each).unwrap_or(usize::MAX);
        let length = cells_each * self.cell;
        let mut slices: Vec<Busy> = self.cells.chunks(chunk).map(sum).collect();
        slices
            .resize(usize::try_from(end.as_nanos().div_ceil(length)).unwrap_or(usize::MAX), Busy::default());
        (length, slices)
    }

    fn merge(&mut self) {
        self.cell *= 10;
        self.cells = self.cells.chunks(10).map(sum).collect();
    }
}

fn sum(cells: &[Busy]) -> Busy {
    let mut sum = Busy::default();
    cells.iter().for_each(|cell| sum.add(*cell));
    sum
}

/// The length of a cell at first, in nanoseconds: that of a bit at 1 Mbit/s.
const SHORTEST: u64 = 1_000;
const MOST_CELLS: u64 = 10_000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_are_exact() {
        let us = Instant::from_micros;
        let mut load = Load::default();
        load.add(us(0), us(500), false);
        load.add(us(1_500), us(2_250), true);
        load.add(us(399_999), us(400_000), false);
        let (length, slices) = load.slices(us(400_000), 400);
        assert_eq!((length, slices.len()), (1_000_000, 400));
        let micros: Vec<(u64, u64)> =
            slices.iter().map(|busy| (busy.all / 1_000, busy.errors / 1_000)).collect();
        assert_eq!(micros[..4], [(500, 0), (500, 500), (250, 250), (0, 0)]);
        assert_eq!(micros[399], (1, 0));
        // The bus is idle at the end.
        assert_eq!(load.slices(us(800_000), 400).1.len(), 400);
        assert_eq!(load.slices(us(800_000), 400).1[200], Busy::default());
    }

    /// A bus that is busy with frames and intermissions for a day, as far as that can be tried.
    #[test]
    fn a_long_run_needs_no_more_memory_than_a_short_one() {
        let mut load = Load::default();
        let (mut at, mut busy) = (Instant::ZERO, 0);
        while at < Instant::from_millis(86_400_000) {
            let (from, to) = (at, at + core::time::Duration::from_millis(70));
            load.add(from, to, false);
            busy += 70_000_000;
            at = to + core::time::Duration::from_millis(30);
        }
        assert!(load.cells.capacity() <= 2 * 10_000, "{}", load.cells.capacity());
        let (length, slices) = load.slices(at, 400);
        assert!(slices.len() > 200 && slices.len() <= 400, "{}", slices.len());
        assert_eq!(length % 10_000_000_000, 0, "a round length");
        assert_eq!(slices.iter().map(|busy| busy.all).sum::<u64>(), busy);
    }
}
