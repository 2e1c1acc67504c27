//! What is known of all slaves without looking at each.
//!
//! A master of 63 slaves handles a frame of one of them. What it asks of all (who has something to send, who is polled, whose
//! wait is over next) is noted for each slave after it was touched, in one bit or one instant, so that a frame costs about
//! the same with 63 slaves as with one.

use core::hash::{Hash, Hasher};
use core::time::Duration;

use heapless::Vec;
use link_core::{Deadline, Instant};

use super::cycle::takes_part;
use super::scan_list::{IoInstance, ScanRate};
use super::set::SlaveSet;
use super::slot::{Sending, Slot};
use super::state::Stage;
use super::status::ScannerStatus;
use crate::id::MacId;

/// What is noted of the slaves, whose list it is given with every question. They are in the order of their MAC IDs, and are
/// changed through it only.
#[derive(Clone, Debug)]
pub(super) struct Board<const SLAVES: usize> {
    listed: SlaveSet,
    now: Instant,
    /// Slaves of which what follows may no longer be true.
    touched: SlaveSet,
    known: [SlaveSet; Known::COUNT],
    /// The next deadline of each slave that was not touched, in their order; [`Instant::MAX`]: none.
    next: Vec<Instant, SLAVES>,
    /// None of them is earlier.
    bound: Instant,
}

/// What is known of each slave.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Known {
    /// It has events, or has lost some.
    HasEvents,
    /// An acknowledge or output data outside of the scan are due.
    HasAnswer,
    /// Its conversation has a frame.
    HasRequest,
    /// It answers, and is brought up.
    IsConfigured,
    IsRunning,
    /// It stopped communicating.
    IsLost,
    IsStrobed,
    IsPolledInGroup,
    IsPolled,
    /// Polled in some scans only.
    IsBackground,
}

/// The slaves with what is known of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct View<'a, const SLAVES: usize, const MESSAGE: usize> {
    board: &'a Board<SLAVES>,
    list: &'a [Slot<MESSAGE>],
}

impl<'a, const SLAVES: usize, const MESSAGE: usize> View<'a, SLAVES, MESSAGE> {
    pub(super) const fn new(board: &'a Board<SLAVES>, list: &'a [Slot<MESSAGE>]) -> Self {
        Self { board, list }
    }

    /// The slaves of which that is true.
    pub(super) fn with(self, what: Known) -> SlaveSet {
        self.board.with(self.list, what)
    }
}

/// Why a slave was not added.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum NotAdded {
    Listed,
    Full,
}

impl<const SLAVES: usize> Board<SLAVES> {
    pub(super) const fn new() -> Self {
        Self {
            listed: SlaveSet::EMPTY,
            now: Instant::ZERO,
            touched: SlaveSet::EMPTY,
            known: [SlaveSet::EMPTY; Known::COUNT],
            next: Vec::new(),
            bound: Instant::MAX,
        }
    }

    /// Those that are in the scan list.
    pub(super) const fn listed(&self) -> SlaveSet {
        self.listed
    }

