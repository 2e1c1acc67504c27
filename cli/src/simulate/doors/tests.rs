use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::path::Path;

use link_core::Instant;

use super::*;
use crate::simulate::build;
use crate::simulate::shared::SharedBuffer;
use crate::simulate::sight::View;
use crate::simulate::text::TextView;

/// A bus with one external node, `can0`, and one that acknowledges.
struct Bus<'a> {
    network: Network<NodeEvent>,
    server: Server,
    doors: Doors,
    observer: Observer<'a>,
    trace: SharedBuffer,
}

struct Client(TcpStream);

impl Client {
    fn says(&mut self, text: &str) {
        self.0.write_all(text.as_bytes()).unwrap();
    }

    /// The next line, without its brackets and its time.
    fn hears(&mut self) -> String {
        let mut line = String::new();
        while !line.ends_with('>') {
            let mut byte = [0];
            self.0.read_exact(&mut byte).unwrap();
            line.push(char::from(byte[0]));
        }
        let words = line.trim_matches(['<', '>', ' ']).split(' ').filter(|word| !word.contains('.'));
        words.collect::<Vec<_>>().join(" ")
    }
}

fn scenario(actions: &str) -> Scenario {
    let nodes = r#"
[bus]
duration = "1h"
[[node]]
name = "can0"
role = "external"
[[node]]
name = "ear"
role = "external"
"#;
    Scenario::parse("doors.toml", &format!("{nodes}{actions}"), Path::new("")).unwrap()
}

impl<'a> Bus<'a> {
    fn new(scenario: &'a Scenario) -> Self {
        let network = build::network(scenario, 1, true);
        let trace = SharedBuffer::default();
        let view: Box<dyn View> = Box::new(TextView::new(trace.clone(), false, &scenario.nodes));
        Self {
            server: Server::bind("127.0.0.1:0", vec!["can0".to_owned(), "ear".to_owned()]).unwrap(),
            doors: Doors::of(scenario, &network),
            observer: Observer::new(scenario, vec![view]),
            network,
            trace,
        }
    }

    /// A client of `can0` in raw mode.
    fn client(&mut self) -> Client {
        let stream = TcpStream::connect(self.server.address()).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        let mut client = Client(stream);
        client.says("< open can0 >< rawmode >< send 7FF 0 >");
        self.take(1);
        assert_eq!([client.hears(), client.hears(), client.hears()], ["hi", "ok", "ok"]);
        client
    }

    /// Waits until clients have sent so many frames; they go to the bus.
    #[track_caller]
    fn take(&mut self, frames: usize) {
        let now = self.network.now();
        let mut taken = 0;
        for _ in 0..MOST_TURNS {
            if taken >= frames {
                return;
            }
            let outgoing = self.server.wait(Duration::from_millis(10), || now);
            taken += outgoing.len();
            self.doors.take_in(&mut self.network, &mut self.server, outgoing);
        }
        panic!("{taken} of {frames} frames came");
    }

    fn run_to(&mut self, micros: u64) {
        self.network.run_until(Instant::from_micros(micros), &mut self.observer);
        self.doors.hand_out(&mut self.network, &mut self.server, &mut self.observer);
    }

    fn trace(&self) -> String {
        let mut text = Vec::new();
        self.trace.drain_into(&mut text);
        String::from_utf8(text).unwrap()
    }
}

#[test]
fn frames_that_are_lost_with_the_power_are_told_to_their_client() {
    let action =
        |at: &str, what: &str| format!("[[action]]\nat = \"{at}\"\nnode = \"can0\"\ndo = \"{what}\"\n");
    for actions in [
        action("10.1ms", "power_cycle"),
        action("10.1ms", "power_off") + &action("10.2ms", "power_on"),
        action("10.1ms", "cut") + &action("10.2ms", "plug"),
    ] {
        let scenario = scenario(&actions);
        let mut bus = Bus::new(&scenario);
        bus.run_to(5_000);
        let (mut one, mut other) = (bus.client(), bus.client());
        bus.run_to(10_000);
        assert_eq!([one.hears(), other.hears()], ["frame 7FF", "frame 7FF"]);
        one.says("< send 100 0 >< send 101 0 >< send 102 0 >");
        bus.take(3);
        bus.run_to(20_000);
        assert_eq!([one.hears(), one.hears(), one.hears()], ["error 001"; 3]);
        let trace = bus.trace();
        assert!(trace.contains("| 3 frames of client 1 not sent\n"), "{trace}");

        // It is still known whose a frame is.
        other.says("< send 200 0 >");
        bus.take(1);
        bus.run_to(30_000);
        assert_eq!(one.hears(), "frame 200");
        one.says("< send 201 0 >");
        bus.take(1);
        bus.run_to(40_000);
        assert_eq!(other.hears(), "frame 201");
    }
}

