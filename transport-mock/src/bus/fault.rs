//! What can go wrong on the wire, each from a stream of random numbers of its own.

use std::collections::BTreeMap;
use std::time::Duration;

use link_core::{Filter, Frame, Instant};

use super::station::after;
use crate::NodeId;
use crate::rng::{Gaps, Rng, threshold};

/// Where a fault strikes.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Scope {
    /// The wire: every node sees it.
    Bus,
    /// What one node hears.
    Node(NodeId),
}

/// Which frames a fault strikes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Which {
    /// All of them.
    All,
    /// The next ones, so many.
    Next(u32),
    /// Each with this probability.
    Share(f64),
}

/// Something that is wrong with the wire, or with a transceiver. Faults are switched on and off by
/// [`Change::FaultOn`](crate::Change::FaultOn) and [`FaultOff`](crate::Change::FaultOff).
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Fault {
    /// Each bit is inverted with the probability `rate`.
    BitFlips {
        /// Probability per bit at the rate of the bus.
        rate: f64,
        /// Who sees it.
        scope: Scope,
    },
    /// One bit of one frame is inverted.
    FlipBit {
        /// Which attempt to send a frame: 0 is the next one that begins.
        frame: u64,
        /// Which bit, from 0, the start of frame; stuff bits count.
        bit: u32,
        /// Who sees it.
        scope: Scope,
    },
    /// Bursts of noise, in which each bit is inverted with probability one half.
    Bursts {
        /// Mean time from the end of a burst to the begin of the next.
        gap: Duration,
        /// Length of a burst.
        length: Duration,
        /// Who sees it.
        scope: Scope,
    },
    /// A transceiver that pulls the bus dominant now and then, whatever its controller says.
    Babble {
        /// How long it pulls.
        pull: Duration,
        /// From one pull to the next; `pull` or less is a bus that is dominant for good.
        every: Duration,
    },
    /// One receiver sees the last bit but one of the end of frame dominant, the case that CAN cannot make consistent. The
    /// others have accepted the frame when its error flag comes. If that is active, the sender sees it and sends
    /// again, so the others receive the frame twice; if it is passive, the receiver has lost the frame for good.
    SpoiltEnd {
        /// Who sees the dominant bit.
        receiver: NodeId,
        /// Only frames that pass this; `None` is every frame.
        filter: Option<Filter>,
        /// Which of them.
        which: Which,
    },
    /// A receiver acknowledges frames and then loses them, because it is too slow to read its mailboxes. It is told by
    /// [`LinkEvent::Overrun`](link_core::LinkEvent::Overrun).
    Overrun {
        /// Who loses them.
        receiver: NodeId,
        /// Only frames that pass this; `None` is every frame.
        filter: Option<Filter>,
        /// Which of them.
        which: Which,
    },
}

/// Names a fault, so that it can be switched off. The number is the caller's.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct FaultId(pub u32);

/// What the wire does to a bit.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(crate) struct Overlay {
    pub(crate) inverted: bool,
    pub(crate) dominant: bool,
}

/// The faults that are switched on.
#[derive(Clone, Debug)]
pub(crate) struct Faults {
    seed: u64,
    /// The length of a bit.
    bit: u64,
    active: Vec<Active>,
    /// How often each fault was switched on.
    switched_on: BTreeMap<FaultId, u64>,
    /// The earliest moment at which one of them disturbs the wire.
    next: Instant,
}

#[derive(Clone, Debug)]
struct Active {
    id: FaultId,
    fault: Fault,
    rng: Rng,
    gaps: Option<Gaps>,
    /// Frames seen, or struck.
    count: u64,
    /// Only this segment is disturbed.
    segment: Option<usize>,
    /// The wire is disturbed from..to.
    from: Instant,
    to: Instant,
}

impl Faults {
    pub(crate) fn new(seed: u64, bit: u64) -> Self {
        Self { seed, bit, active: Vec::new(), switched_on: BTreeMap::new(), next: Instant::MAX }
    }

    /// Switches a fault on; one of the same name is replaced. Each time it draws other random numbers.
    pub(crate) fn on(&mut self, now: Instant, id: FaultId, fault: Fault) {
        self.off(id);
        let turn = self.switched_on.entry(id).or_default();
        let stream = FAULT_STREAMS | u64::from(id.0) | *turn << 33;
        *turn += 1;
        let gaps = match fault {
            Fault::BitFlips { rate, .. } => Some(Gaps::new(rate)),
            Fault::Bursts { gap, .. } => {
                // In steps of a bit.
                let steps = (nanos(gap) / self.bit).max(1);
                Some(Gaps::new(1.0 / steps as f64))
            }
            Fault::FlipBit { .. }
            | Fault::Babble { .. }
            | Fault::SpoiltEnd { .. }
            | Fault::Overrun { .. } => None,
        };
        let mut active = Active {
            id,
            fault,
            rng: Rng::new(self.seed, stream),
            gaps,
            count: 0,
            segment: None,
            from: Instant::MAX,
            to: Instant::MAX,
        };
        let start = Instant::from_nanos(now.as_nanos().next_multiple_of(self.bit));
        active.schedule(start, self.bit);
        self.active.push(active);
        self.update();
    }