    pub(super) fn get<'a, const N: usize>(&self, list: &'a [Slot<N>], slave: MacId) -> Option<&'a Slot<N>> {
        list.get(self.place(slave)?)
    }

    pub(super) fn get_mut<'a, const N: usize>(
        &mut self,
        list: &'a mut [Slot<N>],
        slave: MacId,
    ) -> Option<&'a mut Slot<N>> {
        let place = self.place(slave)?;
        self.touched.insert(slave);
        if let Some(next) = self.next.get_mut(place) {
            *next = Instant::MAX;
        }
        let slot = list.get_mut(place)?;
        slot.timers.advance(self.now);
        Some(slot)
    }

    pub(super) fn all_mut<'a, const N: usize>(
        &mut self,
        list: &'a mut [Slot<N>],
    ) -> core::slice::IterMut<'a, Slot<N>> {
        self.touched = self.listed;
        self.next.iter_mut().for_each(|next| *next = Instant::MAX);
        for slot in list.iter_mut() {
            slot.timers.advance(self.now);
        }
        list.iter_mut()
    }

    pub(super) fn add<const N: usize>(
        &mut self,
        list: &mut Vec<Slot<N>, SLAVES>,
        mut slot: Slot<N>,
    ) -> Result<(), NotAdded> {
        let slave = slot.entry.mac_id;
        if self.listed.contains(slave) {
            return Err(NotAdded::Listed);
        }
        slot.timers.advance(self.now);
        let place = self.listed.rank(slave);
        list.insert(place, slot).map_err(|_| NotAdded::Full)?;
        let noted = self.next.insert(place, Instant::MAX);
        debug_assert!(noted.is_ok(), "both have room for as many");
        self.listed.insert(slave);
        self.touched.insert(slave);
        Ok(())
    }

    /// Removes a slave; false if there is none.
    pub(super) fn remove<const N: usize>(&mut self, list: &mut Vec<Slot<N>, SLAVES>, slave: MacId) -> bool {
        let Some(place) = self.place(slave) else { return false };
        list.remove(place);
        self.next.remove(place);
        self.listed.remove(slave);
        self.touched.remove(slave);
        for set in &mut self.known {
            set.remove(slave);
        }
        true
    }

    pub(super) fn advance(&mut self, now: Instant) {
        self.now = now;
    }

    pub(super) fn shift<const N: usize>(&mut self, list: &mut [Slot<N>], span: Duration) {
        for slot in self.all_mut(list) {
            slot.timers.shift(span);
        }
        self.now = self.now.saturating_sub(span);
    }

    /// The slaves of which that is true.
    pub(super) fn with<const N: usize>(&self, list: &[Slot<N>], what: Known) -> SlaveSet {
        let known = self.known.get(what.index()).copied().unwrap_or_default();
        let mut set = known.difference(self.touched);
        for slave in self.touched {
            if self.get(list, slave).is_some_and(|slot| what.is_true_of(slot)) {
                set.insert(slave);
            }
        }
        set
    }

    /// The next wait of any slave that will be over.
    pub(super) fn deadline<const N: usize>(&self, list: &[Slot<N>]) -> Option<Deadline> {
        let mut first: Option<(MacId, Instant)> = None;
        for (slave, &at) in self.listed.zip(&self.next) {
            if at < first.map_or(Instant::MAX, |(_, at)| at) {
                first = Some((slave, at));
            }
        }
        let noted = first.and_then(|(slave, _)| self.get(list, slave)).and_then(|slot| slot.timers.next());
        let touched = self.touched.filter_map(|slave| self.get(list, slave)?.timers.next());
        touched.chain(noted).min_by_key(|deadline| deadline.at)
    }

    /// The slaves that have a wait that is over at `until`.
    pub(super) fn due<const N: usize>(&mut self, list: &[Slot<N>], until: Instant) -> SlaveSet {
        self.settle(list);
        let mut due = SlaveSet::EMPTY;
        if self.bound > until {
            return due;
        }
        self.bound = Instant::MAX;
        for (slave, &at) in self.listed.zip(&self.next) {
            self.bound = self.bound.min(at);
            if at <= until && at != Instant::MAX {
                due.insert(slave);
            }
        }
        due
    }

    /// Notes what has become of the slaves that were touched.
    pub(super) fn settle<const N: usize>(&mut self, list: &[Slot<N>]) {
        for slave in core::mem::take(&mut self.touched) {
            let Some(place) = self.place(slave) else { continue };
            let Some(slot) = list.get(place) else { continue };
            for (set, what) in self.known.iter_mut().zip(Known::ALL) {
                if what.is_true_of(slot) {
                    set.insert(slave);
                } else {
                    set.remove(slave);
                }
            }
            let at = slot.timers.next().map_or(Instant::MAX, |deadline| deadline.at);
            self.bound = self.bound.min(at);
            if let Some(next) = self.next.get_mut(place) {
                *next = at;
            }
        }
    }

    fn place(&self, slave: MacId) -> Option<usize> {
        self.listed.contains(slave).then(|| self.listed.rank(slave))
    }
}

impl Known {
    const ALL: [Self; 10] = [
        Self::HasEvents,
        Self::HasAnswer,
        Self::HasRequest,
        Self::IsConfigured,
        Self::IsRunning,
        Self::IsLost,
        Self::IsStrobed,
        Self::IsPolledInGroup,
        Self::IsPolled,
        Self::IsBackground,
    ];
    const COUNT: usize = Self::ALL.len();

    const fn index(self) -> usize {
        match self {
            Self::HasEvents => 0,
            Self::HasAnswer => 1,
            Self::HasRequest => 2,
            Self::IsConfigured => 3,
            Self::IsRunning => 4,
            Self::IsLost => 5,
            Self::IsStrobed => 6,
            Self::IsPolledInGroup => 7,
            Self::IsPolled => 8,
            Self::IsBackground => 9,
        }
    }

    fn is_true_of<const N: usize>(self, slot: &Slot<N>) -> bool {
        match self {
            Self::HasEvents => !slot.events.is_empty() || slot.events_lost != 0,
            Self::HasAnswer => slot.acknowledge_due || matches!(slot.output.sending, Sending::Due(_)),
            Self::HasRequest => slot.conversation.has_output(),
            Self::IsConfigured => matches!(slot.stage, Stage::Configuring(_)),
            Self::IsRunning => slot.is_running(),
            Self::IsLost => slot.status == ScannerStatus::STOPPED_COMMUNICATING,
            Self::IsStrobed => takes_part(slot, IoInstance::BitStrobe),
            Self::IsPolledInGroup => takes_part(slot, IoInstance::MulticastPoll),
            Self::IsPolled => takes_part(slot, IoInstance::Poll),
            Self::IsBackground => slot.entry.rate == ScanRate::Background,
        }
    }
}

/// What is noted of the slaves follows from them.
impl<const SLAVES: usize> PartialEq for Board<SLAVES> {
    fn eq(&self, other: &Self) -> bool {
        (self.listed, self.now) == (other.listed, other.now)
    }
}

impl<const SLAVES: usize> Eq for Board<SLAVES> {}

impl<const SLAVES: usize> Hash for Board<SLAVES> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        (self.listed, self.now).hash(state);
    }
}
