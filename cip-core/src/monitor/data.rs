//! I/O data: whole in a frame, or in fragments.

use link_core::Instant;

use super::{Flaw, Frag, Guess, Piece, Remark, Remarks, Side, Slots, Span, Stream};
use crate::fragment::{FragmentByte, FragmentKind, IO_UNFRAGMENTED_LEN};

/// Whether fragmented I/O is guessed, where nothing tells the size of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum FragmentationGuess {
    /// It is.
    #[default]
    On,
    /// I/O data of unknown size are shown as they are.
    Off,
}

/// How far a frame takes its message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Progress {
    /// The message is complete.
    Complete,
    /// It is not, or is lost.
    Part,
    /// It is not, and its first fragment was taken for a message of its own.
    Begun,
    /// It is complete, and its first fragment was taken for a message of its own.
    Reconsidered,
}

/// What a frame of I/O data is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part<'s> {
    /// How far it takes its message.
    pub progress: Progress,
    /// The whole message, in the frame that completes a fragmented one.
    pub message: Option<&'s [u8]>,
    /// Where the data stand in the frame, if it is a message of its own.
    pub value: Option<Span>,
    /// The fragmentation byte.
    pub frag: Option<Frag>,
    /// What is wrong with it.
    pub flaw: Option<Flaw>,
    /// The message does not fit into the store.
    pub overflows: bool,
    /// That the data are fragmented is only assumed, or the frames before are missing.
    pub assumed: bool,
}

impl Side {
    /// Takes the data of a frame: whole, or a fragment if the connection size is above eight bytes or the frames look like
    /// it.
    pub fn frame<'s, const N: usize, const B: usize>(
        &mut self,
        slots: &'s mut Slots<N, B>,
        at: Instant,
        stream: Stream,
        field: &[u8],
        guess: FragmentationGuess,
    ) -> Part<'s> {
        let size = self.size;
        if let Some(size) = size {
            self.guess = Guess::Plain;
            if usize::from(size) <= IO_UNFRAGMENTED_LEN {
                return Part { flaw: check_size(Some(size), field.len()), ..Part::whole(field) };
            }
        } else if !(matches!(self.guess, Guess::Fragmented | Guess::Begun)
            || continues(self.guess, field) && slots.is_receiving(stream))
        {
            let before = core::mem::replace(&mut self.guess, Guess::Plain);
            if let ([0, _, _, _, _, _, _, _], FragmentationGuess::On) = (field, guess) {
                self.guess = Guess::Candidate;
                slots.io(stream, at, None, field);
            } else if before == Guess::Candidate {
                // Only a candidate is kept: the search is for nothing in all other frames, which are nearly all.
                slots.discard(stream);
            }
            return Part::whole(field);
        }
        let is_guessed = size.is_none();
        let is_confirmed = is_guessed && self.guess == Guess::Candidate;
        let byte = field.first().copied().map(FragmentByte::from);
        let known = self.known;
        self.known |= byte.is_none_or(|byte| byte.kind != FragmentKind::Middle);
        let piece = slots.io(stream, at, size, field);
        if is_guessed && matches!(piece, Piece::Broken(_)) {
            // It was not fragmented after all, or has changed.
            self.guess = Guess::Plain;
            return Part { assumed: true, ..Part::whole(field) };
        }
        let is_reconsidered = is_confirmed || (is_guessed && self.guess == Guess::Begun);
        if is_guessed {
            let is_under_way = matches!(piece, Piece::Kept | Piece::Repeated);
            self.guess = if is_reconsidered && is_under_way { Guess::Begun } else { Guess::Fragmented };
        }
        let part = Part {
            progress: Progress::Part,
            message: None,
            value: None,
            frag: byte.map(Frag::new),
            flaw: None,
            overflows: false,
            assumed: is_guessed,
        };
        match piece {
            Piece::Whole(message) => {
                let progress = if is_reconsidered { Progress::Reconsidered } else { Progress::Complete };
                Part { progress, message: Some(message), flaw: check_size(size, message.len()), ..part }
            }
            Piece::Broken(flaw) => Part { flaw: Some(flaw), ..part },
            Piece::Headless => match byte {
                Some(byte) if known => {
                    Part { flaw: Some(Flaw::NoFirstFragment { found: byte.count() }), ..part }
                }
                Some(_) | None => Part { assumed: true, ..part },
            },
            Piece::Overflow => Part { overflows: true, ..part },
            Piece::Kept | Piece::Repeated if is_confirmed => Part { progress: Progress::Begun, ..part },
            Piece::Kept | Piece::Repeated => part,
        }
    }
}

impl Part<'_> {
    /// What is to be said of the frame.
    pub fn tell(&self, reading: &mut impl Remarks) {
        if self.assumed {
            reading.remark(Remark::Assumed);
        }
        if let Some(flaw) = self.flaw {
            reading.remark(Remark::Flaw(flaw));
        }
        if self.overflows {
            reading.remark(Remark::NotStored);
        }
    }

    /// A frame that is a message of its own.
    fn whole(field: &[u8]) -> Self {
        Self {
            progress: Progress::Complete,
            message: None,
            value: Span::tail(field.len(), field.len()),
            frag: None,
            flaw: None,
            overflows: false,
            assumed: false,
        }
    }
}

/// True if the frame is the second fragment after a frame that could be the first, if that is still kept.
fn continues(guess: Guess, field: &[u8]) -> bool {
    let second = field.first().copied().map(FragmentByte::from).is_some_and(|byte| {
        let full = byte.kind == FragmentKind::Last || field.len() == IO_UNFRAGMENTED_LEN;
        matches!(byte.kind, FragmentKind::Middle | FragmentKind::Last) && byte.count() == 1 && full
    });
    guess == Guess::Candidate && second
}

/// An empty message is idle or "no data", whatever the size.
fn check_size(size: Option<u16>, len: usize) -> Option<Flaw> {
    let found = u16::try_from(len).unwrap_or(u16::MAX);
    size.filter(|&size| found != 0 && found != size).map(|expected| Flaw::IoLength { expected, found })
}
