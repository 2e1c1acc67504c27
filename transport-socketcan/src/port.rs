//! The blocking port.

use core::time::Duration;

use link_core::machine::{Deadline, TxToken};
use link_core::{Frame, Input, Instant, LinkCommand, Port};

use crate::error::{Error, Refusal, Unconfirmed};
use crate::interface::Interface;
use crate::link::Link;
use crate::socket::LONGEST_SHORT_WAIT;

/// A CAN interface as a [`Port`], which waits by blocking.
#[derive(Debug)]
pub struct SocketCanPort {
    pub(crate) link: Link,
}

impl SocketCanPort {
    /// A [`wait`](Port::wait) whose deadline is further away than this begins with a short wait in one call of the kernel, by which
    /// a frame that comes soon costs half as many. Who looks after something else from time to time does well to look no oftener.
    pub const ONE_CALL: Duration = Duration::from_millis(50);

    /// Opens an interface. One that is down is waited for: the first input is [`Up`](link_core::LinkEvent::Up).
    ///
    /// # Errors
    /// When there is no such CAN interface, with the names of those that there are.
    pub fn open(name: &str) -> Result<Self, Error> {
        Ok(Self { link: Link::open(name)? })
    }

    /// The same, but nothing is ever sent: what a machine transmits stays in flight until it is withdrawn. The controller still
    /// acknowledges the frames of others, unless it is listen-only itself.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_listen_only(name: &str) -> Result<Self, Error> {
        let mut port = Self::open(name)?;
        port.link.never_send();
        Ok(port)
    }

    /// The interface.
    #[must_use]
    pub const fn interface(&self) -> &Interface {
        self.link.interface()
    }

    /// Why the latest command was refused, and what to do about it.
    #[must_use]
    pub const fn refusal(&self) -> Option<&Refusal> {
        self.link.refusal()
    }

    /// Why it is not known what became of the latest frame that was answered with
    /// [`TxOutcome::Unknown`](link_core::TxOutcome::Unknown).
    #[must_use]
    pub const fn unconfirmed(&self) -> Option<Unconfirmed> {
        self.link.unconfirmed()
    }
}

impl Port for SocketCanPort {
    type Error = Error;

    fn now(&mut self) -> Instant {
        self.link.now()
    }

    fn transmit(&mut self, token: TxToken, frame: Frame) -> Result<(), Error> {
        self.link.transmit(token, frame)
    }

    fn withdraw(&mut self, token: TxToken) -> Result<(), Error> {
        self.link.withdraw(token);
        Ok(())
    }

    fn command(&mut self, command: LinkCommand) -> Result<(), Error> {
        self.link.command(command)
    }

    fn wait(&mut self, deadline: Option<Deadline>) -> Result<(Instant, Input), Error> {
        let deadline = deadline.map(|deadline| deadline.at);
        let mut has_slept = false;
        loop {
            if let Some(input) = self.link.next()? {
                return Ok(input);
            }
            let until = [deadline, self.link.wake_at()].into_iter().flatten().min();
            if !has_slept && is_far(&self.link, until) {
                self.link.wait_shortly()?;
                has_slept = true;
                continue;
            }
            let span = until.map(|until| until.saturating_since(self.link.now()));
            if span != Some(Duration::ZERO) {
                self.link.wait(span)?;
                self.link.readable();
                continue;
            }
            // What came before this moment comes first.
            self.link.readable();
            if let Some(input) = self.link.next()? {
                return Ok(input);
            }
            let now = self.link.now();
            if deadline.is_some_and(|at| at <= now) {
                return Ok((now, Input::Tick));
            }
            self.link.wake()?;
        }
    }
}

/// Whether there is time for a short wait, without asking the clock: then a frame that comes soon costs a single call of the
/// kernel. The last known moment may be some time ago, but not so long: machines take microseconds.
fn is_far(link: &Link, until: Option<Instant>) -> bool {
    link.is_open() && until.is_none_or(|until| until.saturating_since(link.last()) > SocketCanPort::ONE_CALL)
}

/// The short wait is over by then, even by the slowest clock of a kernel.
const _: () = assert!(SocketCanPort::ONE_CALL.as_millis() > 2 * LONGEST_SHORT_WAIT.as_millis());
