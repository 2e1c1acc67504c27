//! What a port or an application may do wrong.

use link_core::frame::extended_id;
use link_core::link::LinkCommandKind;
use link_core::{Frame, Input, Instant, LinkEvent, Machine, TxOutcome, TxToken};
use proptest::prelude::*;

use super::super::{Access, AccessEvent, StateKind};
use super::bus::*;

#[test]
fn an_answer_to_nothing_is_counted() {
    let mut bus = Bus::standby(config());
    bus.input(Input::TxDone(Access::TOKEN, TxOutcome::Sent));
    bus.mini_who();
    bus.input(Input::TxDone(TxToken(7), TxOutcome::Sent));
    assert_eq!(bus.node.counters().stray_tx_done, 2);
    bus.is(StateKind::Standby);
}

#[test]
fn lost_frames_are_told() {
    let mut bus = Bus::online(config());
    bus.link(LinkEvent::Overrun { lost: 3 });
    bus.link(LinkEvent::Overrun { lost: 0 });
    bus.tells(AccessEvent::FramesLost { count: 3 });
    assert_eq!(bus.node.counters().frames_lost, 4);
}

#[test]
fn a_refused_filter_is_told_and_changes_nothing() {
    let mut bus = Bus::standby(config());
    bus.link(LinkEvent::Refused(LinkCommandKind::SetFilter));
    bus.tells(AccessEvent::LinkRefused(LinkCommandKind::SetFilter));
    bus.roam(OWN, 67);
    bus.is(StateKind::Hello1);
}

#[test]
fn events_that_nobody_fetches_are_counted() {
    let mut node = Bus::online(config()).node;
    for lost in 1..=9 {
        node.input(Instant::from_millis(20_000), Input::Link(LinkEvent::Overrun { lost }));
    }
    assert_eq!(node.counters().events_lost, 4);
    assert!(node.deadline().is_some_and(|deadline| deadline.why == "output pending"));
}

#[test]
fn time_that_runs_backwards_is_taken_for_the_latest() {
    let mut bus = Bus::greeting(config());
    bus.now = Instant::from_millis(5000);
    bus.acknowledges();
    bus.now = Instant::ZERO;
    bus.input(Input::Tick);
    bus.is(StateKind::Hello1);
    bus.now = Instant::from_millis(6000);
    bus.input(Input::Tick);
    bus.is(StateKind::Hello2);
}

/// The size is the price of every node: it is no accident.
#[cfg(target_pointer_width = "64")]
#[test]
fn the_size_of_the_machine() {
    assert_eq!(size_of::<Access>(), 304);
}

fn inputs() -> impl Strategy<Value = Input> {
    let near = prop::sample::select(&[HELLO_127, HELLO_67, RESPONSE_67, 0x1EFE_4433, 0x1F86_0001]);
    let id = prop_oneof![near, 0_u32..0x2000_0000].prop_map(extended_id);
    let data = (any::<[u8; 8]>(), 0_usize..=8, any::<bool>()).prop_map(|(mut data, len, own)| {
        if own {
            data[..7].copy_from_slice(&DATA[..7]);
        }
        (data, len)
    });
    prop_oneof![
        (id.clone(), data).prop_map(|(id, (data, len))| Input::Frame(Frame::new(id, &data[..len]).unwrap())),
        (id, 0_u8..16).prop_map(|(id, dlc)| Input::Frame(Frame::remote(id, dlc).unwrap())),
        prop::sample::select(&[
            Input::Tick,
            Input::Link(LinkEvent::Up),
            Input::Link(LinkEvent::Down),
            Input::Link(LinkEvent::BusOff),
            Input::Link(LinkEvent::BusError(link_core::BusErrorKind::Ack)),
            Input::Link(LinkEvent::Refused(LinkCommandKind::SetMode)),
            Input::Link(LinkEvent::Refused(LinkCommandKind::Reset)),
        ]),
    ]
}

proptest! {
    /// Whatever the bus and the port do, the node keeps to the rules that [`Bus`] checks of every action: nothing at a bit
    /// rate that was not confirmed, one frame in flight, only what its state may say, and the table of transitions.
    #[test]
    fn nothing_makes_it_break_its_rules(
        steps in prop::collection::vec((inputs(), 0_u64..2000, 0_u8..4), 1..200),
        is_manager: bool,
        boi: bool,
    ) {
        let mut config = if is_manager { manager() } else { config() };
        config.bus_off_interrupt = boi;
        config.announcement = 700;
        let mut bus = Bus::dark(config);
        for (input, millis, answer) in steps {
            bus.input(input);
            bus.obeys(answer);
            bus.wait(millis);
            prop_assert!(bus.node.deadline().is_none_or(|deadline| deadline.at >= bus.now));
        }
    }
}
