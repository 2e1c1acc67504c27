//! How long the echo of a frame is waited for.

use core::time::Duration;

use link_core::{Instant, LinkEvent};

use crate::error::Unconfirmed;

/// Watches over the frame that the kernel has. Its echo may be among frames that the receive queue has lost, and a driver may lose the
/// frame itself, or its echo, without a word: then nobody will ever tell what became of it, and nothing else would be sent.
///
/// A controller that has trouble, however, repeats its frame for as long as it takes: a node that is alone on the bus waits in error-passive
/// for another to acknowledge. Its frame is not lost. Where the driver does not tell of that, and nothing else is heard either, it looks
/// like a lost one: each that is given up adds another of its kind to the queue, so each is waited for twice as long as the one before.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct EchoWatch {
    /// When the echo is late; a controller that was never heard of has no trouble.
    late_at: Instant,
    /// How long after the kernel has taken a frame that is.
    patience: Duration,
    has_trouble: bool,
    /// Since the kernel has taken the frame, another was heard, or an error.
    is_alive: bool,
    /// Frames were lost while the kernel had this one: when to give it up for that.
    lost_at: Option<Instant>,
}

impl EchoWatch {
    pub(crate) const fn new() -> Self {
        Self { late_at: Instant::ZERO, patience: LATE, has_trouble: false, is_alive: false, lost_at: None }
    }

    /// The kernel has taken a frame.
    pub(crate) fn begin(&mut self, now: Instant) {
        self.late_at = now.saturating_add(self.patience);
        self.lost_at = None;
        self.is_alive = false;
    }

    /// It is given up; returns why nobody can tell what became of it.
    pub(crate) fn give_up(&mut self) -> Unconfirmed {
        match (self.lost_at, self.is_alive) {
            (Some(_), _) => Unconfirmed::Overrun,
            (None, true) => Unconfirmed::Unheard,
            (None, false) => {
                self.patience = self.patience.saturating_mul(2).min(LATEST);
                Unconfirmed::Silence
            }
        }
    }

    /// A frame was heard, an own one or another's: somebody else is there.
    pub(crate) fn alive(&mut self, at: Instant) {
        self.is_alive = true;
        if self.patience > LATE {
            self.patience = LATE;
            self.late_at = self.late_at.min(at.saturating_add(LATE));
        }
    }

    /// The receive queue has lost frames, of which the echo may have been one.
    pub(crate) fn overrun(&mut self, at: Instant) {
        self.lost_at.get_or_insert(at.saturating_add(AFTER_A_LOSS));
    }

    /// What the controller tells of itself.
    pub(crate) fn hear(&mut self, at: Instant, event: LinkEvent) {
        match event {
            LinkEvent::ErrorWarning | LinkEvent::ErrorPassive => self.has_trouble = true,
            LinkEvent::ErrorActive | LinkEvent::Up => {
                self.has_trouble = false;
                self.late_at = self.late_at.max(at.saturating_add(LATE));
            }
            // It tries again.
            LinkEvent::BusError(_) => {
                self.is_alive = true;
                self.late_at = self.late_at.max(at.saturating_add(LATE));
            }
            LinkEvent::Down
            | LinkEvent::BusOff
            | LinkEvent::Counters { .. }
            | LinkEvent::Overrun { .. }
            | LinkEvent::ModeSet(_)
            | LinkEvent::FilterSet
            | LinkEvent::Refused(_) => {}
        }
    }

    /// When the frame is given up.
    pub(crate) fn give_up_at(&self) -> Option<Instant> {
        let late_at = (!self.has_trouble).then_some(self.late_at);
        [late_at, self.lost_at].into_iter().flatten().min()
    }
}

/// Many times what the most patient frame waits on a full bus.
const LATE: Duration = Duration::from_secs(3);
/// Of a bus on which nothing is ever heard.
const LATEST: Duration = Duration::from_secs(60);
/// After frames were lost.
const AFTER_A_LOSS: Duration = Duration::from_secs(1);

#[cfg(test)]
mod tests {
    use super::*;
    use link_core::BusErrorKind;

    /// What happens while a frame is waited for.
    type Deed = fn(&mut EchoWatch);

