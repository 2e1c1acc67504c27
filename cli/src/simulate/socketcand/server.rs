//! The sockets: one thread that accepts, two for each client, and everything they have to say in one bounded channel.

use core::time::Duration;
use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream, ToSocketAddrs};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::{self, JoinHandle};

use link_core::{Frame, Instant};

use super::session::{Effect, Session};

/// A client, in the order of arrival.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(in crate::simulate) struct ClientId(u64);

/// What a client wants sent.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::simulate) struct Outgoing {
    pub(in crate::simulate) client: ClientId,
    /// The bus that it has opened, by its place in the list of names.
    pub(in crate::simulate) channel: usize,
    pub(in crate::simulate) frame: Frame,
}

/// Offers buses to socketcand clients.
pub(in crate::simulate) struct Server {
    address: SocketAddr,
    channels: Vec<String>,
    arrivals: Receiver<Arrival>,
    clients: BTreeMap<ClientId, Client>,
    next: u64,
    closing: Arc<AtomicBool>,
    acceptor: Option<JoinHandle<()>>,
}

struct Client {
    session: Session,
    stream: TcpStream,
    /// What is to be written to it; a client that lets this fill up is dropped.
    lines: SyncSender<String>,
}

enum Arrival {
    Client(TcpStream, SyncSender<String>, SyncSender<ClientId>),
    Bytes(ClientId, Vec<u8>),
    Gone(ClientId),
}

impl Server {
    /// Listens for clients of the buses with these names.
    pub(in crate::simulate) fn bind(address: impl ToSocketAddrs, channels: Vec<String>) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        let address = listener.local_addr()?;
        let (sender, arrivals) = sync_channel(MOST_ARRIVALS);
        let closing = Arc::new(AtomicBool::new(false));
        let stop = Arc::clone(&closing);
        let acceptor = thread::spawn(move || accept(&listener, &sender, &stop));
        let (clients, next) = (BTreeMap::new(), 0);
        Ok(Self { address, channels, arrivals, clients, next, closing, acceptor: Some(acceptor) })
    }

    /// Where it listens; the port when the system chose it.
    pub(in crate::simulate) const fn address(&self) -> SocketAddr {
        self.address
    }

    /// Waits for something of a client, at most `span`; then takes all that is there.
    pub(in crate::simulate) fn wait(&mut self, span: Duration, now: impl Fn() -> Instant) -> Vec<Outgoing> {
        let mut outgoing = Vec::new();
        match self.arrivals.recv_timeout(span) {
            Ok(arrival) => self.take(arrival, now(), &mut outgoing),
            Err(RecvTimeoutError::Timeout) => {}
            // The acceptor has ended; there is nothing to wait for but time.
            Err(RecvTimeoutError::Disconnected) => thread::park_timeout(span),
        }
        // Bounded: a flood of commands must not keep the bus from running.
        for _ in 0..MOST_ARRIVALS {
            let Ok(arrival) = self.arrivals.try_recv() else { break };
            self.take(arrival, now(), &mut outgoing);
        }
        self.tick(now(), &mut outgoing);
        outgoing
    }

    /// When [`wait`](Self::wait) should return at the latest, for what is to be sent in cycles.
    pub(in crate::simulate) fn deadline(&self) -> Option<Instant> {
        self.clients.values().filter_map(|client| client.session.deadline()).min()
    }

    /// A frame was on one of the buses; the client that sent it does not get it back.
    pub(in crate::simulate) fn frame(
        &mut self,
        at: Instant,
        channel: usize,
        frame: &Frame,
        sender: Option<ClientId>,
    ) {
        self.tell(channel, sender, |session, effects| session.frame(at, frame, effects));
    }

    /// An error frame was on one of the buses, of this SocketCAN class.
    pub(in crate::simulate) fn bus_error(&mut self, at: Instant, channel: usize, class: u32) {
        self.tell(channel, None, |session, effects| session.bus_error(at, class, effects));
    }

    /// A frame of this client was not sent.
    pub(in crate::simulate) fn refuse(&mut self, client: ClientId, problem: &str) {
        self.carry_out(client, vec![Effect::Reply(format!("< error {problem} >"))], &mut Vec::new());
    }

    fn tell(
        &mut self,
        channel: usize,
        except: Option<ClientId>,
        say: impl Fn(&mut Session, &mut Vec<Effect>),
    ) {
        let listening: Vec<ClientId> = (self.clients.iter())
            .filter(|(id, client)| Some(**id) != except && client.session.channel() == Some(channel))
            .map(|(id, _)| *id)
            .collect();
        for id in listening {
            let mut effects = Vec::new();
            if let Some(client) = self.clients.get_mut(&id) {
                say(&mut client.session, &mut effects);
            }
            self.carry_out(id, effects, &mut Vec::new());
        }
    }

    fn take(&mut self, arrival: Arrival, now: Instant, outgoing: &mut Vec<Outgoing>) {
        match arrival {
            Arrival::Client(stream, lines, name) => {
                let id = ClientId(self.next);
                self.next += 1;
                let greeting = match self.clients.len() < MOST_CLIENTS {
                    true => Session::GREETING,
                    false => "< error too many clients >",
                };
                let welcome = lines.try_send(greeting.to_owned()).is_ok() && name.send(id).is_ok();
                if welcome && self.clients.len() < MOST_CLIENTS {
                    let session = Session::new(self.channels.clone());
                    self.clients.insert(id, Client { session, stream, lines });
                }
            }
            Arrival::Bytes(id, bytes) => {
                let mut effects = Vec::new();
                if let Some(client) = self.clients.get_mut(&id) {
                    client.session.receive(now, &bytes, &mut effects);
                }
                self.carry_out(id, effects, outgoing);
            }
            Arrival::Gone(id) => {
                self.clients.remove(&id);
            }
        }
    }

    fn tick(&mut self, now: Instant, outgoing: &mut Vec<Outgoing>) {
        let due = |client: &Client| client.session.deadline().is_some_and(|at| at <= now);
        let ids: Vec<ClientId> =
            self.clients.iter().filter(|(_, client)| due(client)).map(|(id, _)| *id).collect();
        for id in ids {
            let mut effects = Vec::new();
            if let Some(client) = self.clients.get_mut(&id) {
                client.session.tick(now, &mut effects);
            }
            self.carry_out(id, effects, outgoing);
        }
    }

    fn carry_out(&mut self, id: ClientId, effects: Vec<Effect>, outgoing: &mut Vec<Outgoing>) {
        let Some(client) = self.clients.get_mut(&id) else { return };
        let mut stays = true;
        for effect in effects {
            match (effect, client.session.channel()) {
                (Effect::Reply(text), _) => stays &= client.lines.try_send(text).is_ok(),
                (Effect::Send(frame), Some(channel)) => {
                    outgoing.push(Outgoing { client: id, channel, frame })
                }
                (Effect::Send(_), None) => {}
                (Effect::Close, _) => stays = false,
            }
        }
        if !stays {
            // Its writer says what is left and closes the connection; its reader then reports it gone.
            self.clients.remove(&id);
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.closing.store(true, Ordering::Release);
        // What is blocked in `accept` wakes up by a last connection.
        let _ = TcpStream::connect(self.address);
        for client in self.clients.values() {
            let _ = client.stream.shutdown(Shutdown::Both);
        }
        if let Some(acceptor) = self.acceptor.take() {
            let _ = acceptor.join();
        }
    }
}

