//! Poll: every command is answered once, run and idle, lengths, time-outs (CIP Vol. 3, I/O messaging).

use cip_core::message::AllocationChoice;
use cip_core::object::Identity;
use link_core::frame::standard_id;
use link_core::{Action, Frame, Input, Machine, TxOutcome};

use super::bus::{
    Bus, Everything, Full, G2o, MASTER, POLL, POLL_RESPONSE, REQUEST, block, config, everything,
};
use crate::Identifier;
use crate::slave::{Application, Event, Ignored, IoKind, IoMode, Options, SlaveEvent};

const ANSWER: [u8; 2] = [0x34, 0x12];

#[test]
fn every_command_is_answered_once() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    for data in [&[1][..], &[1], &[], &[], &[0]] {
        bus.hears(POLL, data);
        bus.sends(POLL_RESPONSE, &ANSWER);
        bus.sends_nothing();
    }
    assert_eq!(bus.slave.counters().produced, 5);
    bus.slave.application_mut().inputs = [7, 8];
    bus.hears(POLL, &[1]);
    bus.sends(POLL_RESPONSE, &[7, 8]);
}

#[test]
fn run_and_idle() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.hears(POLL, &[0xA5]);
    assert_eq!(bus.slave.application().outputs, [0xA5]);
    assert_eq!(bus.events, [SlaveEvent::Received(IoKind::Poll), SlaveEvent::Mode(IoKind::Poll, IoMode::Run)]);
    bus.events.clear();
    bus.hears(POLL, &[0x5A]);
    assert_eq!(bus.events, [SlaveEvent::Received(IoKind::Poll)]);
    bus.events.clear();
    bus.hears(POLL, &[]);
    assert_eq!(bus.slave.application().outputs, [0]);
    assert_eq!(bus.events, [SlaveEvent::Mode(IoKind::Poll, IoMode::Idle)]);
    bus.wait(320);
    bus.tells(SlaveEvent::Mode(IoKind::Poll, IoMode::Fault));
}

#[test]
fn a_wrong_length_is_ignored_and_keeps_nothing_alive() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.hears(POLL, &[1]);
    bus.sends(POLL_RESPONSE, &ANSWER);
    bus.events.clear();
    bus.wait(319);
    bus.hears(POLL, &[1, 2]);
    bus.sends_nothing();
    assert_eq!(
        bus.events,
        [SlaveEvent::Ignored { id: Identifier::new(POLL).unwrap(), why: Ignored::Length }]
    );
    bus.wait(1);
    bus.is_state(2, 4);
}

#[test]
fn shorter_messages_where_they_are_accepted() {
    let mut config = config();
    config.options.insert(Options::ACCEPT_SHORTER_IO);
    let mut application = everything();
    application.outputs[0] = std::vec![0; 4];
    let mut bus: Full = Bus::online(config, application).established(0x03, &[2]);
    bus.hears(POLL, &[1, 2]);
    bus.sends(POLL_RESPONSE, &ANSWER);
    assert_eq!(bus.slave.application().outputs[0], [1, 2, 0, 0]);
    bus.hears(POLL, &[1, 2, 3, 4, 5]);
    bus.sends_nothing();
}

/// A device that consumes nothing is polled without data, and that is no sign of idleness.
#[test]
fn a_device_without_outputs() {
    let mut application = everything();
    application.outputs[0].clear();
    application.inputs.clear();
    let mut bus: Full = Bus::online(config(), application).established(0x03, &[2]);
    bus.hears(POLL, &[]);
    bus.sends(POLL_RESPONSE, &[]);
    bus.tells(SlaveEvent::Mode(IoKind::Poll, IoMode::Run));
    bus.hears(POLL, &[0]);
    bus.sends_nothing();
}

