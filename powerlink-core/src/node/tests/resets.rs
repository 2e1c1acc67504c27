//! The transitions of the NMT state machine that begin anew (GT1 to GT12), from every state: what is forgotten and what stays.

use core::time::Duration;

use link_core::ethernet::{Action, Input, LinkEvent, Machine};

use super::bench::*;
use super::transitions::{busy, ways};
use crate::nmt::{Cause, NmtState};
use crate::wire::{Flags, NmtCommandId, RequestedService};

/// Those in which a node hears frames.
pub(super) const COMMUNICATING: [NmtState; 7] = [
    NmtState::NotActive,
    NmtState::PreOperational1,
    NmtState::PreOperational2,
    NmtState::ReadyToOperate,
    NmtState::Operational,
    NmtState::Stopped,
    NmtState::BasicEthernet,
];

/// The states of the initialisation, and the command that leads to each.
const INITIALISATION: [(NmtCommandId, NmtState); 4] = [
    (NmtCommandId::SW_RESET, NmtState::Initialising),
    (NmtCommandId::RESET_NODE, NmtState::ResetApplication),
    (NmtCommandId::RESET_COMMUNICATION, NmtState::ResetCommunication),
    (NmtCommandId::RESET_CONFIGURATION, NmtState::ResetConfiguration),
];

/// A command in each state of the initialisation, before the node goes on by itself: where it leads.
#[track_caller]
fn leads_on(command: NmtCommandId, to: [NmtState; 4]) {
    for ((first, from), to) in INITIALISATION.into_iter().zip(to) {
        let mut bench = initialising(first);
        bench.is(from);
        bench.command_undrained(command);
        assert_eq!(bench.node.state(), to, "{command} in {from}");
    }
}

fn initialising(command: NmtCommandId) -> Bench {
    let mut bench = busy(NmtState::Operational);
    bench.command_undrained(command);
    bench
}

/// Where a reset leads on to by itself.
fn initialisation(first: NmtState, cause: Cause) -> std::vec::Vec<(NmtState, Cause)> {
    let rest = [
        NmtState::Initialising,
        NmtState::ResetApplication,
        NmtState::ResetCommunication,
        NmtState::ResetConfiguration,
        NmtState::NotActive,
    ];
    let from_first = rest.into_iter().skip_while(|state| *state != first);
    from_first.enumerate().map(|(at, state)| (state, if at == 0 { cause } else { Cause::Done })).collect()
}

/// After any reset the node says nothing until it is asked, and has forgotten what waited, its clients among it.
#[track_caller]
fn is_silent_and_empty(bench: &mut Bench) {
    bench.is(NmtState::NotActive);
    bench.says_nothing();
    bench.soa();
    bench.asks(RequestedService::NMT_REQUEST_INVITE);
    bench.asks(RequestedService::UNSPECIFIED_INVITE);
    bench.sdo("0a 0a 00 00 00 04 00 02 04 00 00 00 18 10 00 00");
    bench.asks(RequestedService::UNSPECIFIED_INVITE);
    bench.says_nothing();
}

#[track_caller]
fn says_ec(bench: &mut Bench, ec: u8) {
    bench.forget();
    bench.asks(RequestedService::STATUS_REQUEST);
    let code = bench.node.state().code();
    let sent = std::mem::take(&mut bench.last);
    assert_eq!(sent[18] & 0x18, ec << 3, "EC={ec} EN=0 in {code}");
    bench.forget();
}

/// Power-on: EC is 1, EN 0, nothing is told, the error indicator is dark.
#[test]
fn gt1_power_on() {
    let mut bench = Bench::listening(config());
    assert_eq!(ways(&mut bench), initialisation(NmtState::Initialising, Cause::PowerOn));
    assert!(!bench.node.error_led());
    bench.soa();
    bench.asks(RequestedService::STATUS_REQUEST);
    bench.says("node 1 -> all: StatusResponse, NMT_PRE_OPERATIONAL_1, EC=1 EN=0, PR=0 RS=0");
    let before = bench.node.clone();
    bench.node.power_on(bench.now);
    assert!(bench.node == before, "it is powered already");
}

/// As after a power cycle, from every state.
#[test]
fn gt2_local_reset() {
    for state in COMMUNICATING {
        let mut bench = busy(state);
        bench.node.reset(bench.now);
        bench.drain();
        assert_eq!(ways(&mut bench), initialisation(NmtState::Initialising, Cause::LocalReset), "{state}");
        assert_eq!(bench.node.objects().output, 0);
        assert_eq!(bench.node.dictionary().values.cycle_length, 20_000);
        is_silent_and_empty(&mut bench);
        says_ec(&mut bench, 1);
    }
    for (command, _) in INITIALISATION {
        let mut bench = initialising(command);
        bench.node.reset(bench.now);
        bench.is(NmtState::Initialising);
    }
}

/// Nothing is sent any more, whatever comes, and no time runs.
#[test]
fn gt3_switch_off() {
    for state in COMMUNICATING {
        let mut bench = busy(state);
        bench.node.switch_off(bench.now);
        bench.drain();
        assert_eq!(ways(&mut bench), [(NmtState::Off, Cause::SwitchOff)]);
        bench.soc();
        bench.preq(Flags::DATA_VALID, &[1]);
        bench.asks(RequestedService::IDENT_REQUEST);
        bench.command(NmtCommandId::RESET_NODE);
        bench.link(LinkEvent::Down);
        bench.wait(Duration::from_secs(10));
        bench.says_nothing();
        bench.is(NmtState::Off);
        assert_eq!((bench.node.deadline(), bench.events.len()), (None, 0));
        bench.node.power_on(bench.now);
        bench.drain();
        assert_eq!(ways(&mut bench), initialisation(NmtState::Initialising, Cause::PowerOn));
    }
    for (command, _) in INITIALISATION {
        let mut bench = initialising(command);
        bench.node.switch_off(bench.now);
        bench.drain();
        bench.is(NmtState::Off);
    }
}

