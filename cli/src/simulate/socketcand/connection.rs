//! The sockets: one thread that accepts, two for each client, and everything they have to say in one bounded channel.

use core::time::Duration;
use std::io::{self, Read as _, Write as _};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{self, JoinHandle};

use super::server::ClientId;

/// What the threads have to tell. A client comes before its bytes, and they before its end.
pub(super) enum Arrival {
    /// A client, and where lines for it go.
    Client(ClientId, Arc<Connection>, SyncSender<String>),
    /// It has said something.
    Bytes(ClientId, Vec<u8>),
    /// It will say no more.
    Gone(ClientId),
}

/// The connection to a client. Lives as long as one of its threads or the server needs it.
pub(super) struct Connection {
    stream: TcpStream,
    _seat: Seat,
}

impl Connection {
    /// The client is not listened to any more; what waits for it is still written.
    pub(super) fn stop_reading(&self) {
        let _ = self.stream.shutdown(Shutdown::Read);
    }

    /// Ends at once, and so do its threads.
    pub(super) fn cut(&self) {
        let _ = self.stream.shutdown(Shutdown::Both);
    }

    /// Until the client says no more, or the server has ended.
    fn read(&self, id: ClientId, arrivals: &SyncSender<Arrival>) {
        let mut buffer = [0; 1024];
        loop {
            let count = match (&self.stream).read(&mut buffer) {
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

    /// Until there is nothing more to say to the client, or it is cut.
    fn write(&self, lines: &Receiver<String>) {
        while let Ok(line) = lines.recv() {
            if (&self.stream).write_all(line.as_bytes()).is_err() {
                break;
            }
        }
        self.cut();
    }
}

/// One of the places for clients; free again when this is dropped.
struct Seat(Arc<AtomicUsize>);

impl Seat {
    fn take(taken: &Arc<AtomicUsize>) -> Option<Self> {
        let one_more = |taken| (taken < MOST_CLIENTS).then_some(taken + 1);
        taken.fetch_update(Ordering::AcqRel, Ordering::Acquire, one_more).ok()?;
        Some(Self(Arc::clone(taken)))
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::AcqRel);
    }
}

/// Accepts clients until it is dropped.
pub(super) struct Acceptor {
    address: SocketAddr,
    closing: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Acceptor {
    pub(super) fn start(listener: TcpListener, arrivals: SyncSender<Arrival>) -> io::Result<Self> {
        let address = listener.local_addr()?;
        let closing = Arc::new(AtomicBool::new(false));
        let reception = Reception::new(arrivals, Arc::clone(&closing));
        let accept = move || reception.accept(listener.incoming(), || thread::park_timeout(PAUSE));
        let thread = Some(thread::Builder::new().spawn(accept)?);
        Ok(Self { address, closing, thread })
    }

    /// Where it listens; the port when the system chose it.
    pub(super) const fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for Acceptor {
    fn drop(&mut self) {
        self.closing.store(true, Ordering::Release);
        // What is blocked in `accept` wakes up by a last connection; without one it ends with the program.
        if TcpStream::connect_timeout(&reachable(self.address), PAUSE).is_ok()
            && let Some(thread) = self.thread.take()
        {
            let _ = thread.join();
        }
    }
}

/// Whom an address that stands for all of the machine is reached by.
fn reachable(address: SocketAddr) -> SocketAddr {
    let ip = match address.ip() {
        IpAddr::V4(ip) if ip.is_unspecified() => Ipv4Addr::LOCALHOST.into(),
        IpAddr::V6(ip) if ip.is_unspecified() => Ipv6Addr::LOCALHOST.into(),
        ip => ip,
    };
    SocketAddr::new(ip, address.port())
}

/// Gives seats to those who come.
struct Reception {
    arrivals: SyncSender<Arrival>,
    closing: Arc<AtomicBool>,
    taken: Arc<AtomicUsize>,
    next: AtomicU64,
}

impl Reception {
    fn new(arrivals: SyncSender<Arrival>, closing: Arc<AtomicBool>) -> Self {
        Self { arrivals, closing, taken: Arc::default(), next: AtomicU64::new(1) }
    }

    /// `pause` is called when nobody can be accepted: most likely there are no descriptors left, and asking again at once
    /// would not give any.
    fn accept(&self, incoming: impl Iterator<Item = io::Result<TcpStream>>, pause: impl Fn()) {
        for stream in incoming {
            if self.closing.load(Ordering::Acquire) {
                return;
            }
            match stream {
                Ok(stream) => {
                    // One that fails, or whose threads cannot be started, is its client's loss only.
                    let _ = self.welcome(stream);
                }
                Err(_) => pause(),
            }
        }
    }

    fn welcome(&self, mut stream: TcpStream) -> io::Result<()> {
        let Some(seat) = Seat::take(&self.taken) else {
            // It has room in its buffer, so this does not block.
            return stream.write_all(b"< error too many clients >");
        };
        stream.set_nodelay(true)?;
        let id = ClientId(self.next.fetch_add(1, Ordering::Relaxed));
        let connection = Arc::new(Connection { stream, _seat: seat });
        let (lines, to_write) = sync_channel(MOST_LINES);
        let (writer, arrivals) = (Arc::clone(&connection), self.arrivals.clone());
        thread::Builder::new().spawn(move || writer.write(&to_write))?;
        thread::Builder::new().spawn(move || {
            if arrivals.send(Arrival::Client(id, Arc::clone(&connection), lines)).is_ok() {
                connection.read(id, &arrivals);
            }
        })?;
        Ok(())
    }
}

/// Clients at one time, each with two threads and a descriptor.
pub(in crate::simulate) const MOST_CLIENTS: usize = 32;
/// Lines that wait to be written to one client.
const MOST_LINES: usize = 4096;
const PAUSE: Duration = Duration::from_millis(100);

#[cfg(test)]
mod tests {
    use super::*;
    use core::cell::Cell;
    use std::sync::mpsc::RecvTimeoutError;

    #[test]
    fn without_descriptors_the_acceptor_rests_before_it_asks_again() {
        let (arrivals, _arrivals) = sync_channel(1);
        let reception = Reception::new(arrivals, Arc::default());
        let emfile = || io::Error::from_raw_os_error(24);
        let pauses = Cell::new(0);
        reception.accept((0..5).map(|_| Err(emfile())), || pauses.set(pauses.get() + 1));
        assert_eq!(pauses.get(), 5);
    }

    #[test]
    fn who_finds_no_seat_costs_no_thread_and_no_descriptor() {
        let (arrivals, arrived) = sync_channel(1);
        let reception = Reception::new(arrivals, Arc::default());
        reception.taken.store(MOST_CLIENTS, Ordering::Release);
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let mut client = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        client.set_read_timeout(Some(PATIENCE)).unwrap();
        reception.accept(listener.incoming().take(1), || unreachable!("it is accepted"));
        let mut heard = String::new();
        client.read_to_string(&mut heard).unwrap();
        assert_eq!(heard, "< error too many clients >");
        drop(reception);
        let end = arrived.recv_timeout(PATIENCE).err();
        assert_eq!(end, Some(RecvTimeoutError::Disconnected), "nobody has the other end");
    }

    const PATIENCE: Duration = Duration::from_secs(30);
}