#[test]
fn nothing_flows_before_the_packet_rate_is_set_and_it_is_0_until_then() {
    let mut bus = G2o::g2o().allocated(0x03);
    bus.asks(&[0x0E, 5, 2, 9], &[0x8E, 0, 0]);
    bus.hears(POLL, &[1]);
    bus.sends_nothing();
    bus.is_state(2, 1);
    bus.asks(&[0x10, 5, 2, 9, 0, 0], &[0x90, 0, 0]);
    bus.is_state(2, 3);
    bus.hears(POLL, &[1]);
    bus.sends(POLL_RESPONSE, &ANSWER);
    // With 0 it never times out.
    bus.asks(&[0x10, 5, 1, 9, 0, 0], &[0x90, 0, 0]);
    bus.wait(10_000_000);
    bus.is_state(2, 3);
}

/// The time-out is the packet rate times four, to the tick; 10 s before the first command.
#[test]
fn time_outs() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.wait(9999);
    bus.hears(POLL, &[1]);
    bus.sends(POLL_RESPONSE, &ANSWER);
    bus.wait(319);
    bus.hears(POLL, &[1]);
    bus.sends(POLL_RESPONSE, &ANSWER);
    bus.wait(319);
    assert_eq!(bus.slave.node.mode(IoKind::Poll), IoMode::Run);
    bus.wait(1);
    assert_eq!(bus.slave.node.mode(IoKind::Poll), IoMode::Fault);
    bus.hears(POLL, &[1]);
    bus.sends_nothing();
    assert_eq!(bus.slave.application().outputs, [0]);
}

/// A command at the very moment of the time-out comes before it.
#[test]
fn a_command_at_the_deadline_counts() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.hears(POLL, &[1]);
    bus.sends(POLL_RESPONSE, &ANSWER);
    bus.now += core::time::Duration::from_millis(320);
    bus.hears(POLL, &[1]);
    bus.sends(POLL_RESPONSE, &ANSWER);
    bus.now += core::time::Duration::from_nanos(320_000_001);
    bus.hears(POLL, &[1]);
    bus.sends_nothing();
    assert_eq!(bus.slave.node.mode(IoKind::Poll), IoMode::Fault, "the deadline was before the command");
}

#[test]
fn watchdog_actions() {
    for (action, state) in [(1, None), (2, Some(3))] {
        let mut bus = G2o::g2o().established(0x03, &[2]);
        bus.asks(&[0x10, 5, 2, 12, action], &[0x90]);
        bus.hears(POLL, &[1]);
        bus.sends(POLL_RESPONSE, &ANSWER);
        bus.wait(320);
        bus.tells(SlaveEvent::Mode(IoKind::Poll, IoMode::Fault));
        match state {
            Some(state) => bus.is_state(2, state),
            None => bus.asks(&[0x0E, 5, 2, 1], &[0x94, 0x16, 0xFF]),
        }
    }
}

#[test]
fn reset_brings_a_connection_back() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.hears(POLL, &[1]);
    bus.sends(POLL_RESPONSE, &ANSWER);
    bus.wait(320);
    bus.asks(&[0x05, 5, 2], &[0x85]);
    bus.is_state(2, 3);
    bus.wait(319);
    bus.hears(POLL, &[1]);
    bus.sends(POLL_RESPONSE, &ANSWER);
}

#[test]
fn release_stops_io_at_once() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.acknowledging = false;
    bus.hears(POLL, &[1]);
    bus.sends(POLL_RESPONSE, &ANSWER);
    bus.hears(POLL, &[1]);
    bus.hears(REQUEST, &[MASTER, 0x4C, 3, 1, 2]);
    assert_eq!(bus.withdrawn.len(), 1, "what is in flight is withdrawn");
    bus.done(TxOutcome::Withdrawn);
    bus.sends(super::bus::RESPONSE, &[MASTER, 0xCC]);
    bus.sends_nothing();
    assert_eq!(bus.slave.application().outputs, [0]);
    bus.tells(SlaveEvent::Mode(IoKind::Poll, IoMode::Fault));
    assert_eq!(bus.slave.counters().not_sent, 0);
}

