//! Sending of explicit messages in fragments, each of which must be acknowledged before the next.

use super::cut::{count_of, unfragmented_len};
use super::{AckStatus, EXPLICIT_FRAGMENT_LEN, Fragment, explicit_piece};

/// What an acknowledge, or its absence, leads to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TransmitOutcome {
    /// Send [`fragment`](ExplicitTransmit::fragment), and start the acknowledge timer anew: it is the next one, or the
    /// same for the second time.
    Send,
    /// The last fragment was acknowledged: stop the timer, the message has arrived.
    Complete,
    /// The receiver has no room for the message: stop the timer. A server drops the response, a client reports it.
    Refused(AckStatus),
    /// Two transmissions of a fragment were not acknowledged: the message is given up.
    Abandoned,
    /// Nothing was waited for, or not this acknowledge: the timer goes on.
    Ignored,
}

/// The transmit side of an explicit connection: which fragment is on its way, and for which time.
///
/// `PIECE` and `PREFIX` are the room in a frame, as in [`explicit_piece`]; by default that of DeviceNet.
///
/// It holds neither the message nor the time. Its owner passes the same body to every call of one message, sends what
/// [`fragment`](Self::fragment) says, and lets the acknowledge timer (1000 ms) run.
///
/// | State | Event | Outcome | Next |
/// |---|---|---|---|
/// | idle | [`start`](Self::start) with more than one frame holds | send fragment 0 | waiting 0 |
/// | waiting n | acknowledge n, status 0, more data | [`Send`](TransmitOutcome::Send) fragment n+1 | waiting n+1 |
/// | waiting n | acknowledge n, status 0, n was the last | [`Complete`](TransmitOutcome::Complete) | idle |
/// | waiting n | acknowledge n, other status | [`Refused`](TransmitOutcome::Refused) | idle |
/// | waiting n | acknowledge of another count | [`Ignored`](TransmitOutcome::Ignored) | waiting n |
/// | waiting n | no acknowledge of the first transmission | [`Send`](TransmitOutcome::Send) fragment n again | waiting n |
/// | waiting n | no acknowledge of the second | [`Abandoned`](TransmitOutcome::Abandoned) | idle |
/// | waiting n | complete message or first fragment received, connection gone | [`abort`](Self::abort) | idle |
/// | idle | acknowledge, time-out | [`Ignored`](TransmitOutcome::Ignored) | idle |
///
/// Counts are modulo 64. Source: CIP Vol. 3, fragmentation protocol; Circuit Cellar 98 (1998).
///
/// ```
/// use cip_core::fragment::{AckStatus, ExplicitTransmit, TransmitOutcome};
///
/// let body = b"\x8E\x08GRT1-DRT";
/// let mut transmit: ExplicitTransmit = ExplicitTransmit::new();
/// assert!(transmit.start(body));
/// assert_eq!(transmit.fragment(body).unwrap().data, b"\x8E\x08GRT1");
/// assert_eq!(transmit.acknowledge(body, 0, AckStatus::Success), TransmitOutcome::Send);
/// assert_eq!(transmit.fragment(body).unwrap().data, b"-DRT");
/// assert_eq!(transmit.acknowledge(body, 1, AckStatus::Success), TransmitOutcome::Complete);
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ExplicitTransmit<const PIECE: usize = EXPLICIT_FRAGMENT_LEN, const PREFIX: usize = 0> {
    waiting: Option<Waiting>,
}

/// A fragment that is to be acknowledged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Waiting {
    index: u16,
    /// It is being sent for the second time.
    again: bool,
}

impl<const PIECE: usize, const PREFIX: usize> ExplicitTransmit<PIECE, PREFIX> {
    /// Nothing is being sent.
    pub const fn new() -> Self {
        Self { waiting: None }
    }

    /// True while a fragment is to be acknowledged.
    pub const fn is_sending(&self) -> bool {
        self.waiting.is_some()
    }

    /// Begins with the first fragment of `body`; false if it fits into one frame and must be sent unfragmented. A message
    /// in progress is given up.
    pub const fn start(&mut self, body: &[u8]) -> bool {
        let fragmented = body.len() > unfragmented_len(PIECE, PREFIX);
        self.waiting = if fragmented { Some(Waiting { index: 0, again: false }) } else { None };
        fragmented
    }