fn accept(listener: &TcpListener, arrivals: &SyncSender<Arrival>, closing: &AtomicBool) {
    for stream in listener.incoming() {
        if closing.load(Ordering::Acquire) {
            return;
        }
        // One connection that fails, or whose threads cannot be started, is its client's loss only.
        if let Ok(stream) = stream {
            let _ = welcome(stream, arrivals);
        }
    }
}

fn welcome(stream: TcpStream, arrivals: &SyncSender<Arrival>) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
    let (reader, writer) = (stream.try_clone()?, stream.try_clone()?);
    let (lines, to_write) = sync_channel(MOST_LINES);
    let (name, named) = sync_channel(1);
    thread::Builder::new().spawn(move || write(writer, &to_write))?;
    let arrivals = arrivals.clone();
    thread::Builder::new().spawn(move || {
        if arrivals.send(Arrival::Client(stream, lines, name)).is_ok()
            && let Ok(id) = named.recv()
        {
            read(reader, id, &arrivals);
        }
    })?;
    Ok(())
}

/// Until the client closes, or the server has ended.
fn read(mut stream: TcpStream, id: ClientId, arrivals: &SyncSender<Arrival>) {
    let mut buffer = [0; 1024];
    loop {
        let count = match stream.read(&mut buffer) {
            Ok(0) => break,
            Ok(count) => count,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(_) => break,
        };
        // Blocks while the channel is full: the client then waits in its own `send`.
        if arrivals.send(Arrival::Bytes(id, buffer[..count].to_vec())).is_err() {
            return;
        }
    }
    let _ = arrivals.send(Arrival::Gone(id));
}

/// Until there is nothing more to say to the client, or it does not listen.
fn write(mut stream: TcpStream, lines: &Receiver<String>) {
    while let Ok(line) = lines.recv() {
        if stream.write_all(line.as_bytes()).is_err() {
            break;
        }
    }
    let _ = stream.shutdown(Shutdown::Both);
}

