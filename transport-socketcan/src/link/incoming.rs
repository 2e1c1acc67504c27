//! What the kernel tells, on its way to the machine.

use link_core::{Input, Instant, LinkEvent};

use super::presence::is_gone;
use super::{Link, State};
use crate::error::Error;
use crate::error_frame;
use crate::frame;
use crate::receive::{BATCH, Message, Patience};

impl Link {
    pub(super) fn receive(&mut self, patience: Patience) -> Result<(), Error> {
        let mut messages = core::mem::take(&mut self.messages);
        messages.clear();
        let result = self.socket.receive(patience, &mut messages);
        // A full batch may not have been all.
        self.more = messages.len() >= BATCH;
        self.unheard = 0;
        messages.iter().for_each(|message| self.take(message));
        self.messages = messages;
        match result {
            Ok(()) => self.hand_over(),
            Err(error) if is_gone(&error) => {
                self.more = false;
                self.go_down();
                Ok(())
            }
            Err(source) => Err(self.failed("cannot receive", source)),
        }
    }

    fn take(&mut self, message: &Message) {
        let at = match message.stamp {
            Some(stamp) => self.stamps.moment(stamp),
            None => self.stamps.now(),
        };
        if let Some(lost) = message.lost.map(|lost| lost.wrapping_sub(self.lost)).filter(|lost| *lost > 0) {
            self.lost = self.lost.wrapping_add(lost);
            self.inputs.push_back((at, Input::Link(LinkEvent::Overrun { lost })));
            if self.outbox.with_kernel().is_some() {
                self.echo.overrun(at);
            }
        }
        match frame::from_kernel(&message.raw) {
            // An echo that nobody waits for is of a frame that was given up.
            Some(frame) if message.is_own => {
                self.echo.alive(at);
                if self.outbox.confirm(&frame) {
                    self.answer();
                }
            }
            Some(frame) => {
                self.echo.alive(at);
                self.inputs.push_back((at, Input::Frame(frame)));
            }
            None => error_frame::events(message.raw).for_each(|event| self.link_event(at, event)),
        }
    }

    fn link_event(&mut self, at: Instant, event: LinkEvent) {
        self.echo.hear(at, event);
        match event {
            LinkEvent::BusOff => self.bus_off(at),
            LinkEvent::Up => {
                if self.state == State::Up && core::mem::take(&mut self.restart_is_told) {
                    return;
                }
                // A controller restarts from bus-off only: where nothing was heard of that, the news of it was lost.
                if self.state == State::Up {
                    self.bus_off(at);
                }
                self.state = State::Up;
                self.inputs.push_back((at, Input::Link(event)));
            }
            _ => self.inputs.push_back((at, Input::Link(event))),
        }
    }

    fn bus_off(&mut self, at: Instant) {
        self.state = State::BusOff;
        self.restart_is_told = false;
        // Sent before, and dropped before the restart that may be told next.
        self.answer();
        self.inputs.push_back((at, Input::Link(LinkEvent::BusOff)));
        self.outbox.drop_all();
        self.answer();
    }

    /// Tells what became of frames behind the inputs that there are.
    pub(super) fn answer(&mut self) {
        while let Some((token, outcome)) = self.outbox.answer() {
            self.inputs.push_back((self.stamps.last(), Input::TxDone(token, outcome)));
        }
    }

    /// What the socket of an interface that has gone still holds: it came before that.
    pub(super) fn take_the_rest(&mut self) {
        let mut messages = core::mem::take(&mut self.messages);
        for _ in 0..MOST_BATCHES {
            messages.clear();
            // The error comes first, and once.
            if self.socket.receive(Patience::None, &mut messages).is_ok() && messages.is_empty() {
                break;
            }
            messages.iter().for_each(|message| self.take(message));
        }
        self.messages = messages;
    }
}

/// More than the receive buffer holds.
const MOST_BATCHES: usize = 256;