    /// The fragment that is to be acknowledged; `None` while nothing is being sent.
    pub fn fragment<'b>(&self, body: &'b [u8]) -> Option<Fragment<'b>> {
        explicit_piece::<PIECE, PREFIX>(body, self.waiting?.index.into())
    }

    /// Takes an acknowledge: the count and the status that it carries.
    pub fn acknowledge(&mut self, body: &[u8], count: u8, status: AckStatus) -> TransmitOutcome {
        let Some(Waiting { index, .. }) =
            self.waiting.filter(|waiting| count_of(waiting.index.into()) == count)
        else {
            return TransmitOutcome::Ignored;
        };
        self.waiting = None;
        if status != AckStatus::Success {
            return TransmitOutcome::Refused(status);
        }
        let index = index.saturating_add(1);
        if explicit_piece::<PIECE, PREFIX>(body, index.into()).is_none() {
            return TransmitOutcome::Complete;
        }
        self.waiting = Some(Waiting { index, again: false });
        TransmitOutcome::Send
    }

    /// The acknowledge timer has expired.
    pub const fn time_out(&mut self) -> TransmitOutcome {
        match &mut self.waiting {
            Some(Waiting { again: again @ false, .. }) => {
                *again = true;
                TransmitOutcome::Send
            }
            Some(_) => {
                self.waiting = None;
                TransmitOutcome::Abandoned
            }
            None => TransmitOutcome::Ignored,
        }
    }

    /// Gives up a message in progress; true if there was one.
    pub const fn abort(&mut self) -> bool {
        self.waiting.take().is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Outcome = TransmitOutcome;

    const BODY: [u8; 15] = [0x8E, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14];

    fn sending(index: u8) -> ExplicitTransmit {
        let mut transmit = ExplicitTransmit::new();
        assert!(transmit.start(&BODY));
        for count in 0..index {
            assert_eq!(transmit.acknowledge(&BODY, count, AckStatus::Success), Outcome::Send);
        }
        transmit
    }

    fn byte_of(transmit: &ExplicitTransmit) -> Option<u8> {
        transmit.fragment(&BODY).map(|fragment| fragment.byte.into())
    }

    #[test]
    fn every_row_while_idle() {
        let mut transmit: ExplicitTransmit = ExplicitTransmit::new();
        assert_eq!(transmit.acknowledge(&BODY, 0, AckStatus::Success), Outcome::Ignored);
        assert_eq!(transmit.time_out(), Outcome::Ignored);
        assert!(!transmit.abort());
        assert!(!transmit.start(&BODY[..7]));
        assert_eq!(byte_of(&transmit), None);
        assert!(transmit.start(&BODY[..8]));
        assert!(transmit.is_sending());
    }

    #[test]
    fn every_row_while_waiting() {
        assert_eq!([0, 1, 2].map(|index| byte_of(&sending(index))), [Some(0x00), Some(0x41), Some(0x82)]);
        assert_eq!(sending(2).acknowledge(&BODY, 2, AckStatus::Success), Outcome::Complete);
        for status in [AckStatus::TooMuchData, AckStatus::Reserved(7)] {
            let mut transmit = sending(1);
            assert_eq!(transmit.acknowledge(&BODY, 1, status), Outcome::Refused(status));
            assert!(!transmit.is_sending());
        }
        let mut transmit = sending(1);
        assert_eq!(transmit.acknowledge(&BODY, 0, AckStatus::Success), Outcome::Ignored);
        assert_eq!(transmit.acknowledge(&BODY, 2, AckStatus::TooMuchData), Outcome::Ignored);
        assert_eq!(transmit, sending(1));
        assert_eq!(transmit.time_out(), Outcome::Send);
        assert_eq!(byte_of(&transmit), Some(0x41));
        assert_eq!(transmit.time_out(), Outcome::Abandoned);
        assert_eq!(transmit, ExplicitTransmit::new());
        assert!(sending(1).abort());
    }

    /// Every fragment has two tries of its own.
    #[test]
    fn an_acknowledge_of_the_second_try_begins_anew() {
        let mut transmit = sending(0);
        assert_eq!(transmit.time_out(), Outcome::Send);
        assert_eq!(transmit.acknowledge(&BODY, 0, AckStatus::Success), Outcome::Send);
        assert_eq!(transmit.time_out(), Outcome::Send);
        assert_eq!(byte_of(&transmit), Some(0x41));
    }

    #[test]
    fn counts_wrap() {
        let body = [0; 6 * 66];
        let mut transmit: ExplicitTransmit = ExplicitTransmit::new();
        assert!(transmit.start(&body));
        for index in 0..65_u8 {
            assert_eq!(transmit.acknowledge(&body, index & 0x3F, AckStatus::Success), Outcome::Send);
        }
        assert_eq!(u8::from(transmit.fragment(&body).unwrap().byte), 0x81);
        assert_eq!(transmit.acknowledge(&body, 1, AckStatus::Success), Outcome::Complete);
    }

    /// Of eight bytes, of which one in the first is a transaction ID: eight in one frame, nine in two.
    #[test]
    fn the_room_in_a_frame_decides() {
        let mut transmit = ExplicitTransmit::<8, 1>::new();
        assert!(!transmit.start(&BODY[..8]));
        assert!(transmit.start(&BODY));
        assert_eq!(transmit.fragment(&BODY).unwrap().data, &BODY[..7]);
        assert_eq!(transmit.acknowledge(&BODY, 0, AckStatus::Success), Outcome::Send);
        let last = transmit.fragment(&BODY).unwrap();
        assert_eq!((u8::from(last.byte), last.data), (0x81, &BODY[7..]));
        assert_eq!(transmit.acknowledge(&BODY, 1, AckStatus::Success), Outcome::Complete);
    }
}
