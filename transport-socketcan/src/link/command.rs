//! What a machine asks of the controller: mode, filters, restart.

use core::time::Duration;

use link_core::{Filter, Frame, LinkCommand, LinkEvent, Mode};

use super::{Link, State};
use crate::error::{Error, Refusal};
use crate::interface::Restart;

impl Link {
    pub(crate) fn command(&mut self, command: LinkCommand) -> Result<(), Error> {
        match command {
            LinkCommand::SetMode(mode) => self.set_mode(mode),
            LinkCommand::SetFilter(filters) => {
                // An interface with a controller has still to echo the frame that it has.
                self.sent =
                    self.outbox.with_kernel().map(|frame| Filter::exact(frame.id())).into_iter().collect();
                self.filters = Some(filters);
                self.set_filters()
            }
            LinkCommand::Reset => self.reset(),
        }
    }

    fn set_mode(&mut self, mode: Mode) -> Result<(), Error> {
        self.outbox.drop_all();
        // That much can be done without any right: nothing is sent.
        self.listen_only = mode.listen_only;
        let event = match self.interface.set_mode(mode) {
            Ok(has_changed) => {
                if has_changed {
                    self.renew()?;
                }
                LinkEvent::ModeSet(mode)
            }
            Err(refusal) => {
                self.refusal = Some(refusal);
                LinkEvent::Refused(link_core::link::LinkCommandKind::SetMode)
            }
        };
        self.answer();
        self.tell(event);
        self.hand_over()
    }

    fn reset(&mut self) -> Result<(), Error> {
        self.outbox.drop_all();
        self.answer();
        match self.interface.restart() {
            Ok(Restart::Now | Restart::NotNeeded) => self.restarted(),
            // It says so by an error frame, or is looked at when it should have.
            Ok(Restart::ByItself(after)) => {
                self.restart_due = Some(self.now().saturating_add(after).saturating_add(RESTART_LATE));
            }
            Err(error) => {
                let (name, reason) = (self.interface.name().into(), error.to_string());
                self.refusal = Some(Refusal::Restart { name, reason });
                self.tell(LinkEvent::Refused(link_core::link::LinkCommandKind::Reset));
            }
        }
        self.hand_over()
    }

    /// A controller that restarts says so by an error frame, which is then the second news of it.
    fn restarted(&mut self) {
        if self.state == State::BusOff {
            self.state = State::Up;
            self.restart_is_told = true;
        }
        if self.state == State::Up {
            self.tell(LinkEvent::Up);
        }
    }

    /// Whether the kernel has restarted the controller without a word.
    pub(super) fn look_for_the_restart(&mut self) -> Result<(), Error> {
        if self.state != State::BusOff {
            return Ok(());
        }
        if self.interface.is_bus_off() {
            self.restart_due = Some(self.now().saturating_add(RESTART_LATE));
            return Ok(());
        }
        self.restarted();
        self.hand_over()
    }

    fn set_filters(&mut self) -> Result<(), Error> {
        let Some(filters) = &self.filters else { return Ok(()) };
        match self.socket.set_filters(filters, &self.sent) {
            Ok(()) => self.tell(LinkEvent::FilterSet),
            Err(error) => {
                let (name, reason) = (self.interface.name().into(), error.to_string());
                self.refusal = Some(Refusal::Filter { name, reason });
                self.filters = None;
                self.tell(LinkEvent::Refused(link_core::link::LinkCommandKind::SetFilter));
            }
        }
        Ok(())
    }

    /// Under a filter, the echo of an own frame has to pass it too.
    pub(super) fn let_the_echo_pass(&mut self, frame: &Frame) -> Result<(), Error> {
        let Some(filters) = self.filters.as_ref().filter(|_| self.has_echo) else { return Ok(()) };
        let exact = Filter::exact(frame.id());
        if filters.accepts(frame) || self.sent.iter().any(|filter| filter.accepts(frame.id())) {
            return Ok(());
        }
        if self.sent.len() < MOST_EXACT {
            self.sent.push(exact);
        } else {
            self.sent = vec![Filter::ALL_STANDARD, Filter::ALL_EXTENDED];
        }
        self.socket
            .set_filters(filters, &self.sent)
            .map_err(|source| self.failed("cannot widen the acceptance filter", source))
    }
}

/// How long after its time the restart of a kernel that does it by itself is looked for.
const RESTART_LATE: Duration = Duration::from_secs(1);
/// How many identifiers of own frames are let pass one by one. The kernel takes 512 filters.
const MOST_EXACT: usize = 256;
