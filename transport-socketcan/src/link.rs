//! The port without the waiting: what the blocking and the asynchronous one have in common.

mod command;
mod incoming;
mod presence;

use core::time::Duration;
use std::collections::VecDeque;
use std::io;
use std::os::fd::{AsFd, BorrowedFd};

use link_core::machine::TxToken;
use link_core::stamps::Stamps;
use link_core::{Filter, FilterSet, Frame, Input, Instant, LinkEvent};

use crate::echo::EchoWatch;
use crate::error::{Error, Refusal, Unconfirmed};
use crate::frame;
use crate::interface::Interface;
use crate::outbox::Outbox;
use crate::receive::{BATCH, Message, Patience};
use crate::socket::{self, Socket};

#[derive(Debug)]
pub(crate) struct Link {
    interface: Interface,
    socket: Socket,
    generation: u32,
    state: State,
    stamps: Stamps,
    outbox: Outbox,
    /// Told by the kernel, not yet by us.
    inputs: VecDeque<(Instant, Input)>,
    messages: Vec<Message>,
    /// There may be more in the socket than was taken.
    more: bool,
    /// Frames that were answered as sent since the socket was last looked into.
    unheard: usize,
    /// The interface tells itself what it has sent. Where it does not, the kernel's echo would only say that it took the frame.
    has_echo: bool,
    listen_only: bool,
    /// The same for good, whatever a machine asks for.
    never_send: bool,
    filters: Option<FilterSet>,
    /// What was sent under these filters: an echo has to pass them too.
    sent: Vec<Filter>,
    lost: u32,
    echo: EchoWatch,
    /// The kernel restarts the controller by itself: when to look whether it has, if it does not say so.
    restart_due: Option<Instant>,
    /// A restart that the machine has heard of already, and of which the kernel has still to tell.
    restart_is_told: bool,
    retry_at: Option<Instant>,
    refusal: Option<Refusal>,
    unconfirmed: Option<Unconfirmed>,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum State {
    Up,
    BusOff,
    /// The interface is down or gone; when to look again.
    Down(Instant),
}

impl Link {
    pub(crate) fn open(name: &str) -> Result<Self, Error> {
        let interface = Interface::find(name)?;
        let has_echo = interface.has_echo();
        let mut link = Self {
            socket: presence::open(&interface, has_echo)?,
            generation: 0,
            state: State::Down(Instant::ZERO),
            interface,
            stamps: Stamps::start(),
            outbox: Outbox::default(),
            inputs: VecDeque::new(),
            messages: Vec::with_capacity(BATCH),
            more: false,
            unheard: 0,
            has_echo,
            listen_only: false,
            never_send: false,
            filters: None,
            sent: Vec::new(),
            lost: 0,
            echo: EchoWatch::new(),
            restart_due: None,
            restart_is_told: false,
            retry_at: None,
            refusal: None,
            unconfirmed: None,
        };
        if link.interface.is_up() {
            link.begin();
        }
        Ok(link)
    }

    pub(crate) const fn interface(&self) -> &Interface {
        &self.interface
    }

    pub(crate) const fn refusal(&self) -> Option<&Refusal> {
        self.refusal.as_ref()
    }

    pub(crate) const fn unconfirmed(&self) -> Option<Unconfirmed> {
        self.unconfirmed
    }

    pub(crate) const fn never_send(&mut self) {
        self.never_send = true;
    }

    /// Counts the sockets that it had.
    #[cfg(feature = "tokio")]
    pub(crate) const fn generation(&self) -> u32 {
        self.generation
    }

    /// Whether there is an interface to receive from.
    pub(crate) const fn is_open(&self) -> bool {
        !matches!(self.state, State::Down(_))
    }

    pub(crate) const fn last(&self) -> Instant {
        self.stamps.last()
    }

    pub(crate) fn now(&mut self) -> Instant {
        self.stamps.now()
    }

    pub(crate) fn transmit(&mut self, token: TxToken, frame: Frame) -> Result<(), Error> {
        self.outbox.put(token, frame::as_sent(&frame));
        self.hand_over()
    }

    pub(crate) fn withdraw(&mut self, token: TxToken) {
        self.outbox.withdraw(token);
    }

