//! A program that was kept from running answers nothing that is over.

use core::ops::ControlFlow;
use core::time::Duration;

use link_core::ethernet::{Action, Input, LinkEvent, Machine, Port as _, drive};
use link_core::{Deadline, Instant};
use transport_ethernet::{EthernetPort, Options};

use crate::rig::{Cable, Heard, OPTIONS, frame, heard, port, silent};

/// Answers each frame, and tells what it heard; ends with a frame `end`.
#[derive(Default)]
struct Answering {
    answer: Option<Vec<u8>>,
    event: Option<Heard>,
    until: Option<Instant>,
}

impl Machine for Answering {
    type Event = Heard;

    fn input(&mut self, _: Instant, input: Input<'_>) {
        match input {
            Input::Frame(bytes) => {
                self.answer = Some(frame(&[b"answer to ", &bytes[14..]].concat()));
                self.event = Some(Heard::Frame(bytes[14..].to_vec()));
            }
            Input::Link(event) => self.event = Some(Heard::Link(event)),
            Input::Tick => {
                self.answer = self.until.take().map(|_| frame(b"of its own"));
                self.event = Some(Heard::Nothing);
            }
        }
    }

    fn poll<'b>(&mut self, _: Instant, buffer: &'b mut [u8]) -> Option<Action<'b, Heard>> {
        if let Some(answer) = self.answer.take() {
            buffer[..answer.len()].copy_from_slice(&answer);
            return Some(Action::Transmit(&buffer[..answer.len()]));
        }
        self.event.take().map(Action::Event)
    }

    fn deadline(&self) -> Option<Deadline> {
        self.until.map(|at| Deadline { at, why: "the test" })
    }
}

/// Runs it until it has heard so much.
fn run(port: &mut EthernetPort, machine: &mut Answering, count: usize) -> Vec<Heard> {
    let mut all = Vec::new();
    drive(machine, port, |_, _, event| {
        all.push(event);
        if all.len() == count { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })
    .unwrap();
    all
}

fn text(words: &str) -> Heard {
    Heard::Frame(words.as_bytes().to_vec())
}

const NOT_SENT: Heard = Heard::Link(LinkEvent::NotSent);
const PATIENT: Options<'static> = Options { answer_within: Some(Duration::from_secs(60)), ..OPTIONS };

#[test]
#[ignore = "needs a namespace"]
fn of_a_backlog_all_is_heard_and_the_last_is_answered() {
    let cable = Cable::new("back0", "back1");
    let (mut station, mut asker) = (port(cable.0, PATIENT), port(cable.1, OPTIONS));
    for question in ["one", "two", "three"] {
        asker.transmit(&frame(question.as_bytes())).unwrap();
    }
    let all = run(&mut station, &mut Answering::default(), 5);
    assert_eq!(all, [text("one"), NOT_SENT, text("two"), NOT_SENT, text("three")]);
    assert_eq!(heard(&mut asker), Heard::Frame(frame(b"answer to three")));
    silent(&mut asker);
}

#[test]
#[ignore = "needs a namespace"]
fn a_frame_that_is_too_old_is_not_answered() {
    let cable = Cable::new("ol0", "ol1");
    let hasty = Options { answer_within: Some(Duration::from_nanos(1)), ..OPTIONS };
    let (mut station, mut asker) = (port(cable.0, hasty), port(cable.1, OPTIONS));
    asker.transmit(&frame(b"one")).unwrap();
    // Kernel time and present time are different clocks: a little later, one nanosecond is over by both.
    std::thread::sleep(Duration::from_millis(20));
    assert_eq!(run(&mut station, &mut Answering::default(), 2), [text("one"), NOT_SENT]);
    silent(&mut asker);
}

/// What a machine sends when its time has come answers nobody, however much waits.
#[test]
#[ignore = "needs a namespace"]
fn what_is_no_answer_is_sent() {
    let cable = Cable::new("na0", "na1");
    let (mut station, mut asker) = (port(cable.0, PATIENT), port(cable.1, OPTIONS));
    let mut machine = Answering { until: Some(Instant::ZERO), ..Answering::default() };
    assert_eq!(run(&mut station, &mut machine, 1), [Heard::Nothing]);
    assert_eq!(heard(&mut asker), Heard::Frame(frame(b"of its own")));
}

/// The station that decides who sends when is never late.
#[test]
#[ignore = "needs a namespace"]
fn without_a_limit_everything_is_answered() {
    let cable = Cable::new("al0", "al1");
    let (mut station, mut asker) = (port(cable.0, OPTIONS), port(cable.1, OPTIONS));
    for question in ["one", "two"] {
        asker.transmit(&frame(question.as_bytes())).unwrap();
    }
    assert_eq!(run(&mut station, &mut Answering::default(), 2), [text("one"), text("two")]);
    assert_eq!(heard(&mut asker), Heard::Frame(frame(b"answer to one")));
    assert_eq!(heard(&mut asker), Heard::Frame(frame(b"answer to two")));
}
