//! One explicit connection, or the port for connectionless messages, as a pipe on the server's side: a request in, in one
//! frame or in fragments, and its response out.
//!
//! | What | Rule |
//! |---|---|
//! | fragment of a request | put together by [`ExplicitReceive`], its acknowledge goes out before anything else |
//! | complete request, or first fragment | aborts a response in progress |
//! | response that fits into a frame | one frame |
//! | longer response | fragments paced by [`ExplicitTransmit`], 1000 ms for each acknowledge, two tries |
//!
//! A [`Transfer`] is told what arrives and hands out what is to be sent; the frames are its owner's business. So are the
//! timers: they have the present moment, and it is told which of its [`Wait`]s has run out.

mod message;
#[cfg(test)]
mod tests;

pub use message::Message;

use link_core::timers::TimerSet;

use crate::fragment::{
    AckStatus, ExplicitOutcome, ExplicitReceive, ExplicitTransmit, Fragment, FragmentByte, FragmentKind,
    TransmitOutcome,
};

/// The buffers and the progress of one explicit connection.
///
/// `H` is what the answer to a request needs to know of it: whom it goes to, and the transaction. `MESSAGE` is the longest
/// message, from the service byte on; `PIECE` and `PREFIX` are the room in a fragment, as in
/// [`explicit_piece`](crate::fragment::explicit_piece).
///
/// ```
/// use cip_core::fragment::{AckStatus, FragmentByte};
/// use cip_core::transfer::{Part, Rules, Transfer, Wait};
/// use link_core::Timers;
/// use link_core::timers::TimerKey;
///
/// #[derive(Clone, Copy)]
/// struct Timer(Wait);
///
/// impl From<Wait> for Timer {
///     fn from(wait: Wait) -> Self {
///         Self(wait)
///     }
/// }
///
/// impl TimerKey<2> for Timer {
///     const ALL: [Self; 2] = [Self(Wait::Acknowledge), Self(Wait::Reassembly)];
///     const WHY: [&'static str; 2] = ["acknowledge of a fragment", "next fragment"];
///     fn index(self) -> usize {
///         usize::from(self.0 == Wait::Reassembly)
///     }
/// }
///
/// // Eight bytes in a frame, the first of which is a transaction ID in a first fragment.
/// let mut transfer = Transfer::<u8, 32, 8, 1>::new(32, 0);
/// let mut timers = Timers::<Timer, 2>::new();
/// let rules = Rules { receive_time_out: 2000, reacknowledge_last: true };
/// // A request in two fragments, of transaction 7:
/// let first = (FragmentByte::from(0x00), &[0x10, 4, 100, 3, 1, 2, 3][..]);
/// assert_eq!(transfer.fragment(&mut timers, rules, 7, false, first.0, first.1), Ok(false));
/// assert_eq!(transfer.take().unwrap(), (7, Part::Acknowledge(FragmentByte::from(0xC0), AckStatus::Success)));
/// assert_eq!(transfer.fragment(&mut timers, rules, 7, false, FragmentByte::from(0x81), &[4, 5]), Ok(true));
/// assert!(matches!(transfer.take(), Some((7, Part::Acknowledge(..)))));
/// assert_eq!(transfer.request(), [0x10, 4, 100, 3, 1, 2, 3, 4, 5]);
/// transfer.respond(7, &[0x90]);
/// assert_eq!(transfer.take().unwrap(), (7, Part::Whole(&[0x90])));
/// ```
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Transfer<H, const MESSAGE: usize, const PIECE: usize, const PREFIX: usize> {
    /// A request in fragments while it arrives, and the response after that: what begins a request aborts the response
    /// to the one before.
    message: Message<MESSAGE>,
    receive: ExplicitReceive,
    transmit: ExplicitTransmit<PIECE, PREFIX>,
    /// Of the response.
    header: H,
    stage: Stage,
    acknowledge: Option<(H, u8, AckStatus)>,
}

/// How far the present frame of the response is.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Stage {
    /// Nothing is to be sent.
    Idle,
    /// To be handed to the controller.
    Due,
    /// The same, for the second time: the acknowledge of the first may still come.
    Again,
    /// With the controller.
    Handed,
    /// A fragment was sent, and is to be acknowledged.
    Sent,
}

/// What a frame of a transfer carries.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Part<'a> {
    /// The acknowledge of a fragment of the request.
    Acknowledge(FragmentByte, AckStatus),
    /// The whole response.
    Whole(&'a [u8]),
    /// A fragment of it.
    Fragment(Fragment<'a>),
}

/// What a transfer waits for.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Wait {
    /// A fragment of a response waits for its acknowledge: [`Transfer::not_acknowledged`].
    Acknowledge,
    /// What arrived of a request is dropped, or the last one forgotten: [`Transfer::reassembly_over`].
    Reassembly,
}

