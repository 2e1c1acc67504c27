use super::super::connection::MOST_CLIENTS;
use super::*;
use link_core::frame::standard_id;
use std::io::{Read as _, Write as _};
use std::net::TcpStream;

struct Telnet(TcpStream);

impl Telnet {
    fn connect(server: &Server) -> Self {
        let stream = TcpStream::connect(server.address()).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.set_write_timeout(Some(PATIENCE)).unwrap();
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

    /// Something that it was sent has come, or the end of the connection.
    fn has_news(&self) -> bool {
        self.0.set_nonblocking(true).unwrap();
        let peeked = self.0.peek(&mut [0]);
        self.0.set_nonblocking(false).unwrap();
        !peeked.is_err_and(|error| error.kind() == io::ErrorKind::WouldBlock)
    }

    /// The connection was closed, and nothing came before.
    #[track_caller]
    fn hears_the_end(&mut self) {
        assert_eq!(self.0.read(&mut [0]).unwrap(), 0);
    }
}

/// What keeps the connection of the only client alive: its threads and the server.
fn connection(server: &Server) -> Weak<Connection> {
    server.clients.values().map(|client| Arc::downgrade(&client.connection)).next().unwrap()
}

/// Runs the server until a client has something sent, or `until` holds. What holds must go on to hold: the server does much
/// in one turn.
#[track_caller]
fn run(server: &mut Server, until: impl Fn(&Server) -> bool) -> Vec<Outgoing> {
    for _ in 0..MOST_TURNS {
        if until(server) {
            return Vec::new();
        }
        let outgoing = server.wait(TURN, || Instant::from_millis(1_500));
        if !outgoing.is_empty() {
            return outgoing;
        }
    }
    panic!("it did not happen in {MOST_TURNS} turns");
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
    server.lost(Instant::from_millis(1_501), sent.client, 0x1, "the frame was not sent");
    one.hears("< hi >< ok >< ok >< echo >< frame 123 1.500000 42 >");
    other.hears("< hi >< ok >< ok >");
    // It has said something since it entered raw mode, so that nothing is kept back.
    other.hears("< error 001 1.501000 >");
}

/// An answer and the frames behind it may come in one TCP segment, and a command in several: only the brackets count.
#[test]
fn a_client_that_reads_byte_by_byte_finds_every_line() {
    let mut server = bind();
    let mut client = Telnet::connect(&server);
    client.says("< open can0 >< raw");
    client.says("mode >< echo >< send 124 0 >");
    assert_eq!(run(&mut server, |_| false).len(), 1);
    let frame = Frame::new(standard_id(0x123), &[0x42]).unwrap();
    for _ in 0..3 {
        server.frame(Instant::ZERO, 0, &frame, None);
    }
    let mut lines = vec![String::new()];
    while lines.len() <= 7 {
        let mut byte = [0];
        client.0.read_exact(&mut byte).unwrap();
        lines.last_mut().unwrap().push(char::from(byte[0]));
        if byte == *b">" {
            lines.push(String::new());
        }
    }
    let heard = "< frame 123 0.000000 42 >";
    assert_eq!(lines, ["< hi >", "< ok >", "< ok >", "< echo >", heard, heard, heard, ""]);
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
    let connection = connection(&server);
    let frame = Frame::new(standard_id(0x123), &[0; 8]).unwrap();
    for _ in 0..2_000_000 {
        server.frame(Instant::ZERO, 0, &frame, None);
        if server.clients.is_empty() {
            // Its threads have ended too, although it neither reads nor closes.
            run(&mut server, |_| connection.strong_count() == 0);
            let complaints = server.complaints();
            let words: Vec<&str> = complaints.values().map(|complaint| complaint.words.as_str()).collect();
            assert_eq!(words, ["dropped, because it does not read what it is sent"]);
            return;
        }
    }
    panic!("what is to be written piles up without bound");
}

#[test]
fn a_client_that_opens_no_bus_is_let_go() {
    let mut server = bind();
    let mut silent = Telnet::connect(&server);
    run(&mut server, |server| !server.clients.is_empty());
    let connection = connection(&server);
    let end = Instant::from_millis(1_500) + HANDSHAKE;
    assert_eq!(server.deadline(), Some(end));
    // That it says something now and then is not enough.
    silent.says("< echo >");
    silent.hears("< hi >");
    run(&mut server, |_| silent.has_news());
    silent.hears("< echo >");
    server.wait(Duration::ZERO, || end);
    silent.hears("< error no bus was opened in time >");
    silent.hears_the_end();
    run(&mut server, |_| connection.strong_count() == 0);
}

#[test]
fn a_client_that_was_let_go_is_not_listened_to() {
    let mut server = bind();
    let mut lost = Telnet::connect(&server);
    lost.says("< open nowhere >< open can0 >< rawmode >< send 124 0 >");
    assert_eq!(run(&mut server, |_| lost.has_news()), []);
    lost.hears("< hi >");
    assert_eq!(run(&mut server, |_| lost.has_news()), []);
    lost.hears("< error no such bus, there is can0 >");
    lost.hears_the_end();
    run(&mut server, |server| server.leaving.is_empty());
    assert_eq!(server.deadline(), None);
}

#[test]
fn what_cannot_be_told_in_raw_mode_is_a_complaint() {
    let mut server = bind();
    let mut bad = Telnet::connect(&server);
    bad.says("< open can0 >< rawmode >< send 9 >< send 123 9 >< echo >< send 124 0 >");
    assert_eq!(run(&mut server, |_| false).len(), 1);
    bad.hears("< hi >< ok >< ok >< echo >");
    let complaint = Complaint { channel: Some(0), words: "a length is missing".to_owned(), more: 1 };
    assert_eq!(server.complaints(), BTreeMap::from([(ClientId(1), complaint)]));
    assert_eq!(server.complaints(), BTreeMap::new());
}

#[test]
fn no_more_clients_than_there_are_seats() {
    let mut server = bind();
    let mut clients: Vec<Telnet> = (0..MOST_CLIENTS).map(|_| Telnet::connect(&server)).collect();
    run(&mut server, |server| server.clients.len() == MOST_CLIENTS);
    let mut late = Telnet::connect(&server);
    late.hears("< error too many clients >");
    late.hears_the_end();
    clients.iter_mut().for_each(|client| client.hears("< hi >"));

    let first = connection(&server);
    clients.remove(0);
    run(&mut server, |_| first.strong_count() == 0);
    // Its seat is free a moment later, and who comes before is sent away.
    for _ in 0..MOST_TURNS {
        let mut next = Telnet::connect(&server);
        run(&mut server, |_| next.has_news());
        if server.clients.len() == MOST_CLIENTS {
            next.hears("< hi >");
            return;
        }
    }
    panic!("the seat is not free");
}

/// What a test waits for comes within milliseconds; this is for a machine that is very busy.
const PATIENCE: Duration = Duration::from_secs(30);
const TURN: Duration = Duration::from_millis(10);
const MOST_TURNS: u32 = 3_000;