#[test]
fn outputs_may_rest_instead_of_failing() {
    let mut config = config();
    config.options.insert(Options::IDLE_ON_RELEASE);
    let mut bus: G2o = Bus::online(config, block()).established(0x03, &[2]);
    bus.hears(POLL, &[1]);
    bus.sends(POLL_RESPONSE, &ANSWER);
    bus.asks(&[0x4C, 3, 1, 2], &[0xCC]);
    bus.tells(SlaveEvent::Mode(IoKind::Poll, IoMode::Idle));
}

/// Commands that come faster than answers can go share one.
#[test]
fn a_slow_controller() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.acknowledging = false;
    for _ in 0..4 {
        bus.hears(POLL, &[1]);
    }
    bus.sends(POLL_RESPONSE, &ANSWER);
    bus.slave.application_mut().inputs = [1, 1];
    bus.done(TxOutcome::Sent);
    bus.sends(POLL_RESPONSE, &[1, 1]);
    bus.done(TxOutcome::Dropped);
    bus.sends_nothing();
    assert_eq!(bus.slave.counters().merged, 2);
    bus.tells(SlaveEvent::NotSent {
        id: Identifier::new(POLL_RESPONSE).unwrap(),
        outcome: TxOutcome::Dropped,
    });
}

/// The second command finds its response still in flight: there is nothing to send, and one event to be fetched at once.
#[test]
fn what_was_received_alone_is_fetched_at_once() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.acknowledging = false;
    bus.hears(POLL, &[1]);
    bus.sends(POLL_RESPONSE, &ANSWER);
    let poll = Frame::new(standard_id(POLL), &[2]).unwrap();
    bus.slave.input(bus.now, Input::Frame(poll));
    let is_due = |bus: &G2o| bus.slave.deadline().is_some_and(|deadline| deadline.at <= bus.now);
    assert!(is_due(&bus));
    let received = Event::Slave(SlaveEvent::Received(IoKind::Poll));
    assert_eq!(bus.slave.poll(bus.now), Some(Action::Event(received)));
    assert!(!is_due(&bus));
    assert_eq!(bus.slave.poll(bus.now), None);
}

/// Ten bytes each way: the example of CIP Vol. 3, `00` and `81`.
#[test]
fn io_in_fragments() {
    let mut application = everything();
    application.outputs[0] = std::vec![0; 10];
    application.inputs = (1..=16).collect();
    let mut bus: Full = Bus::online(config(), application).established(0x03, &[2]);
    bus.asks(&[0x0E, 5, 2, 8], &[0x8E, 10, 0]);
    bus.hears(POLL, &[0x00, 0xA1, 0xA2, 0xA3, 0xA4, 0xA5, 0xA6, 0xA7]);
    bus.sends_nothing();
    bus.hears(POLL, &[0x81, 0xA8, 0xA9, 0xAA]);
    bus.sends(POLL_RESPONSE, &[0x00, 1, 2, 3, 4, 5, 6, 7]);
    bus.sends(POLL_RESPONSE, &[0x41, 8, 9, 10, 11, 12, 13, 14]);
    bus.sends(POLL_RESPONSE, &[0x82, 15, 16]);
    bus.sends_nothing();
    let expected = [0xA1, 0xA2, 0xA3, 0xA4, 0xA5, 0xA6, 0xA7, 0xA8, 0xA9, 0xAA];
    assert_eq!(bus.slave.application().outputs[0], expected);
    // Idle, in both forms.
    for idle in [&[][..], &[0x3F]] {
        bus.hears(POLL, idle);
        for _ in 0..3 {
            bus.skip();
        }
        assert_eq!(bus.slave.node.mode(IoKind::Poll), IoMode::Idle);
    }
}

