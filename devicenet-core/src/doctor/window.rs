//! A sum over the last span of time, which slides in ten steps.

use core::time::Duration;

use link_core::Instant;

/// Ten cells, each a tenth of the window.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Window {
    /// When the present cell began; `None` before the first.
    begin: Option<Instant>,
    cells: [u32; CELLS],
    present: u32,
    /// How many of the cells are of the present window.
    filled: usize,
}

impl Window {
    pub(super) const fn new() -> Self {
        Self { begin: None, cells: [0; CELLS], present: 0, filled: 0 }
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
                *last = core::mem::take(&mut self.present);
            }
            self.filled = self.filled.saturating_add(1).min(CELLS);
            begin += cell;
        }
        self.begin = Some(begin);
        true
    }

    pub(super) fn add(&mut self, value: u32) {
        self.present = self.present.saturating_add(value);
    }

    /// The sum of the last ten cells that have ended; `None` before there are ten.
    pub(super) fn whole(&self) -> Option<u64> {
        (self.filled == CELLS).then(|| self.cells.iter().copied().map(u64::from).sum())
    }

    /// The sum of the last ten cells and of the present one.
    pub(super) fn so_far(&self) -> u32 {
        self.cells.iter().fold(self.present, |sum, &cell| sum.saturating_add(cell))
    }
}

fn cell_of(span: Duration) -> Duration {
    span.checked_div(10).unwrap_or(span).max(SHORTEST)
}

const CELLS: usize = 10;
const SHORTEST: Duration = Duration::from_millis(1);
