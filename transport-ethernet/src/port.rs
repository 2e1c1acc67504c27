//! The port.

use core::time::Duration;
use std::collections::VecDeque;
use std::os::fd::AsFd as _;

use link_core::ethernet::{Input, LinkEvent, MAX_FRAME, MacAddress, Port};
use link_core::stamps::Stamps;
use link_core::{Deadline, Instant};
use nix::errno::Errno;
use nix::poll::{PollFd, PollFlags, ppoll};
use nix::sys::time::TimeSpec;

use crate::error::Error;
use crate::interface::Interface;
use crate::socket::{Socket, io_error, is_gone};
use crate::watch::Watch;

/// What a port is for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Options<'a> {
    /// The protocol: 0x0600 and up.
    pub ethertype: u16,
    /// The groups to listen to, beside the address of the adapter and broadcasts.
    pub groups: &'a [MacAddress],
    /// How old a frame may be for its answer to be sent; that to a frame behind which another waits is not sent either. `None`:
    /// everything is sent, as by the station that decides who sends when.
    pub answer_within: Option<Duration>,
}

impl Options<'_> {
    /// A protocol without groups, whose answers are always sent.
    #[must_use]
    pub const fn new(ethertype: u16) -> Self {
        Self { ethertype, groups: &[], answer_within: None }
    }
}

/// An Ethernet interface as a [`Port`], which waits by blocking.
#[derive(Debug)]
pub struct EthernetPort {
    interface: Interface,
    ethertype: u16,
    groups: Vec<MacAddress>,
    answer_within: Option<Duration>,
    socket: Socket,
    watch: Watch,
    has_link: bool,
    /// There may be something in the socket.
    is_readable: bool,
    /// The kernel said that the interface is down: behind what is still in the socket.
    is_broken: bool,
    /// The kernel has news of the interface: behind what is still in the socket, too.
    has_news: bool,
    stamps: Stamps,
    /// Told by the kernel, not yet by us.
    events: VecDeque<(Instant, LinkEvent)>,
    /// The frame that was told last.
    told: Slot,
    /// When that came, while it is the latest input.
    answered: Option<Instant>,
    /// A frame that was received, not told yet.
    ahead: Slot,
    has_ahead: bool,
    /// What the socket has counted.
    lost: u32,
    not_sent: u64,
}

#[derive(Debug)]
struct Slot {
    bytes: Box<[u8; MAX_FRAME]>,
    len: usize,
    at: Instant,
}

impl EthernetPort {
    /// Opens an interface. One that is down, or has no cable, is waited for: the first input is
    /// [`Up`](link_core::ethernet::LinkEvent::Up).
    ///
    /// # Errors
    /// When there is no such Ethernet interface, with the names of those that there are, or when raw frames are not permitted.
    pub fn open(name: &str, options: Options<'_>) -> Result<Self, Error> {
        let Options { ethertype, groups, answer_within } = options;
        if ethertype < FIRST_ETHERTYPE {
            return Err(Error::NotAnEtherType(ethertype));
        }
        let interface = Interface::find(name)?;
        let failed =
            |what| move |source| Error::Socket { name: name.to_owned(), what, source: io_error(source) };
        let socket =
            Socket::open(interface.index(), ethertype, groups).map_err(|(what, error)| match error {
                Errno::EPERM | Errno::EACCES => Error::NoRight { name: name.to_owned(), program: program() },
                Errno::EAFNOSUPPORT | Errno::EPROTONOSUPPORT => Error::NoPacketSockets,
                error => failed(what)(error),
            })?;
        let watch = Watch::start().map_err(failed("cannot watch the interface"))?;
        let mut port = Self {
            interface,
            ethertype,
            groups: groups.to_vec(),
            answer_within,
            socket,
            watch,
            has_link: false,
            is_readable: true,
            is_broken: false,
            has_news: false,
            stamps: Stamps::start(),
            events: VecDeque::new(),
            told: Slot::new(),
            answered: None,
            ahead: Slot::new(),
            has_ahead: false,
            lost: 0,
            not_sent: 0,
        };
        // Again, for it may have changed before it was watched.
        port.interface = Interface::find(name)?;
        if port.interface.has_link() {
            port.up();
        }
        Ok(port)
    }