/// What the owner decides about fragments.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Rules {
    /// How long the next fragment of a request may take, in ms.
    pub receive_time_out: u16,
    /// The last fragment of a request is known again for one second, and acknowledged once more.
    pub reacknowledge_last: bool,
}

/// Why a fragment was not taken.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FragmentRefused {
    /// An acknowledge without its status.
    #[error("an acknowledge without its status")]
    NoStatus,
    /// A fragment out of its order; what had arrived of the message is dropped.
    #[error("fragment out of order")]
    Order,
    /// An acknowledge of something that was not sent.
    #[error("acknowledge of nothing")]
    StrayAcknowledge,
}

impl<H: Copy, const MESSAGE: usize, const PIECE: usize, const PREFIX: usize>
    Transfer<H, MESSAGE, PIECE, PREFIX>
{
    /// Nothing arrives and nothing is sent. `limit`: the longest request, from the service byte on; `header` has no meaning
    /// yet.
    pub const fn new(limit: usize, header: H) -> Self {
        Self {
            message: Message::EMPTY,
            receive: ExplicitReceive::new(limit),
            transmit: ExplicitTransmit::new(),
            header,
            stage: Stage::Idle,
            acknowledge: None,
        }
    }

    /// A request came in one frame: it is to be [answered](Self::respond) now.
    pub fn whole<K: From<Wait>>(&mut self, timers: &mut impl TimerSet<K>) {
        self.abort(timers);
        self.forget(timers);
    }

    /// Takes a fragment: the transaction bit of its header if it has one, the fragmentation byte, and the part of the message,
    /// for an acknowledge the status. True if the request is complete: it is to be [answered](Self::respond) now.
    pub fn fragment<K: From<Wait>>(
        &mut self,
        timers: &mut impl TimerSet<K>,
        rules: Rules,
        header: H,
        xid: bool,
        fragment: FragmentByte,
        data: &[u8],
    ) -> Result<bool, FragmentRefused> {
        match fragment.kind {
            FragmentKind::Acknowledge => {
                return self.acknowledged(timers, fragment.count(), data).map(|()| false);
            }
            FragmentKind::First => self.abort(timers),
            FragmentKind::Middle | FragmentKind::Last => {}
        }
        let outcome = self.receive.fragment(&mut self.message.bytes, xid, fragment, data);
        if let Some(status) = outcome.ack() {
            self.acknowledge = Some((header, fragment.count(), status));
        }
        match outcome {
            ExplicitOutcome::Complete(request) => {
                let len = request.len();
                self.message.set_len(len);
                if rules.reacknowledge_last {
                    timers.set_after_millis(Wait::Reassembly.into(), REACKNOWLEDGE_MILLIS);
                } else {
                    self.forget(timers);
                }
                return Ok(true);
            }
            ExplicitOutcome::Stored | ExplicitOutcome::Repeated => {
                self.message.set_len(self.receive.received().into());
                timers.set_after_millis(Wait::Reassembly.into(), rules.receive_time_out.into());
            }
            ExplicitOutcome::RepeatedLast => {}
            ExplicitOutcome::TooLong => timers.clear(Wait::Reassembly.into()),
            ExplicitOutcome::OutOfSequence { .. }
            | ExplicitOutcome::IgnoredNoFirst
            | ExplicitOutcome::InvalidFirst { .. } => {
                if !self.receive.remembers_completed() {
                    timers.clear(Wait::Reassembly.into());
                }
                return Err(FragmentRefused::Order);
            }
            ExplicitOutcome::Acknowledge => return Err(FragmentRefused::StrayAcknowledge),
        }
        Ok(false)
    }

    /// The request of which the last fragment has come.
    pub fn request(&self) -> &[u8] {
        self.message.body()
    }

    /// Answers a request. What has no room in the buffer is cut off: write it within [`MESSAGE`](Self) bytes.
    pub fn respond(&mut self, header: H, response: &[u8]) {
        let room = self.message.bytes.iter_mut();
        let len = response.len().min(room.len());
        room.zip(response).for_each(|(byte, &written)| *byte = written);
        self.message.set_len(len);
        self.header = header;
        self.stage = Stage::Due;
        self.transmit.start(self.message.body());
    }

    /// Nothing is left to be sent of a response.
    pub fn is_quiet(&self) -> bool {
        self.stage == Stage::Idle
    }

    /// Whether a frame is to be handed out.
    pub const fn is_due(&self) -> bool {
        self.acknowledge.is_some() || matches!(self.stage, Stage::Due | Stage::Again)
    }

    /// Whether the frame to be handed out is an acknowledge.
    pub const fn must_acknowledge(&self) -> bool {
        self.acknowledge.is_some()
    }

    /// What the next frame carries.
    pub fn peek(&self) -> Option<(H, Part<'_>)> {
        if let Some(acknowledge) = self.acknowledge {
            return Some(acknowledge_part(acknowledge));
        }
        matches!(self.stage, Stage::Due | Stage::Again).then(|| (self.header, self.part()))
    }

    /// The same, as handed to the controller. If it is no acknowledge, tell when that is [over](Self::handed).
    pub fn take(&mut self) -> Option<(H, Part<'_>)> {
        if let Some(acknowledge) = self.acknowledge.take() {
            return Some(acknowledge_part(acknowledge));
        }
        if !matches!(self.stage, Stage::Due | Stage::Again) {
            return None;
        }
        self.stage = Stage::Handed;
        Some((self.header, self.part()))
    }

    /// The response, or the fragment of it, that was taken is with the controller no longer: sent, or given back.
    pub fn handed<K: From<Wait>>(&mut self, timers: &mut impl TimerSet<K>) {
        if self.stage != Stage::Handed {
            return;
        }
        if self.transmit.is_sending() {
            self.stage = Stage::Sent;
            timers.set_after_millis(Wait::Acknowledge.into(), ACKNOWLEDGE_MILLIS);
        } else {
            self.stage = Stage::Idle;
        }
    }

    /// Nothing more of a request has arrived in time, or the last one is old enough to be forgotten.
    pub const fn reassembly_over(&mut self) {
        if self.receive.is_receiving() {
            self.receive.discard();
        } else {
            self.receive.forget_completed();
        }
    }

    /// The acknowledge of a fragment has not come in time; true if the response was given up.
    pub fn not_acknowledged<K: From<Wait>>(&mut self, timers: &mut impl TimerSet<K>) -> bool {
        let outcome = self.transmit.time_out();
        self.go_on(timers, outcome);
        if self.stage == Stage::Due {
            self.stage = Stage::Again;
        }
        outcome == TransmitOutcome::Abandoned
    }

    /// The connection is gone. A response in one frame, and the acknowledge before it, still go out: they may belong to the
    /// request that ended it.
    pub fn close<K: From<Wait>>(&mut self, timers: &mut impl TimerSet<K>) {
        self.forget(timers);
        if self.transmit.is_sending() {
            self.abort(timers);
        }
    }

    /// Nothing goes out any more.
    pub fn clear<K: From<Wait>>(&mut self, timers: &mut impl TimerSet<K>) {
        self.close(timers);
        self.acknowledge = None;
        self.abort(timers);
    }

    /// The response, or the present fragment of it.
    fn part(&self) -> Part<'_> {
        let body = self.message.body();
        self.transmit.fragment(body).map_or(Part::Whole(body), Part::Fragment)
    }

    fn acknowledged<K: From<Wait>>(
        &mut self,
        timers: &mut impl TimerSet<K>,
        count: u8,
        data: &[u8],
    ) -> Result<(), FragmentRefused> {
        let &status = data.first().ok_or(FragmentRefused::NoStatus)?;
        // A fragment that was never handed out cannot have been received.
        if self.stage == Stage::Due {
            return Err(FragmentRefused::StrayAcknowledge);
        }
        match self.transmit.acknowledge(self.message.body(), count, AckStatus::from(status)) {
            TransmitOutcome::Ignored => Err(FragmentRefused::StrayAcknowledge),
            outcome => {
                self.go_on(timers, outcome);
                Ok(())
            }
        }
    }

    fn go_on<K: From<Wait>>(&mut self, timers: &mut impl TimerSet<K>, outcome: TransmitOutcome) {
        timers.clear(Wait::Acknowledge.into());
        self.stage = match outcome {
            TransmitOutcome::Send => Stage::Due,
            TransmitOutcome::Complete | TransmitOutcome::Refused(_) | TransmitOutcome::Abandoned => {
                Stage::Idle
            }
            TransmitOutcome::Ignored => self.stage,
        };
    }

    /// The response in progress.
    fn abort<K: From<Wait>>(&mut self, timers: &mut impl TimerSet<K>) {
        // Where there is none nothing is waited for.
        if self.stage != Stage::Idle {
            self.go_on(timers, TransmitOutcome::Abandoned);
            self.transmit.abort();
        }
    }

    /// What has arrived of a request, or the last one.
    fn forget<K: From<Wait>>(&mut self, timers: &mut impl TimerSet<K>) {
        // Where nothing is remembered no timer runs.
        if !self.receive.is_idle() {
            self.receive.discard();
            timers.clear(Wait::Reassembly.into());
        }
    }
}

fn acknowledge_part<'a, H>((header, count, status): (H, u8, AckStatus)) -> (H, Part<'a>) {
    (header, Part::Acknowledge(FragmentByte::new(FragmentKind::Acknowledge, count), status))
}

/// How long a fragment of a response waits for its acknowledge.
const ACKNOWLEDGE_MILLIS: u32 = 1000;
/// How long the last fragment of a request is known again.
const REACKNOWLEDGE_MILLIS: u32 = 1000;
