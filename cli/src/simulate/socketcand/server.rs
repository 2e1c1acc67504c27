//! What clients and buses have to say to each other.

use core::fmt;
use core::time::Duration;
use std::collections::BTreeMap;
use std::io;
use std::net::{SocketAddr, TcpListener, ToSocketAddrs};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Weak};
use std::thread;

use link_core::{Frame, Instant};

use super::connection::{Acceptor, Arrival, Connection};
use super::session::{self, Effect, Session};

/// A client, in the order of arrival, from 1.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(in crate::simulate) struct ClientId(pub(super) u64);

/// `client 3`
impl fmt::Display for ClientId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "client {}", self.0)
    }
}

/// What a client wants sent.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::simulate) struct Outgoing {
    pub(in crate::simulate) client: ClientId,
    /// The bus that it has opened, by its place in the list of names.
    pub(in crate::simulate) channel: usize,
    pub(in crate::simulate) frame: Frame,
}

/// Something wrong with a client, of which it was not told itself.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(in crate::simulate) struct Complaint {
    /// The bus that it has opened.
    pub(in crate::simulate) channel: Option<usize>,
    /// What is wrong, and how many times more something was.
    pub(in crate::simulate) words: String,
    pub(in crate::simulate) more: u64,
}

/// Offers buses to socketcand clients.
pub(in crate::simulate) struct Server {
    acceptor: Acceptor,
    channels: Arc<[String]>,
    arrivals: Receiver<Arrival>,
    clients: BTreeMap<ClientId, Client>,
    /// Those that were let go while something is written to them yet, and when they are cut off.
    leaving: Vec<(Instant, Weak<Connection>)>,
    outgoing: Vec<Outgoing>,
    complaints: BTreeMap<ClientId, Complaint>,
}

struct Client {
    session: Session,
    connection: Arc<Connection>,
    /// What is to be written to it; a client that lets this fill up is dropped.
    lines: SyncSender<String>,
    came: Instant,
}

impl Client {
    /// When it must have opened a bus; `None` when it has.
    fn handshake_deadline(&self) -> Option<Instant> {
        self.session.channel().is_none().then(|| self.came + HANDSHAKE)
    }

    fn deadline(&self) -> Option<Instant> {
        self.session.deadline().into_iter().chain(self.handshake_deadline()).min()
    }
}