    /// The interface, as it was when it was last looked at.
    #[must_use]
    pub const fn interface(&self) -> &Interface {
        &self.interface
    }

    /// How many frames were not sent: each of them was told, or will be.
    #[must_use]
    pub const fn not_sent(&self) -> u64 {
        self.not_sent
    }

    /// Takes a frame ahead of its turn. Whether there is one.
    fn look_ahead(&mut self) -> Result<bool, Error> {
        while !self.has_ahead {
            let received = match self.socket.receive(&mut *self.ahead.bytes) {
                Ok(Some(received)) => received,
                Ok(None) => return Ok(false),
                // It comes once, before what was received earlier.
                Err(error) if is_gone(error) => {
                    self.is_broken = true;
                    continue;
                }
                Err(error) => return Err(self.failed("cannot receive", error)),
            };
            let at = match received.stamp {
                Some(stamp) => self.stamps.moment(stamp),
                None => self.stamps.now(),
            };
            if let Some(count) =
                received.lost.map(|lost| lost.wrapping_sub(self.lost)).filter(|count| *count > 0)
            {
                self.lost = self.lost.wrapping_add(count);
                self.lose(at, count);
            }
            if received.len > MAX_FRAME {
                self.lose(at, 1);
                continue;
            }
            (self.ahead.len, self.ahead.at) = (received.len, at);
            self.has_ahead = true;
        }
        Ok(true)
    }

    /// Losses with nothing between them are one: there may be many of them.
    fn lose(&mut self, at: Instant, more: u32) {
        match self.events.back_mut() {
            Some((_, LinkEvent::FramesLost { count })) => *count = count.saturating_add(more),
            _ => self.events.push_back((at, LinkEvent::FramesLost { count: more })),
        }
    }

    /// Whether the turn to answer the latest frame is over.
    fn is_too_late(&mut self) -> Result<bool, Error> {
        let Some((at, limit)) = self.answered.zip(self.answer_within) else { return Ok(false) };
        Ok(self.look_ahead()? || self.stamps.now().saturating_since(at) > limit)
    }

    fn withhold(&mut self) {
        self.not_sent = self.not_sent.saturating_add(1);
        self.tell(LinkEvent::NotSent);
    }

    fn tell(&mut self, event: LinkEvent) {
        let now = self.stamps.now();
        self.events.push_back((now, event));
    }

    fn up(&mut self) {
        self.has_link = true;
        self.is_readable = true;
        self.tell(LinkEvent::Up);
    }

    /// Looks at the interface. One that was unplugged comes back with another index, and gets a new socket; the socket of one
    /// that went down takes up work by itself, and has what came since.
    fn look(&mut self) -> Result<(), Error> {
        // The kernel's news may come before the socket breaks: what is left there for later would be a second loss.
        self.is_broken |= self.socket.has_broken();
        let found = Interface::find(self.interface.name()).ok();
        let is_same = found.as_ref().is_some_and(|found| found.index() == self.interface.index());
        let has_link = found.as_ref().is_some_and(Interface::has_link);
        if self.has_link && (self.is_broken || !is_same || !has_link) {
            self.has_link = false;
            self.tell(LinkEvent::Down);
        }
        (self.is_broken, self.has_news) = (false, false);
        self.interface.set_link(has_link);
        let Some(found) = found.filter(|_| has_link && !self.has_link) else { return Ok(()) };
        if found.mac() != self.interface.mac() {
            let (name, was, is) = (found.name().to_owned(), self.interface.mac(), found.mac());
            return Err(Error::OtherAddress { name, was, is });
        }
        if !is_same {
            match Socket::open(found.index(), self.ethertype, &self.groups) {
                Ok(socket) => (self.socket, self.lost) = (socket, 0),
                // It is gone again: there will be news of it.
                Err((_, error)) if is_gone(error) => return Ok(()),
                Err((what, error)) => return Err(self.failed(what, error)),
            }
        }
        self.interface = found;
        self.up();
        Ok(())
    }