    /// The next input, if there is one without waiting.
    pub(crate) fn next(&mut self) -> Result<Option<(Instant, Input)>, Error> {
        loop {
            if let Some(input) = self.inputs.pop_front() {
                return Ok(Some(input));
            }
            // A machine that always has something to send must hear of others all the same.
            if self.unheard >= BATCH && self.is_open() {
                self.receive(Patience::None)?;
                continue;
            }
            if let Some((token, outcome)) = self.outbox.answer() {
                return Ok(Some((self.stamps.last(), Input::TxDone(token, outcome))));
            }
            if let State::Down(look_at) = self.state {
                if self.now() < look_at || !self.look_for_the_interface()? {
                    return Ok(None);
                }
                continue;
            }
            if self.more {
                self.receive(Patience::None)?;
                continue;
            }
            return Ok(None);
        }
    }

    /// The socket is, or may be, readable.
    pub(crate) const fn readable(&mut self) {
        self.more = true;
    }

    /// When there is something to do even if nothing is received.
    pub(crate) fn wake_at(&self) -> Option<Instant> {
        let look_at = match self.state {
            State::Down(at) => Some(at),
            State::Up | State::BusOff => None,
        };
        let give_up_at = self.outbox.with_kernel().and_then(|_| self.echo.give_up_at());
        [look_at, self.retry_at, give_up_at, self.restart_due].into_iter().flatten().min()
    }

    /// Does what [`wake_at`](Self::wake_at) was for.
    pub(crate) fn wake(&mut self) -> Result<(), Error> {
        let now = self.now();
        if self.retry_at.take_if(|at| *at <= now).is_some() {
            self.hand_over()?;
        }
        if self.outbox.with_kernel().is_some() && self.echo.give_up_at().is_some_and(|at| at <= now) {
            self.outbox.give_up();
            self.unconfirmed = Some(self.echo.give_up());
            self.hand_over()?;
        }
        if self.restart_due.take_if(|at| *at <= now).is_some() {
            self.look_for_the_restart()?;
        }
        Ok(())
    }

    pub(crate) fn wait(&self, span: Option<Duration>) -> Result<(), Error> {
        // A socket whose interface is gone is always ready, with an error.
        let socket = self.is_open().then_some(&self.socket);
        socket::wait(socket, span).map_err(|source| self.failed("cannot wait for frames", source))
    }

    /// Waits for frames for some milliseconds, in one call of the kernel.
    pub(crate) fn wait_shortly(&mut self) -> Result<(), Error> {
        self.receive(Patience::Short)
    }

    fn hand_over(&mut self) -> Result<(), Error> {
        if self.state != State::Up || self.listen_only || self.never_send || self.retry_at.is_some() {
            return Ok(());
        }
        while let Some(&frame) = self.outbox.next() {
            self.let_the_echo_pass(&frame)?;
            match self.socket.send(&frame) {
                Ok(true) if self.has_echo => {
                    self.outbox.hand_over();
                    // The last known moment may be long ago, and frames that wait to be read are earlier than now.
                    self.echo.begin(self.stamps.present());
                }
                Ok(true) => {
                    self.outbox.sent();
                    self.unheard = self.unheard.saturating_add(1);
                }
                Ok(false) => {
                    self.retry_at = Some(self.now().saturating_add(RETRY_AFTER));
                    return Ok(());
                }
                Err(error) if presence::is_gone(&error) => {
                    self.go_down();
                    return Ok(());
                }
                Err(error) if error.kind() == io::ErrorKind::InvalidInput => self.outbox.refuse(),
                Err(source) => return Err(self.failed("cannot send", source)),
            }
        }
        Ok(())
    }

    fn tell(&mut self, event: LinkEvent) {
        let now = self.now();
        self.echo.hear(now, event);
        self.inputs.push_back((now, Input::Link(event)));
    }

    fn failed(&self, what: &'static str, source: io::Error) -> Error {
        Error::Socket { name: self.interface.name().into(), what, source }
    }
}

impl AsFd for Link {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }
}

/// How long a frame waits for room in the kernel's transmit queue before it is offered again: about that of seven frames at
/// 1 Mbit/s.
const RETRY_AFTER: Duration = Duration::from_millis(1);