/// No torn data: nothing is taken of a message of which a fragment is lost, repeated or of the wrong kind.
#[test]
fn damaged_io_in_fragments() {
    let mut application = everything();
    application.outputs[0] = std::vec![0; 10];
    let bus: Full = Bus::online(config(), application).established(0x03, &[2]);
    let first = &[0x00, 1, 1, 1, 1, 1, 1, 1][..];
    let last = &[0x81, 1, 1, 1][..];
    for frames in [
        &[last][..],
        &[first, &[0x82, 1, 1, 1]],
        &[first, &[0x80, 1, 1, 1]],
        &[first, first, &[0x82, 1, 1, 1]],
        &[first, &[0xC1, 0], last],
        &[first, &[0x41, 1, 1, 1, 1, 1, 1, 1], &[0x42, 1, 1, 1, 1, 1, 1, 1], &[0x43, 1, 1, 1, 1, 1, 1, 1]],
        &[&[0x02, 1]],
        &[first, &[0x81, 1, 1]],
        &[&[0x3F, 1, 1]],
    ] {
        let mut bus = bus.clone();
        for frame in frames {
            bus.hears(POLL, frame);
        }
        bus.sends_nothing();
        assert_eq!(bus.slave.application().outputs[0], [0; 10], "{frames:02X?}");
    }
}

/// What changes while fragments go out does not mix with them; a command that comes meanwhile is answered after them.
#[test]
fn fragments_are_of_one_moment() {
    let mut application = everything();
    application.inputs = (1..=9).collect();
    let mut bus: Full = Bus::online(config(), application).established(0x03, &[2]);
    bus.acknowledging = false;
    bus.hears(POLL, &[1]);
    bus.sends(POLL_RESPONSE, &[0x00, 1, 2, 3, 4, 5, 6, 7]);
    bus.slave.application_mut().inputs.fill(9);
    bus.hears(POLL, &[1]);
    bus.done(TxOutcome::Sent);
    bus.sends(POLL_RESPONSE, &[0x81, 8, 9]);
    bus.done(TxOutcome::Sent);
    bus.sends(POLL_RESPONSE, &[0x00, 9, 9, 9, 9, 9, 9, 9]);
    bus.done(TxOutcome::Dropped);
    bus.sends_nothing();
}

#[test]
fn no_valid_data() {
    let mut application = everything();
    application.inputs = std::vec![1; 9];
    let mut config = config();
    config.options.insert(Options::EMPTY_AS_3F);
    for (config, empty) in [(super::bus::config(), &[][..]), (config, &[0x3F])] {
        let mut bus: Full = Bus::online(config, application.clone()).established(0x03, &[2]);
        bus.slave.application_mut().valid = false;
        bus.hears(POLL, &[1]);
        bus.sends(POLL_RESPONSE, empty);
        bus.sends_nothing();
    }
}

/// Everything, without room for more than a frame.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
struct Short(Everything);

impl Application for Short {
    const IO: AllocationChoice = AllocationChoice::POLL;
    type Long = ();

    fn identity(&self) -> Identity<'_> {
        self.0.identity()
    }

    fn produced(&self, connection: IoKind) -> &[u8] {
        self.0.produced(connection)
    }

    fn consumed(&mut self, connection: IoKind) -> &mut [u8] {
        self.0.consumed(connection)
    }
}

/// Sizes must stay as they are. Where they do not, what has no room goes out as no valid data, and the connection lives.
#[test]
fn inputs_that_have_grown() {
    let mut short = Bus::<Short, 0>::online(config(), Short(everything())).established(0x03, &[2]);
    let mut long = Full::online(config(), everything()).established(0x03, &[2]);
    for (inputs, sent) in
        [(std::vec![5; 40], &[][..]), (std::vec![6; 4], &[6; 4]), (std::vec![7; 2], &[7; 2])]
    {
        short.slave.application_mut().0.inputs.clone_from(&inputs);
        short.hears(POLL, &[1]);
        short.sends(POLL_RESPONSE, sent);
        short.sends_nothing();
        long.slave.application_mut().inputs = inputs;
        long.hears(POLL, &[1]);
        long.sends(POLL_RESPONSE, sent);
        long.sends_nothing();
    }
}
