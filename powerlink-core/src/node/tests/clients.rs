//! Clients that are silent, say the same again, or begin anew, and answers that nobody invites: by the clock, with 15 s in 0x1300.

use core::time::Duration;

use super::bench::*;
use crate::NodeId;
use crate::nmt::NmtState;
use crate::node::NodeEvent;
use crate::wire::{NmtCommandId, RequestedService};

const READ: &str = "00 00 00 04 00 02 04 00 00 00 18 10 00 00";
const SECOND: Duration = Duration::from_secs(1);
const CLOSED: NodeEvent = NodeEvent::SdoClosed { client: NodeId::MANAGING_NODE, by_timeout: false };

/// A node with an open connection.
fn opened() -> Bench {
    let mut bench = Bench::in_state(NmtState::PreOperational1, config());
    for opening in ["00 01 00 00", "01 02 00 00"] {
        bench.sdo(opening);
        bench.asks(RequestedService::UNSPECIFIED_INVITE);
    }
    bench.tells(NodeEvent::SdoOpened { client: NodeId::MANAGING_NODE });
    bench.forget();
    bench
}

/// The bytes of the sequence layer of what is sent when invited.
fn sent(bench: &mut Bench) -> Option<[u8; 2]> {
    bench.last.clear();
    bench.asks(RequestedService::UNSPECIFIED_INVITE);
    bench.last.get(18..20).map(|bytes| [bytes[0], bytes[1]])
}

/// It repeats its command, asks for acknowledges, and never says that the answer has arrived.
#[test]
fn a_client_that_acknowledges_nothing_is_given_up_however_much_it_says() {
    let mut bench = opened();
    bench.sdo(&std::format!("02 06 {READ}"));
    assert_eq!(sent(&mut bench), Some([0x06, 0x06]), "the answer");
    let mut answers = 0;
    for second in 1..=15 {
        bench.wait(SECOND);
        bench.sdo(&std::format!("02 07 {READ}"));
        match sent(&mut bench) {
            Some([0x06, 0x06]) => {}
            // The wait begins when it is sent.
            Some([0x06, 0x07]) => answers += 1,
            other => assert_eq!((second, other), (15, None)),
        }
    }
    assert_eq!(answers, 2);
    bench.tells(NodeEvent::SdoClosed { client: NodeId::MANAGING_NODE, by_timeout: true });
}

/// The time for an acknowledge begins when the last frame that can be sent is sent.
#[test]
fn what_nobody_invites_is_not_sent_again() {
    let mut bench = opened();
    bench.node.objects_mut().long = std::vec![7; 600];
    bench.sdo("02 06 00 00 00 09 00 02 04 00 00 00 00 20 00 00");
    for number in 1..=3 {
        bench.wait(14 * SECOND);
        assert_eq!(sent(&mut bench), Some([0x06, number << 2 | 2]), "frame {number}");
    }
    bench.wait(5 * SECOND - Duration::from_nanos(1));
    assert_eq!(sent(&mut bench), None);
    bench.wait(Duration::from_nanos(1));
    assert_eq!(sent(&mut bench), Some([0x06, 0x07]), "the first one again, to be acknowledged");
    bench.is(NmtState::PreOperational1);
}

#[test]
fn a_client_that_opens_anew_has_closed_its_connection() {
    let mut bench = opened();
    bench.sdo("00 01 00 00");
    bench.tells(CLOSED);
    bench.sdo("01 02 00 00");
    assert_eq!(bench.events, [NodeEvent::SdoOpened { client: NodeId::MANAGING_NODE }]);
}

#[test]
fn a_connection_that_was_never_open_is_not_closed() {
    for ends_by_time in [true, false] {
        let mut bench = Bench::in_state(NmtState::PreOperational1, config());
        bench.sdo("00 01 00 00");
        if ends_by_time {
            bench.wait(15 * SECOND);
        } else {
            bench.sdo("00 00 00 00");
        }
        assert_eq!(bench.events, []);
        bench.sdo("01 02 00 00");
        assert_eq!((&bench.events[..], bench.node.counters().sdo_ignored), (&[][..], 1));
    }
}

#[test]
fn a_reset_closes_connections() {
    for command in [NmtCommandId::RESET_CONFIGURATION, NmtCommandId::SW_RESET] {
        let mut bench = opened();
        bench.command(command);
        assert_eq!(bench.events.iter().filter(|event| **event == CLOSED).count(), 1, "{command}");
    }
}