#[test]
fn what_is_sent_without_power_comes_back_as_an_error() {
    let scenario = scenario("[[action]]\nat = \"10ms\"\nnode = \"can0\"\ndo = \"power_off\"\n");
    let mut bus = Bus::new(&scenario);
    bus.run_to(5_000);
    let mut client = bus.client();
    bus.run_to(20_000);
    client.says("< send 100 0 >");
    bus.take(1);
    bus.run_to(21_000);
    assert_eq!(client.hears(), "error 001");
    assert!(bus.trace().ends_with("| 1 frame of client 1 not sent\n"));
}

#[test]
fn one_client_that_floods_does_not_use_up_the_room_of_another() {
    let scenario = scenario("");
    let mut bus = Bus::new(&scenario);
    bus.run_to(5_000);
    let (mut flood, mut other) = (bus.client(), bus.client());
    bus.run_to(10_000);
    assert_eq!([flood.hears(), other.hears()], ["frame 7FF", "frame 7FF"]);
    flood.says(&"< send 100 0 >".repeat(MOST_WAITING + 2));
    bus.take(MOST_WAITING + 2);
    other.says("< send 200 0 >");
    bus.take(1);
    assert_eq!([flood.hears(), flood.hears()], ["error 004", "error 004"]);
    bus.run_to(2_000_000);
    assert_eq!(flood.hears(), "frame 200");
    let trace = bus.trace();
    assert!(trace.contains("| 2 frames of client 1 not sent\n"), "{trace}");
}

#[test]
fn bus_off_and_restart_are_told_as_by_an_interface() {
    let fault =
        "[[fault]]\nkind = \"bit_error\"\nfrom = \"10ms\"\nto = \"50ms\"\nrate = 1.0\nnode = \"can0\"\n";
    let scenario = scenario(fault);
    let mut bus = Bus::new(&scenario);
    bus.run_to(5_000);
    let mut client = bus.client();
    bus.run_to(9_900);
    client.says("< send 100 0 >< send 101 0 >");
    bus.take(2);
    bus.run_to(500_000);
    let mut heard = vec![client.hears()];
    while heard.last().is_none_or(|last| last != "error 100") {
        heard.push(client.hears());
    }
    heard.retain(|line| line != "error 080");
    // Warning, passive, bus-off, two frames lost, restarted.
    let told = ["error 004", "error 004", "error 040", "error 001", "error 001", "error 100"];
    assert_eq!(heard, told);
}

#[test]
fn what_a_client_cannot_be_told_is_in_the_trace() {
    let scenario = scenario("");
    let mut bus = Bus::new(&scenario);
    bus.run_to(5_000);
    let mut client = bus.client();
    client.says("< send 100 1 xx >< send 100 >< send 100 0 >");
    bus.take(1);
    bus.run_to(6_000);
    assert!(bus.trace().contains("| client 1: xx is not a byte, and 1 more\n"));
}

#[test]
fn what_goes_wrong_without_end_does_not_fill_the_trace() {
    let scenario = scenario("[[action]]\nat = \"10ms\"\nnode = \"can0\"\ndo = \"power_off\"\n");
    let mut bus = Bus::new(&scenario);
    bus.run_to(5_000);
    let mut client = bus.client();
    bus.run_to(20_000);
    for round in 1..=50 {
        client.says("< send 100 0 >");
        bus.take(1);
        bus.run_to(20_000 + round * 1_000);
    }
    bus.doors.conclude(&bus.network, &mut bus.server, &mut bus.observer);
    let trace = bus.trace();
    let told: Vec<&str> = trace.lines().filter_map(|line| Some(line.split_once("| ")?.1)).collect();
    assert!(told.ends_with(&["1 frame of client 1 not sent", "49 frames of client 1 not sent"]), "{trace}");
}

/// What a client sends comes within milliseconds; this is for a machine that is very busy.
const MOST_TURNS: u32 = 3_000;
