//! Sums over the last span of time, which slides in ten steps.

use core::time::Duration;

use link_core::Instant;

/// Ten cells, each a tenth of the window, with `K` sums side by side.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Window<const K: usize = 1> {
    /// When the present cell began; `None` before the first.
    begin: Option<Instant>,
    cells: [[u32; K]; CELLS],
    present: [u32; K],
    /// How many of the cells are of the present window.
    filled: usize,
}

impl<const K: usize> Window<K> {
    pub(super) const fn new() -> Self {
        Self { begin: None, cells: [[0; K]; CELLS], present: [0; K], filled: 0 }
    }

    /// Moves on to `now`. True if a cell has ended since the last time.
    pub(super) fn advance(&mut self, now: Instant, span: Duration) -> bool {
        let cell = cell_of(span);
        let begin = *self.begin.get_or_insert(now);
        if now.saturating_since(begin) < cell {
            return false;
        }
        if now.saturating_since(begin) >= span.saturating_mul(2) {
            // Nothing of what was is in the window any more.
            *self = Self { begin: Some(now), filled: CELLS, ..Self::new() };
            return true;
        }
        let mut begin = begin;
        // At most twenty times.
        while now.saturating_since(begin) >= cell {
            self.cells.rotate_left(1);
            if let Some(last) = self.cells.last_mut() {
                *last = core::mem::replace(&mut self.present, [0; K]);
            }
            self.filled = self.filled.saturating_add(1).min(CELLS);
            begin += cell;
        }
        self.begin = Some(begin);
        true
    }

    /// Adds to one of the sums.
    pub(super) fn add(&mut self, which: usize, value: u32) {
        if let Some(sum) = self.present.get_mut(which) {
            *sum = sum.saturating_add(value);
        }
    }

    /// All of the last ten cells that have ended; `None` before there are ten.
    pub(super) fn whole(&self) -> Option<u64> {
        (self.filled == CELLS).then(|| self.cells.iter().flatten().copied().map(u64::from).sum())
    }

    /// The sums of the last ten cells and of the present one.
    pub(super) fn so_far(&self) -> [u32; K] {
        let mut sums = self.present;
        for cell in &self.cells {
            sums.iter_mut().zip(cell).for_each(|(sum, &value)| *sum = sum.saturating_add(value));
        }
        sums
    }
}

fn cell_of(span: Duration) -> Duration {
    span.checked_div(10).unwrap_or(span).max(SHORTEST)
}

const CELLS: usize = 10;
const SHORTEST: Duration = Duration::from_millis(1);