    /// Waits for a frame or for news of the interface, at most so long. Whether there are news.
    fn sleep(&mut self, span: Option<Duration>) -> Result<bool, Error> {
        // A socket whose interface is gone has nothing to tell.
        let wanted = if self.has_link { PollFlags::POLLIN } else { PollFlags::empty() };
        let mut sockets =
            [PollFd::new(self.watch.as_fd(), PollFlags::POLLIN), PollFd::new(self.socket.as_fd(), wanted)];
        let count = if self.has_link { sockets.len() } else { 1 };
        let ready = match ppoll(sockets.get_mut(..count).unwrap_or_default(), span.map(TimeSpec::from), None)
        {
            Ok(_) => sockets.map(|socket| socket.any().unwrap_or(true)),
            // After a signal the caller looks at the clock again.
            Err(Errno::EINTR) => [false, false],
            Err(error) => return Err(self.failed("cannot wait for frames", error)),
        };
        let [has_news, is_readable] = ready;
        self.is_readable = is_readable && self.has_link;
        Ok(has_news)
    }

    fn failed(&self, what: &'static str, error: Errno) -> Error {
        Error::Socket { name: self.interface.name().to_owned(), what, source: io_error(error) }
    }
}

impl Port for EthernetPort {
    type Error = Error;

    fn now(&mut self) -> Instant {
        self.stamps.now()
    }

    fn transmit(&mut self, frame: &[u8]) -> Result<(), Error> {
        if !self.has_link || self.is_too_late()? {
            self.withhold();
            return Ok(());
        }
        match self.socket.send(frame) {
            Ok(()) => return Ok(()),
            Err(error) if is_gone(error) => (self.is_broken, self.is_readable) = (true, true),
            Err(Errno::ENOBUFS | Errno::EAGAIN | Errno::EMSGSIZE | Errno::EINVAL) => {}
            Err(error) => return Err(self.failed("cannot send", error)),
        }
        self.withhold();
        Ok(())
    }

    fn wait(&mut self, deadline: Option<Deadline>) -> Result<(Instant, Input<'_>), Error> {
        self.answered = None;
        loop {
            if let Some((at, event)) = self.events.pop_front() {
                return Ok((at, Input::Link(event)));
            }
            if self.has_ahead || (self.is_readable && self.look_ahead()?) {
                if !self.events.is_empty() {
                    continue;
                }
                core::mem::swap(&mut self.told, &mut self.ahead);
                self.has_ahead = false;
                self.answered = Some(self.told.at);
                let Slot { bytes, len, at } = &self.told;
                return Ok((*at, Input::Frame(bytes.get(..*len).unwrap_or_default())));
            }
            self.is_readable = false;
            if self.is_broken || self.has_news {
                self.look()?;
                continue;
            }
            let span = deadline.map(|deadline| deadline.at.saturating_since(self.stamps.now()));
            if self.sleep(span)? {
                let index = self.has_link.then_some(self.interface.index());
                self.has_news = self
                    .watch
                    .has_news_of(index)
                    .map_err(|error| self.failed("cannot watch the interface", error))?;
                continue;
            }
            let now = self.stamps.now();
            if !self.is_readable && deadline.is_some_and(|deadline| deadline.at <= now) {
                return Ok((now, Input::Tick));
            }
        }
    }
}

impl Slot {
    fn new() -> Self {
        Self { bytes: Box::new([0; MAX_FRAME]), len: 0, at: Instant::ZERO }
    }
}

/// Lets waits of this thread end when they should. The kernel may end them up to 50 us later, to join them with others.
///
/// # Errors
/// What the kernel says.
pub fn sharpen_timers() -> std::io::Result<()> {
    nix::sys::prctl::set_timerslack(1).map_err(io_error)
}

fn program() -> String {
    std::env::current_exe().map_or_else(|_| "PROGRAM".into(), |path| path.display().to_string())
}

const FIRST_ETHERTYPE: u16 = 0x0600;
