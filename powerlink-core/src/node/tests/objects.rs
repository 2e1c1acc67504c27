//! Objects over the network.

use super::bench::*;
use crate::dictionary::ObjectAddress;
use crate::nmt::NmtState;
use crate::node::NodeEvent;
use crate::wire::RequestedService;

fn open(bench: &mut Bench) {
    bench.sdo("00 01 00 00");
    bench.asks(RequestedService::UNSPECIFIED_INVITE);
    bench.says("node 1 -> MN: SDO, rcon=1/0 scon=1/0");
    bench.sdo("01 02 00 00");
    bench.asks(RequestedService::UNSPECIFIED_INVITE);
    bench.says("node 1 -> MN: SDO, rcon=2/0 scon=2/0");
}

#[test]
fn an_object_of_the_application_is_written_in_every_state() {
    for state in
        [NmtState::PreOperational1, NmtState::PreOperational2, NmtState::Operational, NmtState::Stopped]
    {
        let mut bench = Bench::in_state(state, config());
        open(&mut bench);
        bench.forget();
        bench.sdo("02 06 00 00 00 01 00 01 05 00 00 00 00 62 01 00 5a");
        bench.tells(NodeEvent::ObjectWritten(ObjectAddress::new(0x6200, 1)));
        assert_eq!(bench.node.objects().output, 0x5A);
        bench.says_nothing();
        bench.asks(RequestedService::UNSPECIFIED_INVITE);
        bench.says("node 1 -> MN: SDO, rcon=2/1 scon=2/1, WriteByIndex response, transaction 1, 0 bytes");
    }
}

/// In `BasicEthernet` nobody invites.
#[test]
fn without_a_managing_node_clients_are_answered_at_once() {
    let mut bench = Bench::in_state(NmtState::BasicEthernet, config());
    bench.sdo("00 01 00 00");
    bench.says("node 1 -> MN: SDO, rcon=1/0 scon=1/0");
}

/// 0x1F9E: the answer first, then the reset.
#[test]
fn a_client_resets_the_node() {
    let mut bench = Bench::in_state(NmtState::PreOperational1, config());
    open(&mut bench);
    bench.sdo("02 06 00 00 00 01 00 01 05 00 00 00 9e 1f 00 00 28");
    bench.is(NmtState::PreOperational1);
    bench.asks(RequestedService::UNSPECIFIED_INVITE);
    bench.says("node 1 -> MN: SDO, rcon=2/1 scon=2/1, WriteByIndex response, transaction 1, 0 bytes");
    bench.is(NmtState::NotActive);
}

#[test]
fn a_client_that_falls_silent_is_asked_twice_and_forgotten() {
    let mut bench = Bench::in_state(NmtState::PreOperational1, config());
    open(&mut bench);
    bench.sdo("02 06 00 00 00 01 00 02 04 00 00 00 00 10 00 00");
    for scon in [2, 3, 3] {
        bench.asks(RequestedService::UNSPECIFIED_INVITE);
        bench.says(&std::format!(
            "node 1 -> MN: SDO, rcon=2/1 scon={scon}/1, ReadByIndex response, transaction 1, 4 bytes"
        ));
        bench.forget();
        bench.wait(core::time::Duration::from_secs(5));
    }
    bench.tells(NodeEvent::SdoClosed { client: crate::NodeId::MANAGING_NODE, by_timeout: true });
}