    /// Switches a fault off.
    pub(crate) fn off(&mut self, id: FaultId) {
        self.active.retain(|active| active.id != id);
        self.update();
    }

    /// The earliest moment at which the wire is disturbed; past if it is now.
    pub(crate) const fn next(&self) -> Instant {
        self.next
    }

    /// A frame starts. Returns whether it must be simulated bit by bit, and fills in the receivers for which its end is
    /// spoilt, if they hear it.
    pub(crate) fn frame_starts(
        &mut self,
        segment: usize,
        at: Instant,
        bit_time: u64,
        frame: &Frame,
        hears: impl Fn(NodeId) -> bool,
        spoilt: &mut Vec<NodeId>,
    ) -> bool {
        spoilt.clear();
        let mut strikes = false;
        for active in &mut self.active {
            match active.fault {
                Fault::FlipBit { frame, bit, .. } => {
                    if active.count == frame {
                        active.from = after(at, u64::from(bit) * bit_time);
                        active.to = after(active.from, bit_time);
                        active.segment = Some(segment);
                        strikes = true;
                    }
                    active.count += 1;
                }
                Fault::SpoiltEnd { receiver, filter, which } => {
                    if hears(receiver) && active.strikes(filter, which, frame) {
                        spoilt.push(receiver);
                        strikes = true;
                    }
                }
                Fault::BitFlips { .. }
                | Fault::Bursts { .. }
                | Fault::Babble { .. }
                | Fault::Overrun { .. } => {}
            }
        }
        if strikes {
            self.update();
        }
        strikes
    }

    /// Whether `receiver` loses a frame that it has received.
    pub(crate) fn overruns(&mut self, receiver: usize, frame: &Frame) -> bool {
        self.active.iter_mut().any(|active| match active.fault {
            Fault::Overrun { receiver: who, filter, which } => {
                who.index() == receiver && active.strikes(filter, which, frame)
            }
            Fault::BitFlips { .. }
            | Fault::FlipBit { .. }
            | Fault::Bursts { .. }
            | Fault::Babble { .. }
            | Fault::SpoiltEnd { .. } => false,
        })
    }

    /// What every node of a segment sees of the bit that is sampled at `at`. `node` is called for what single nodes see inverted.
    pub(crate) fn overlay(&mut self, segment: usize, at: Instant, mut node: impl FnMut(NodeId)) -> Overlay {
        let mut overlay = Overlay::default();
        if at < self.next {
            return overlay;
        }
        for active in &mut self.active {
            while active.to <= at {
                let ended = active.to;
                active.schedule(ended, self.bit);
            }
            if active.from > at || active.segment.is_some_and(|only| only != segment) {
                continue;
            }
            match active.fault {
                Fault::BitFlips { scope, .. } | Fault::FlipBit { scope, .. } => {
                    overlay.invert(scope, &mut node)
                }
                Fault::Bursts { scope, .. } => {
                    if active.rng.next_u64() >> 63 == 1 {
                        overlay.invert(scope, &mut node);
                    }
                }
                Fault::Babble { .. } => overlay.dominant = true,
                Fault::SpoiltEnd { .. } | Fault::Overrun { .. } => {}
            }
        }
        self.update();
        overlay
    }

    fn update(&mut self) {
        self.next = self.active.iter().map(|active| active.from).min().unwrap_or(Instant::MAX);
    }
}

impl Overlay {
    fn invert(&mut self, scope: Scope, node: &mut impl FnMut(NodeId)) {
        match scope {
            Scope::Bus => self.inverted = !self.inverted,
            Scope::Node(id) => node(id),
        }
    }
}

impl Active {
    /// Finds the next time when it disturbs the wire, from `start` on.
    fn schedule(&mut self, start: Instant, bit: u64) {
        let gap = self.gaps.as_ref().map_or(0, |gaps| gaps.draw(&mut self.rng)).saturating_mul(bit);
        (self.from, self.to) = match self.fault {
            Fault::BitFlips { .. } => (after(start, gap), after(start, gap.saturating_add(bit))),
            Fault::Bursts { length, .. } => {
                (after(start, gap), after(start, gap.saturating_add(nanos(length).max(bit))))
            }
            Fault::Babble { pull, every } => {
                let (pull, every) = (nanos(pull).max(1), nanos(every));
                let pause = if self.to == Instant::MAX { 0 } else { every.saturating_sub(pull) };
                (after(start, pause), after(start, pause.saturating_add(pull)))
            }
            Fault::FlipBit { .. } | Fault::SpoiltEnd { .. } | Fault::Overrun { .. } => {
                (Instant::MAX, Instant::MAX)
            }
        };
    }

    fn strikes(&mut self, filter: Option<Filter>, which: Which, frame: &Frame) -> bool {
        if filter.is_some_and(|filter| !filter.accepts(frame.id())) {
            return false;
        }
        match which {
            Which::All => true,
            Which::Next(n) => {
                self.count += 1;
                self.count <= u64::from(n)
            }
            Which::Share(probability) => self.rng.chance(threshold(probability)),
        }
    }
}

fn nanos(span: Duration) -> u64 {
    u64::try_from(span.as_nanos()).unwrap_or(u64::MAX)
}

/// Keeps the streams of faults apart from those of nodes.
const FAULT_STREAMS: u64 = 1 << 32;
