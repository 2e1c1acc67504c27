//! The sequence layer of SDO: frames that get lost, come twice, in another order, or in a connection that is not where they think it is.

use core::time::Duration;

use super::bench::*;
use crate::NodeId;
use crate::nmt::NmtState;
use crate::node::NodeEvent;
use crate::wire::RequestedService;

/// Writes 0x6200/1, as the frame with a number: `02 06 ..` is the first one.
fn write(receive: u8, send: u8, value: u8) -> std::string::String {
    let transaction = send >> 2;
    std::format!(
        "{receive:02x} {send:02x} 00 00 00 {transaction:02x} 00 01 05 00 00 00 00 62 01 00 {value:02x}"
    )
}

fn closed() -> Bench {
    let mut bench = Bench::in_state(NmtState::PreOperational1, config());
    bench.forget();
    bench
}

fn opening() -> Bench {
    let mut bench = closed();
    bench.sdo("00 01");
    answers(&mut bench, "rcon=1/0 scon=1/0");
    bench
}

fn open() -> Bench {
    let mut bench = opening();
    bench.sdo("01 02");
    answers(&mut bench, "rcon=2/0 scon=2/0");
    bench.forget();
    bench
}

#[track_caller]
fn answers(bench: &mut Bench, words: &str) {
    bench.asks(RequestedService::UNSPECIFIED_INVITE);
    bench.says(&std::format!("node 1 -> MN: SDO, {words}"));
}

#[track_caller]
fn answers_nothing(bench: &mut Bench) {
    bench.asks(RequestedService::UNSPECIFIED_INVITE);
    bench.says_nothing();
}

/// How often 0x6200/1 was written since the last look, and what it is.
fn written(bench: &mut Bench) -> (usize, u8) {
    let count = bench.events.iter().filter(|event| matches!(event, NodeEvent::ObjectWritten(_))).count();
    bench.events.clear();
    (count, bench.node.objects().output)
}

const WRITTEN: &str = "WriteByIndex response, transaction";

/// Frame 2 comes before frame 1, or frame 1 does not come at all: frame 2 is not taken, and what is missing is asked for with rcon 3
/// and the number of the last good one.
#[test]
fn lost_and_out_of_order() {
    let mut bench = open();
    for _ in 0..2 {
        bench.sdo(&write(0x02, 0x0A, 2));
        assert_eq!(written(&mut bench), (0, 0));
        answers(&mut bench, "rcon=3/0 scon=2/0");
    }
    bench.sdo(&write(0x02, 0x06, 1));
    assert_eq!(written(&mut bench), (1, 1));
    answers(&mut bench, &std::format!("rcon=2/1 scon=2/1, {WRITTEN} 1, 0 bytes"));
    bench.sdo(&write(0x06, 0x0A, 2));
    assert_eq!(written(&mut bench), (1, 2));
    answers(&mut bench, &std::format!("rcon=2/2 scon=2/2, {WRITTEN} 2, 0 bytes"));
    assert_eq!(bench.node.counters().sdo_ignored, 2);
}

/// Of 64 numbers the next one is taken, 30 behind it are too early, and the last 32 and the present one are old.
#[test]
fn every_distance_of_a_number() {
    for received in [0, 1, 31, 62, 63] {
        for ahead in 0..64 {
            let mut bench = open();
            for number in 1..=received {
                bench.sdo(&write((number - 1) << 2 | 2, number << 2 | 2, 1));
                bench.asks(RequestedService::UNSPECIFIED_INVITE);
            }
            bench.forget();
            let number = (received + ahead) & 0x3F;
            bench.sdo(&write(received << 2 | 2, number << 2 | 2, 9));
            let count = written(&mut bench).0;
            assert_eq!(count, usize::from(ahead == 1), "{ahead} ahead of {received}");
            let words = match ahead {
                1 => std::format!("rcon=2/{number} scon=2/{number}, {WRITTEN} {number}, 0 bytes"),
                2..=31 => std::format!("rcon=3/{received} scon=2/{received}"),
                _ => {
                    answers_nothing(&mut bench);
                    continue;
                }
            };
            answers(&mut bench, &words);
        }
    }
}

