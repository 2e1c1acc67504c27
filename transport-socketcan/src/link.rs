//! The port without the waiting: what the blocking and the asynchronous one have in common.

mod incoming;

use core::time::Duration;
use std::collections::VecDeque;
use std::io;
use std::os::fd::{AsFd, BorrowedFd};

use link_core::machine::TxToken;
use link_core::{Filter, FilterSet, Frame, Input, Instant, LinkCommand, LinkEvent, Mode};

use crate::error::{Error, Refusal};
use crate::frame;
use crate::interface::Interface;
use crate::outbox::Outbox;
use crate::receive::{BATCH, Message, Patience};
use crate::socket::{self, Socket};
use crate::stamp::Stamps;

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
    /// The kernel has lost frames since it was given the one that it has: the echo may be among them.
    echo_lost: Option<Instant>,
    /// A restart that the machine has heard of already, and of which the kernel has still to tell.
    restart_is_told: bool,
    retry_at: Option<Instant>,
    refusal: Option<Refusal>,
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
            socket: open(&interface, has_echo)?,
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
            echo_lost: None,
            restart_is_told: false,
            retry_at: None,
            refusal: None,
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
            // A controller that restarts says so by an error frame, which is then the second news of it.
            Ok(()) => {
                if self.state == State::BusOff {
                    self.state = State::Up;
                    self.restart_is_told = true;
                }
                if self.state == State::Up {
                    self.tell(LinkEvent::Up);
                }
            }
            Err(error) => {
                let (name, reason) = (self.interface.name().into(), error.to_string());
                self.refusal = Some(Refusal::Restart { name, reason });
                self.tell(LinkEvent::Refused(link_core::link::LinkCommandKind::Reset));
            }
        }
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
        [look_at, self.retry_at, self.echo_lost].into_iter().flatten().min()
    }

    /// Does what [`wake_at`](Self::wake_at) was for.
    pub(crate) fn wake(&mut self) -> Result<(), Error> {
        let now = self.now();
        if self.retry_at.take_if(|at| *at <= now).is_some() {
            self.hand_over()?;
        }
        if self.echo_lost.take_if(|at| *at <= now).is_some() {
            self.outbox.give_up();
            self.hand_over()?;
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
                    self.echo_lost = None;
                }
                Ok(true) => {
                    self.outbox.sent();
                    self.unheard = self.unheard.saturating_add(1);
                }
                Ok(false) => {
                    self.retry_at = Some(self.now().saturating_add(RETRY_AFTER));
                    return Ok(());
                }
                Err(error) if is_gone(&error) => {
                    self.go_down();
                    return Ok(());
                }
                Err(error) if error.kind() == io::ErrorKind::InvalidInput => self.outbox.refuse(),
                Err(source) => return Err(self.failed("cannot send", source)),
            }
        }
        Ok(())
    }

    fn let_the_echo_pass(&mut self, frame: &Frame) -> Result<(), Error> {
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

    fn go_down(&mut self) {
        self.take_the_rest();
        self.state = State::Down(self.now().saturating_add(LOOK_AGAIN_AFTER));
        (self.retry_at, self.echo_lost) = (None, None);
        // What an interface without an echo has taken is sent already.
        self.answer();
        self.outbox.drop_all();
        self.tell(LinkEvent::Down);
    }

    /// Takes up work on an interface that is up.
    fn begin(&mut self) {
        self.restart_is_told = false;
        let is_off = self.interface.is_bus_off();
        self.state = if is_off { State::BusOff } else { State::Up };
        self.tell(if is_off { LinkEvent::BusOff } else { LinkEvent::Up });
    }

    /// Whether the interface is there and up, so that the port works again.
    fn look_for_the_interface(&mut self) -> Result<bool, Error> {
        let now = self.now();
        self.state = State::Down(now.saturating_add(LOOK_AGAIN_AFTER));
        if !self.interface.is_up() || self.renew().is_err() {
            return Ok(false);
        }
        self.begin();
        Ok(true)
    }

    /// Begins with a new socket: an interface that was unplugged comes back with another index, and one that went down has
    /// left an error in the old one.
    fn renew(&mut self) -> Result<(), Error> {
        let has_echo = self.interface.has_echo();
        let socket = open(&self.interface, has_echo)?;
        if let Some(filters) = &self.filters {
            socket
                .set_filters(filters, &[])
                .map_err(|source| self.failed("cannot set the acceptance filter", source))?;
        }
        (self.socket, self.has_echo) = (socket, has_echo);
        self.generation = self.generation.wrapping_add(1);
        self.lost = 0;
        self.sent.clear();
        self.more = true;
        Ok(())
    }

    fn tell(&mut self, event: LinkEvent) {
        let now = self.now();
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

fn open(interface: &Interface, has_echo: bool) -> Result<Socket, Error> {
    let name = || interface.name().to_owned();
    let Some(index) = interface.index() else {
        return Err(Error::NoInterface { name: name(), present: Interface::names() });
    };
    Socket::open(index, has_echo).map_err(|(what, source)| match source.raw_os_error() {
        Some(libc::EAFNOSUPPORT | libc::EPROTONOSUPPORT) => Error::NoSocketCan,
        _ => Error::Socket { name: name(), what, source },
    })
}

/// Down or unplugged.
fn is_gone(error: &io::Error) -> bool {
    matches!(error.raw_os_error(), Some(libc::ENETDOWN | libc::ENODEV | libc::ENXIO))
}

/// How long a frame waits for room in the kernel's transmit queue before it is offered again: about that of seven frames at
/// 1 Mbit/s.
const RETRY_AFTER: Duration = Duration::from_millis(1);
/// How often an interface that is down is looked at.
const LOOK_AGAIN_AFTER: Duration = Duration::from_millis(100);
/// How many identifiers of own frames are let pass one by one. The kernel takes 512 filters.
const MOST_EXACT: usize = 256;