    fn at(millis: u64) -> Instant {
        Instant::from_millis(millis)
    }

    #[test]
    fn a_frame_whose_echo_does_not_come_is_given_up() {
        let mut watch = EchoWatch::new();
        watch.begin(at(500));
        assert_eq!(watch.give_up_at(), Some(at(3_500)));
        watch.begin(at(600));
        assert_eq!(watch.give_up_at(), Some(at(3_600)), "each frame has its own time");
    }

    /// Alone on a bus whose driver tells of no trouble.
    #[test]
    fn what_is_given_up_in_silence_makes_patient_until_something_is_heard() {
        let mut watch = EchoWatch::new();
        let mut now = 0;
        for patience in [3, 6, 12, 24, 48, 60, 60] {
            watch.begin(at(now));
            now += patience * 1_000;
            assert_eq!(watch.give_up_at(), Some(at(now)));
            assert_eq!(watch.give_up(), Unconfirmed::Silence);
        }
        watch.begin(at(now));
        watch.alive(at(now + 10_000));
        assert_eq!(watch.give_up_at(), Some(at(now + 13_000)), "what is with the kernel goes next");
        watch.begin(at(now + 11_000));
        assert_eq!(watch.give_up_at(), Some(at(now + 14_000)));
        watch.alive(at(now + 12_000));
        assert_eq!(watch.give_up_at(), Some(at(now + 14_000)), "other frames say nothing of this one");
    }

    #[test]
    fn a_loss_of_frames_gives_it_up_sooner_and_says_nothing_of_the_next() {
        let mut watch = EchoWatch::new();
        watch.begin(at(0));
        watch.overrun(at(100));
        watch.overrun(at(900));
        assert_eq!(watch.give_up_at(), Some(at(1_100)));
        watch.begin(at(1_200));
        assert_eq!(watch.give_up_at(), Some(at(4_200)));
    }

    /// Only silence says that there may be nobody else.
    #[test]
    fn what_was_heard_meanwhile_says_why_it_is_given_up() {
        let of_deeds: [(&[Deed], Unconfirmed); 5] = [
            (&[], Unconfirmed::Silence),
            (&[|watch| watch.alive(at(10))], Unconfirmed::Unheard),
            (&[|watch| watch.hear(at(10), LinkEvent::BusError(BusErrorKind::Crc))], Unconfirmed::Unheard),
            (&[|watch| watch.overrun(at(10))], Unconfirmed::Overrun),
            (&[|watch| watch.overrun(at(10)), |watch| watch.alive(at(11))], Unconfirmed::Overrun),
        ];
        for (deeds, why) in of_deeds {
            let mut watch = EchoWatch::new();
            watch.alive(at(0));
            watch.begin(at(5));
            deeds.iter().for_each(|deed| deed(&mut watch));
            assert_eq!(watch.give_up(), why);
            watch.begin(at(5_000));
            let patience = if why == Unconfirmed::Silence { 6_000 } else { 3_000 };
            assert_eq!(watch.give_up_at(), Some(at(5_000 + patience)), "only silence makes patient: {why:?}");
        }
    }

    /// Nobody acknowledges, which may last for hours.
    #[test]
    fn a_controller_in_trouble_keeps_its_frame() {
        let mut watch = EchoWatch::new();
        watch.begin(at(0));
        watch.hear(at(20), LinkEvent::ErrorWarning);
        watch.hear(at(30), LinkEvent::ErrorPassive);
        assert_eq!(watch.give_up_at(), None);
        watch.hear(at(60_000), LinkEvent::ErrorActive);
        assert_eq!(watch.give_up_at(), Some(at(63_000)), "the echo should follow");
        watch.hear(at(61_000), LinkEvent::BusError(BusErrorKind::Ack));
        assert_eq!(watch.give_up_at(), Some(at(64_000)), "it is trying");
    }

    #[test]
    fn trouble_outlasts_a_frame() {
        let mut watch = EchoWatch::new();
        watch.hear(at(0), LinkEvent::ErrorPassive);
        watch.begin(at(10));
        assert_eq!(watch.give_up_at(), None);
        watch.hear(at(20), LinkEvent::Up);
        assert_eq!(watch.give_up_at(), Some(at(3_020)));
    }
}