/// What comes twice is carried out once. It is acknowledged if that is asked for (scon 3), and answered again if that is (rcon 3).
#[test]
fn duplicates() {
    let mut bench = open();
    bench.sdo(&write(0x02, 0x06, 1));
    bench.sdo(&write(0x02, 0x06, 1));
    assert_eq!(written(&mut bench), (1, 1));
    answers(&mut bench, &std::format!("rcon=2/1 scon=2/1, {WRITTEN} 1, 0 bytes"));
    answers_nothing(&mut bench);
    bench.node.objects_mut().output = 0;
    for _ in 0..3 {
        bench.sdo(&write(0x02, 0x06, 1));
        answers_nothing(&mut bench);
        bench.sdo(&write(0x02, 0x07, 1));
        answers(&mut bench, "rcon=2/1 scon=2/1");
        bench.sdo(&write(0x03, 0x06, 1));
        answers(&mut bench, &std::format!("rcon=2/1 scon=2/1, {WRITTEN} 1, 0 bytes"));
    }
    assert_eq!(written(&mut bench), (0, 0), "it is not written again");
    // The answer is acknowledged: there is nothing left to send again.
    bench.sdo("06 06");
    bench.sdo("07 06");
    answers_nothing(&mut bench);
}

/// The answer to the opening got lost: the client says its last word again, and so does the server.
#[test]
fn a_lost_answer_to_the_opening() {
    let mut bench = closed();
    bench.sdo("00 01");
    bench.sdo("00 01");
    answers(&mut bench, "rcon=1/0 scon=1/0");
    answers_nothing(&mut bench);
    for _ in 0..2 {
        bench.sdo("01 02");
        answers(&mut bench, "rcon=2/0 scon=2/0");
    }
    let opened = bench.events.iter().filter(|event| matches!(event, NodeEvent::SdoOpened { .. })).count();
    assert_eq!(opened, 1);
}

/// Every pair of rcon and scon with a command, in a connection that is closed, being opened, or open.
#[test]
fn connections_that_are_elsewhere() {
    for name in ["closed", "opening", "open"] {
        for rcon in 0..4 {
            for scon in 0..4 {
                let mut bench = match name {
                    "closed" => closed(),
                    "opening" => opening(),
                    _ => open(),
                };
                let ignored = bench.node.counters().sdo_ignored;
                bench.forget();
                bench.sdo(&write(rcon, 0x04 | scon, 9));
                let case = std::format!("rcon={rcon} scon={scon} while {name}");
                let is_carried_out = name == "open" && rcon >= 2 && scon >= 2;
                assert_eq!(bench.node.objects().output, if is_carried_out { 9 } else { 0 }, "{case}");
                bench.asks(RequestedService::UNSPECIFIED_INVITE);
                match (name, rcon, scon) {
                    // Whoever begins anew begins anew.
                    (_, _, 1) => bench.says("node 1 -> MN: SDO, rcon=1/1 scon=1/0"),
                    ("opening", 1, 2..) => bench.says("node 1 -> MN: SDO, rcon=2/1 scon=2/0"),
                    ("open", 2.., 2..) => bench
                        .says(&std::format!("node 1 -> MN: SDO, rcon=2/1 scon=2/1, {WRITTEN} 1, 0 bytes")),
                    ("opening", 0, 0) => bench.says_nothing(),
                    ("open", 0, 0) => {
                        let closed =
                            NodeEvent::SdoClosed { client: NodeId::MANAGING_NODE, by_timeout: false };
                        assert!(bench.events.contains(&closed), "{case}");
                        bench.says_nothing();
                    }
                    _ => {
                        bench.says_nothing();
                        assert_eq!(bench.node.counters().sdo_ignored, ignored + 1, "{case}");
                    }
                }
            }
        }
    }
}

/// 0x1300 is 15 s: a client from which nothing comes is forgotten, one that says anything is not.
#[test]
fn a_silent_client_is_forgotten() {
    let client = NodeId::MANAGING_NODE;
    let mut bench = open();
    bench.wait(Duration::from_secs(15) - Duration::from_nanos(1));
    assert_eq!(bench.events, []);
    bench.wait(Duration::from_nanos(1));
    bench.tells(NodeEvent::SdoClosed { client, by_timeout: true });
    answers_nothing(&mut bench);
    let mut bench = open();
    for _ in 0..5 {
        bench.wait(Duration::from_secs(14));
        bench.sdo("02 02");
    }
    assert_eq!(bench.events, []);
    bench.sdo(&write(0x02, 0x06, 1));
    assert_eq!(written(&mut bench), (1, 1));
}
