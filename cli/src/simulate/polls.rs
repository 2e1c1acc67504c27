//! Questions that are asked again and again, as a network manager asks for the state of its connections.

use std::collections::HashMap;

use devicenex_core::id::{Framing, Layout};
use devicenex_core::monitor::{Kind, Reading};
use link_core::{Frame, Instant};

/// A request without a connection that was answered before, and its answer: held back until it shows whether that is the same
/// again.
#[derive(Default)]
pub(super) struct Polls {
    /// The last answer to each.
    answers: HashMap<Question, Vec<u8>>,
    /// Those that have no answer yet, in the order of time.
    asked: Vec<Asked>,
}

/// A request as it will be told if its answer is another one.
pub(super) struct Held {
    pub(super) at: Instant,
    pub(super) who: String,
    pub(super) frame: Frame,
    pub(super) words: String,
}

/// What is to be done about a frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Poll {
    /// It says something new, or is nothing of this kind.
    News,
    /// It is a request that may be answered as before: it is to be [held](Polls::hold).
    Again,
    /// It is the same answer as before: neither it nor its request need be told.
    Same,
}

#[derive(Clone, PartialEq, Eq, Hash)]
struct Question {
    segment: usize,
    client: u8,
    server: u8,
    request: Vec<u8>,
}

struct Asked {
    question: Question,
    transaction: u8,
    held: Option<Held>,
}

impl Polls {
    /// Looks at a frame that got through.
    pub(super) fn look(&mut self, segment: usize, reading: &Reading<'_>) -> Poll {
        let Layout::Connectionless { route, framing: Framing::Complete { transaction } } = reading.layout
        else {
            return Poll::News;
        };
        let (source, destination) = (route.source.number(), route.destination.number());
        let data = reading.frame.data();
        match reading.kind {
            Kind::ConnectionlessRequest => {
                let question =
                    Question { segment, client: source, server: destination, request: data.to_vec() };
                // One that is repeated was not answered: both are told.
                let again = self.asked.iter().any(|asked| asked.question == question);
                let is_known = reading.problem.is_none() && !again && self.answers.contains_key(&question);
                self.asked.retain(|asked| asked.question != question || asked.held.is_some());
                self.asked.push(Asked { question, transaction, held: None });
                if is_known { Poll::Again } else { Poll::News }
            }
            Kind::ConnectionlessResponse => {
                let is_asked = |asked: &Asked| {
                    let Question { segment: on, client, server, .. } = asked.question;
                    (on, client, server, asked.transaction) == (segment, destination, source, transaction)
                };
                let Some(place) = self.asked.iter().rposition(is_asked) else { return Poll::News };
                let is_same = self.asked[place].held.is_some()
                    && reading.problem.is_none()
                    && self.answers.get(&self.asked[place].question).is_some_and(|last| last == data);
                if is_same {
                    self.asked.remove(place);
                    return Poll::Same;
                }
                self.answers.insert(self.asked[place].question.clone(), data.to_vec());
                // What is held is told before the answer.
                if self.asked[place].held.is_none() {
                    self.asked.remove(place);
                }
                Poll::News
            }
            _ => Poll::News,
        }
    }

    /// Keeps the request that was looked at last.
    pub(super) fn hold(&mut self, held: Held) {
        if let Some(asked) = self.asked.last_mut() {
            asked.held = Some(held);
        }
    }

    /// What must be told before anything else is.
    pub(super) fn take_held(&mut self) -> Vec<Held> {
        self.asked.iter_mut().filter_map(|asked| asked.held.take()).collect()
    }

    /// What a device answers is new again.
    pub(super) fn forget(&mut self, server: u8) {
        self.answers.retain(|question, _| question.server != server);
    }

    /// All is.
    pub(super) fn forget_all(&mut self) {
        self.answers.clear();
    }
}