/// The objects of the application and all values are those of power-on; EC stays as it was.
#[test]
fn gt4_reset_node() {
    for state in COMMUNICATING {
        let mut bench = busy(state);
        bench.command(NmtCommandId::RESET_NODE);
        assert_eq!(ways(&mut bench), initialisation(NmtState::ResetApplication, Cause::ResetNode), "{state}");
        assert_eq!((bench.node.objects().output, bench.node.dictionary().values.cycle_length), (0, 20_000));
        is_silent_and_empty(&mut bench);
        says_ec(&mut bench, u8::from(!state.is_powerlink_mode()));
    }
    use NmtState::{Initialising, ResetApplication};
    leads_on(NmtCommandId::RESET_NODE, [Initialising, ResetApplication, ResetApplication, ResetApplication]);
}

/// The values are those of power-on, the objects of the application and the history stay.
#[test]
fn gt5_reset_communication() {
    for state in COMMUNICATING {
        let mut bench = busy(state);
        bench.link(LinkEvent::Down);
        bench.forget();
        bench.command(NmtCommandId::RESET_COMMUNICATION);
        let cause = Cause::ResetCommunication;
        assert_eq!(ways(&mut bench), initialisation(NmtState::ResetCommunication, cause), "{state}");
        assert_eq!((bench.node.objects().output, bench.node.dictionary().values.cycle_length), (9, 20_000));
        assert_eq!(bench.node.dictionary().history().count(), 1);
        is_silent_and_empty(&mut bench);
    }
    use NmtState::{Initialising, ResetApplication, ResetCommunication};
    let to = [Initialising, ResetApplication, ResetCommunication, ResetCommunication];
    leads_on(NmtCommandId::RESET_COMMUNICATION, to);
}

/// A PReq longer than the limit: an entry, the error indicator, and the communication begins anew.
#[test]
fn gt6_internal_communication_error() {
    for state in [NmtState::ReadyToOperate, NmtState::Operational] {
        let mut bench = busy(state);
        bench.soc();
        bench.preq(Flags::DATA_VALID, &[0; 37]);
        let cause = Cause::InternalError;
        assert_eq!(ways(&mut bench), initialisation(NmtState::ResetCommunication, cause), "{state}");
        assert!(bench.node.error_led());
        assert_eq!((bench.node.objects().output, bench.node.dictionary().values.cycle_length), (9, 20_000));
        assert_eq!(bench.node.dictionary().history().next().map(|entry| entry.code.0), Some(0x8241));
        bench.forget();
        is_silent_and_empty(&mut bench);
    }
}

/// What was downloaded stays, and counts from now on.
#[test]
fn gt7_reset_configuration() {
    for state in COMMUNICATING {
        let mut bench = busy(state);
        bench.command(NmtCommandId::RESET_CONFIGURATION);
        let cause = Cause::ResetConfiguration;
        assert_eq!(ways(&mut bench), initialisation(NmtState::ResetConfiguration, cause), "{state}");
        let length = if state.is_powerlink_mode() { 50_000 } else { 20_000 };
        assert_eq!((bench.node.objects().output, bench.node.dictionary().values.cycle_length), (9, length));
        is_silent_and_empty(&mut bench);
    }
    leads_on(NmtCommandId::RESET_CONFIGURATION, INITIALISATION.map(|(_, state)| state));
}

/// As after a power cycle: EC is 1 again.
#[test]
fn gt8_software_reset() {
    for state in COMMUNICATING {
        let mut bench = busy(state);
        bench.command(NmtCommandId::SW_RESET);
        assert_eq!(ways(&mut bench), initialisation(NmtState::Initialising, Cause::SwReset), "{state}");
        assert_eq!((bench.node.objects().output, bench.node.dictionary().values.cycle_length), (0, 20_000));
        is_silent_and_empty(&mut bench);
        says_ec(&mut bench, 1);
    }
    leads_on(NmtCommandId::SW_RESET, [NmtState::Initialising; 4]);
}

/// The steps of the initialisation, one at a time, and none of them answers.
#[test]
fn gt10_gt11_gt12_ct1_the_initialisation_goes_on_by_itself() {
    let mut bench = busy(NmtState::Operational);
    bench.command_undrained(NmtCommandId::SW_RESET);
    bench.is(NmtState::Initialising);
    let (mut seen, mut buffer) = (std::vec::Vec::new(), [0; 1514]);
    for _ in 0..20 {
        seen.push(bench.node.state());
        bench.node.input(bench.now, Input::Frame(&[0xFF; 60]));
        let action = bench.node.poll(bench.now, &mut buffer);
        assert!(!matches!(action, Some(Action::Transmit(_))), "{action:?}");
    }
    seen.dedup();
    let expected = initialisation(NmtState::Initialising, Cause::Done).into_iter().map(|(state, _)| state);
    assert!(expected.eq(seen));
}