const MOST_CLIENTS: usize = 32;
/// Chunks of at most 1 KiB that wait to be looked at.
const MOST_ARRIVALS: usize = 256;
/// Lines that wait to be written to one client.
const MOST_LINES: usize = 4096;
const WRITE_TIMEOUT: Duration = Duration::from_secs(5);

#[cfg(test)]
mod tests {
    use super::*;
    use link_core::frame::standard_id;

    struct Telnet(TcpStream);

    impl Telnet {
        fn connect(server: &Server) -> Self {
            let stream = TcpStream::connect(server.address()).unwrap();
            stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
            Self(stream)
        }

        fn says(&mut self, text: &str) {
            self.0.write_all(text.as_bytes()).unwrap();
        }

        #[track_caller]
        fn hears(&mut self, text: &str) {
            let mut buffer = vec![0; text.len()];
            self.0.read_exact(&mut buffer).unwrap();
            assert_eq!(String::from_utf8(buffer).unwrap(), text);
        }
    }

    /// Runs the server until a client has something sent, or `until` holds.
    fn run(server: &mut Server, until: impl Fn(&Server) -> bool) -> Vec<Outgoing> {
        let mut outgoing = Vec::new();
        while outgoing.is_empty() && !until(server) {
            outgoing = server.wait(Duration::from_millis(10), || Instant::from_millis(1_500));
        }
        outgoing
    }

    fn bind() -> Server {
        Server::bind("127.0.0.1:0", vec!["can0".to_owned()]).unwrap()
    }

    #[test]
    fn frames_go_both_ways_and_not_back_to_their_sender() {
        let mut server = bind();
        let (mut one, mut other) = (Telnet::connect(&server), Telnet::connect(&server));
        // What comes before its frame on a connection was heard when the frame is.
        one.says("< open can0 >< rawmode >< echo >< send 124 0 >");
        assert_eq!(run(&mut server, |_| false).len(), 1);
        other.says("< open can0 >< rawmode >< send 123 1 42 >");
        let outgoing = run(&mut server, |_| false);
        let frame = Frame::new(standard_id(0x123), &[0x42]).unwrap();
        let [sent] = outgoing.as_slice() else { panic!("{outgoing:?}") };
        assert_eq!((sent.channel, sent.frame), (0, frame));
        server.frame(Instant::from_millis(1_500), 0, &frame, Some(sent.client));
        server.refuse(sent.client, "too many frames");
        one.hears("< hi >< ok >< ok >< echo >< frame 123 1.500000 42 >");
        other.hears("< hi >< ok >< ok >< error too many frames >");
    }

    #[test]
    fn rubbish_and_sudden_ends_do_not_take_it_down() {
        let mut server = bind();
        let mut bad = Telnet::connect(&server);
        bad.says("GET / HTTP/1.1\r\n\r\n");
        run(&mut server, |server| !server.clients.is_empty());
        bad.hears("< hi >");
        drop(bad);
        run(&mut server, |server| server.clients.is_empty());
        let mut good = Telnet::connect(&server);
        good.says("< open can0 >< rawmode >< echo >< send 124 0 >");
        assert_eq!(run(&mut server, |_| false).len(), 1);
        good.hears("< hi >< ok >< ok >< echo >");
    }

    #[test]
    fn a_client_that_does_not_listen_is_dropped() {
        let mut server = bind();
        let mut deaf = Telnet::connect(&server);
        deaf.says("< open can0 >< rawmode >");
        run(&mut server, |server| server.clients.values().any(|client| client.session.channel().is_some()));
        deaf.hears("< hi >< ok >");
        run(&mut server, |server| server.clients.values().all(|client| client.session.channel() == Some(0)));
        let frame = Frame::new(standard_id(0x123), &[0; 8]).unwrap();
        for _ in 0..2_000_000 {
            server.frame(Instant::ZERO, 0, &frame, None);
            if server.clients.is_empty() {
                return;
            }
        }
        panic!("what is to be written piles up without bound");
    }

    #[test]
    fn no_more_clients_than_there_is_room_for() {
        let mut server = bind();
        let mut clients: Vec<Telnet> = (0..MOST_CLIENTS).map(|_| Telnet::connect(&server)).collect();
        run(&mut server, |server| server.clients.len() == MOST_CLIENTS);
        let mut late = Telnet::connect(&server);
        run(&mut server, |server| server.next > MOST_CLIENTS as u64);
        late.hears("< error too many clients >");
        clients[0].hears("< hi >");
    }
}
