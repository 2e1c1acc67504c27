//! Ctrl-C.

use std::time::Duration;

use link_core::frame::standard_id;
use link_core::machine::Deadline;
use link_core::{Frame, Input, Port as _, TxToken};
use rustix::process::Signal;
use transport_socketcan::SocketCanPort;

use super::process::{Ended, Process, wait_for_listeners};
use super::real_kernel::{Interface, run};

/// What a device with MAC ID 10 does when it is asked for more than who it is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Answers {
    AfterAWhile,
    Never,
}

/// A command on a bus with a device that answers requests of the explicit connection, vendor, device type and product code at once, and
/// other attributes as it is told to. The first such request interrupts the command. Gives the requests as well, by their service and
/// what follows the instance.
fn interrupted(
    bus: &Interface,
    command: &[&str],
    answers: Answers,
    mut interrupt: impl FnMut(&mut Process),
) -> (Ended, Vec<[u8; 2]>) {
    let mut port = SocketCanPort::open(bus.0).unwrap();
    let mut process = Process::start(&[command, &["--allow-tx", "--listen", "1ms"]].concat());
    let mut requests = Vec::new();
    let mut has_interrupted = false;
    while process.runs() {
        let deadline = Deadline { at: port.now() + LOOK_AFTER, why: "a look at the command" };
        let (_, input) = port.wait(Some(deadline)).unwrap();
        let request = match input {
            // To the unconnected port, or over the explicit connection.
            Input::Frame(frame) if [0x456, 0x454].map(|id| standard_id(id).into()).contains(&frame.id()) => {
                frame
            }
            _ => continue,
        };
        let [header, service, _, _, what, ..] = *request.data() else { panic!("{request}") };
        requests.push([service, what]);
        let answer = match (service, what) {
            // Body format 8/8.
            (ALLOCATE, _) => &[header, 0xCB, 0x00][..],
            (RELEASE, _) => &[header, 0xCC],
            (GET, 1..=3) => &[header, 0x8E, 0x34, 0x12],
            (GET, _) => {
                if !has_interrupted {
                    has_interrupted = true;
                    interrupt(&mut process);
                }
                if answers == Answers::Never {
                    continue;
                }
                std::thread::sleep(SLOW);
                &[header, 0x8E, 0x05, 0x00]
            }
            _ => panic!("{request}"),
        };
        port.transmit(TxToken(0), Frame::new(standard_id(0x453), answer).unwrap()).unwrap();
        while !matches!(port.wait(None).unwrap().1, Input::TxDone(..)) {}
    }
    (process.ended(), requests)
}

#[test]
#[ignore = "needs vcan"]
fn a_get_takes_the_answer_and_releases_the_connection() {
    let bus = Interface::new("vcan80");
    let (get, requests) = interrupted(&bus, &["get", bus.0, "10", "1/1/5"], Answers::AfterAWhile, |get| {
        get.signal(Signal::INT)
    });
    assert_eq!(get.code, 0, "{}", get.err);
    assert!(get.out.starts_with("node 10  Identity 1 Status: "), "{}", get.out);
    assert!(requests.ends_with(&[[GET, 5], [RELEASE, EXPLICIT]]), "{requests:02X?}");
}

#[test]
#[ignore = "needs vcan"]
fn a_scan_asks_nothing_more_and_releases_the_connection() {
    let bus = Interface::new("vcan81");
    let (scan, requests) =
        interrupted(&bus, &["scan", bus.0, "--json"], Answers::AfterAWhile, |scan| scan.signal(Signal::TERM));
    assert_eq!(scan.code, 130, "{}", scan.err);
    assert!(
        scan.out.contains(r#""mac":10,"#) && scan.out.contains(r#""vendor":4660"#),
        "what is known: {}",
        scan.out
    );
    assert!(
        scan.err.ends_with("error: interrupted before every node was asked; no connection is left\n"),
        "{}",
        scan.err
    );
    assert_eq!(requests.last(), Some(&[RELEASE, EXPLICIT]));
    assert!(requests.contains(&[GET, 4]) && !requests.contains(&[GET, 7]), "{requests:02X?}");
}

#[test]
#[ignore = "needs vcan"]
fn a_node_that_does_not_answer_is_not_waited_for_without_end() {
    let bus = Interface::new("vcan82");
    let (get, _) =
        interrupted(&bus, &["get", bus.0, "10", "1/1/5"], Answers::Never, |get| get.signal(Signal::INT));
    assert_eq!((get.out.as_str(), get.code), ("", 130), "{}", get.err);
    let words = "error: interrupted; node 10 has not answered, and may keep a connection for ten seconds\n";
    assert!(get.err.ends_with(words), "{}", get.err);
}

#[test]
#[ignore = "needs vcan"]
fn a_second_interruption_ends_at_once() {
    let bus = Interface::new("vcan83");
    let (get, _) = interrupted(&bus, &["get", bus.0, "10", "1/1/5"], Answers::Never, |get| {
        // Two signals of a kind that come close together are one.
        while get.runs() {
            get.signal(Signal::INT);
            std::thread::sleep(LOOK_AFTER);
        }
    });
    assert_eq!(get.code, 130);
    assert!(
        !get.err.contains("error:"),
        "it did not come to the words that end an interruption: {}",
        get.err
    );
}

#[test]
#[ignore = "needs vcan"]
fn a_command_that_still_listens_has_sent_nothing() {
    let bus = Interface::new("vcan84");
    let get = Process::start(&["get", bus.0, "10", "1/1/5", "--allow-tx", "--listen", "60s"]);
    wait_for_listeners(bus.0, 1);
    let get = get.interrupted();
    assert_eq!((get.out.as_str(), get.code), ("", 130), "{}", get.err);
    assert!(get.err.ends_with("error: interrupted before anything was sent\n"), "{}", get.err);
}

#[test]
#[ignore = "needs vcan"]
fn a_listener_says_what_it_has_heard() {
    let bus = Interface::new("vcan85");
    let scan = Process::start(&["scan", bus.0, "--listen", "60s", "--json"]);
    wait_for_listeners(bus.0, 1);
    run("cansend", &[bus.0, "457#00341245230000"]);
    let scan = scan.interrupted();
    assert!(scan.code == 0 && scan.out.contains("\"mac\":10"), "{} {}", scan.out, scan.err);
}

const ALLOCATE: u8 = 0x4B;
const RELEASE: u8 = 0x4C;
const GET: u8 = 0x0E;
/// The release choice of the explicit connection.
const EXPLICIT: u8 = 0x01;
/// How long a request takes the device.
const SLOW: Duration = Duration::from_millis(500);
/// How often somebody looks whether a command still runs.
const LOOK_AFTER: Duration = Duration::from_millis(50);