impl Server {
    /// Listens for clients of the buses with these names.
    pub(in crate::simulate) fn bind(address: impl ToSocketAddrs, channels: Vec<String>) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        let (sender, arrivals) = sync_channel(MOST_ARRIVALS);
        Ok(Self {
            acceptor: Acceptor::start(listener, sender)?,
            channels: channels.into(),
            arrivals,
            clients: BTreeMap::new(),
            leaving: Vec::new(),
            outgoing: Vec::new(),
            complaints: BTreeMap::new(),
        })
    }

    /// Where it listens; the port when the system chose it.
    pub(in crate::simulate) const fn address(&self) -> SocketAddr {
        self.acceptor.address()
    }

    /// Waits for something of a client, at most `span`; then takes all that is there.
    pub(in crate::simulate) fn wait(&mut self, span: Duration, now: impl Fn() -> Instant) -> Vec<Outgoing> {
        match self.arrivals.recv_timeout(span) {
            Ok(arrival) => self.take(arrival, now()),
            Err(RecvTimeoutError::Timeout) => {}
            // The acceptor has ended; there is nothing to wait for but time.
            Err(RecvTimeoutError::Disconnected) => thread::park_timeout(span),
        }
        // Bounded: a flood of commands must not keep the bus from running.
        for _ in 0..MOST_ARRIVALS {
            let Ok(arrival) = self.arrivals.try_recv() else { break };
            self.take(arrival, now());
        }
        self.tick(now());
        core::mem::take(&mut self.outgoing)
    }

    /// When [`wait`](Self::wait) should return at the latest, for what is to be done by itself.
    pub(in crate::simulate) fn deadline(&self) -> Option<Instant> {
        let leaving = self.leaving.iter().map(|(until, _)| *until);
        self.clients.values().filter_map(Client::deadline).chain(leaving).min()
    }

    /// A frame was on one of the buses. The client that sent it does not get it back.
    pub(in crate::simulate) fn frame(
        &mut self,
        at: Instant,
        channel: usize,
        frame: &Frame,
        sender: Option<ClientId>,
    ) {
        if let Some(client) = sender.and_then(|sender| self.clients.get_mut(&sender)) {
            client.session.sent(frame);
        }
        self.tell(at, channel, sender, |session, effects| session.frame(at, frame, effects));
    }

    /// An error frame was on one of the buses, of this SocketCAN class.
    pub(in crate::simulate) fn bus_error(&mut self, at: Instant, channel: usize, class: u32) {
        self.tell(at, channel, None, |session, effects| session.bus_error(at, class, effects));
    }

    /// A frame of this client was not sent: the SocketCAN class for it, and words.
    pub(in crate::simulate) fn lost(&mut self, at: Instant, id: ClientId, class: u32, words: &str) {
        self.with(at, id, |session, effects| session.lost(at, class, words, effects));
    }

    /// What was wrong with clients since the last time.
    pub(in crate::simulate) fn complaints(&mut self) -> BTreeMap<ClientId, Complaint> {
        core::mem::take(&mut self.complaints)
    }

    fn tell(
        &mut self,
        now: Instant,
        channel: usize,
        except: Option<ClientId>,
        say: impl Fn(&mut Session, &mut Vec<Effect>),
    ) {
        let listening: Vec<ClientId> = (self.clients.iter())
            .filter(|(id, client)| Some(**id) != except && client.session.channel() == Some(channel))
            .map(|(id, _)| *id)
            .collect();
        for id in listening {
            self.with(now, id, &say);
        }
    }

    fn take(&mut self, arrival: Arrival, now: Instant) {
        match arrival {
            Arrival::Client(id, connection, lines) => {
                let session = Session::new(Arc::clone(&self.channels));
                self.clients.insert(id, Client { session, connection, lines, came: now });
                let greeting = |_: &mut Session, effects: &mut Vec<Effect>| {
                    effects.push(Effect::Reply(Session::GREETING.to_owned()));
                };
                self.with(now, id, greeting);
            }
            Arrival::Bytes(id, bytes) => {
                self.with(now, id, |session, effects| session.receive(now, &bytes, effects));
            }
            Arrival::Gone(id) => self.let_go(now, id),
        }
    }

    fn tick(&mut self, now: Instant) {
        let due = |client: &Client| client.deadline().is_some_and(|at| at <= now);
        let ids: Vec<ClientId> =
            self.clients.iter().filter(|(_, client)| due(client)).map(|(id, _)| *id).collect();
        for id in ids {
            let is_late = |client: &Client| client.handshake_deadline().is_some_and(|at| at <= now);
            if self.clients.get(&id).is_some_and(is_late) {
                self.with(now, id, |_, effects| {
                    effects.extend([session::error("no bus was opened in time"), Effect::Close]);
                });
            } else {
                self.with(now, id, |session, effects| session.tick(now, effects));
            }
        }
        self.leaving.retain(|(until, connection)| match connection.upgrade() {
            Some(connection) if *until <= now => {
                connection.cut();
                false
            }
            Some(_) => true,
            None => false,
        });
    }

    /// Does something with a session, and what it wants.
    fn with(&mut self, now: Instant, id: ClientId, act: impl FnOnce(&mut Session, &mut Vec<Effect>)) {
        let Some(client) = self.clients.get_mut(&id) else { return };
        let mut effects = Vec::new();
        act(&mut client.session, &mut effects);
        let channel = client.session.channel();
        for effect in effects {
            match effect {
                Effect::Reply(text) => {
                    if client.lines.try_send(text).is_err() {
                        client.connection.cut();
                        self.clients.remove(&id);
                        let words = "dropped, because it does not read what it is sent".to_owned();
                        complain(&mut self.complaints, id, channel, words);
                        return;
                    }
                }
                Effect::Send(frame) => {
                    self.outgoing.extend(channel.map(|channel| Outgoing { client: id, channel, frame }));
                }
                Effect::Complain(words) => {
                    complain(&mut self.complaints, id, channel, words);
                }
                Effect::Close => {
                    self.let_go(now, id);
                    return;
                }
            }
        }
    }

    /// What waits for a client is written to it, for a while; nothing more is heard of it.
    fn let_go(&mut self, now: Instant, id: ClientId) {
        if let Some(client) = self.clients.remove(&id) {
            client.connection.stop_reading();
            self.leaving.push((now + FAREWELL, Arc::downgrade(&client.connection)));
        }
    }
}

/// The first complaint about a client is told in words, the others are counted.
fn complain(
    complaints: &mut BTreeMap<ClientId, Complaint>,
    id: ClientId,
    channel: Option<usize>,
    words: String,
) {
    complaints.entry(id).and_modify(|complaint| complaint.more += 1).or_insert(Complaint {
        channel,
        words,
        more: 0,
    });
}

impl Drop for Server {
    fn drop(&mut self) {
        // What waits for clients is still written, for a moment.
        for id in self.clients.keys().copied().collect::<Vec<_>>() {
            self.let_go(Instant::ZERO, id);
        }
        let is_open = |(_, connection): &(Instant, Weak<Connection>)| connection.strong_count() > 0;
        for _ in 0..LAST_LOOKS {
            if !self.leaving.iter().any(is_open) {
                break;
            }
            thread::park_timeout(LAST_LOOK);
        }
        for connection in self.leaving.iter().filter_map(|(_, connection)| connection.upgrade()) {
            connection.cut();
        }
    }
}

/// Chunks of at most 1 KiB that wait to be looked at.
const MOST_ARRIVALS: usize = 256;
/// How long a client may take to open a bus.
const HANDSHAKE: Duration = Duration::from_secs(30);
/// How long a client that was let go may take to read what is left.
const FAREWELL: Duration = Duration::from_secs(5);
/// How often, and how long apart, the server looks at its end whether everything is written.
const LAST_LOOKS: u32 = 100;
const LAST_LOOK: Duration = Duration::from_millis(5);

#[cfg(test)]
mod tests;
