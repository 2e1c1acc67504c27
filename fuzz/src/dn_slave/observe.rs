//! What a slave says, against what the model says.

use cip_core::connection::{ConnectionState, IoState};
use devicenet_core::access::NetworkStatus;
use devicenet_core::slave::{Event, IoMode, SlaveEvent};
use link_core::{Action, Frame, Instant, LinkCommand, Machine, TxToken};

use super::device::index;
use super::{InFlight, Node, OUTPUT_PENDING};

impl<const DYNAMIC: usize> Node<DYNAMIC> {
    /// Fetches and judges everything that the machine wants, then compares the two.
    pub(super) fn drain(&mut self, now: Instant) {
        self.follow_access();
        for _ in 0..MOST_ACTIONS {
            let announced = self.slave.deadline().is_some_and(|deadline| deadline.why == OUTPUT_PENDING);
            let action = self.slave.poll(now);
            assert_eq!(announced, action.is_some(), "the deadline is now if and only if output is pending");
            match action {
                None => return self.compare(),
                Some(Action::Transmit(token, frame)) => self.transmit(token, &frame),
                Some(Action::Withdraw(token)) => self.withdraw(token),
                Some(Action::Link(
                    LinkCommand::SetFilter(_) | LinkCommand::Reset | LinkCommand::SetMode(_),
                )) => {}
                Some(Action::Event(event)) => {
                    assert!(!event.to_string().is_empty());
                    self.told(event);
                }
            }
        }
        panic!("more than {MOST_ACTIONS} actions at once");
    }

    fn transmit(&mut self, token: TxToken, frame: &Frame) {
        assert!(
            self.in_flight.iter().all(|other| other.token != token),
            "{frame}: two in flight with its token"
        );
        let id = frame.raw_id() as u16;
        let check = id == 0x407 | u16::from(self.model.mac) << 3 && frame.dlc() == 7;
        let sender = if check || id == 0x7EC {
            None
        } else {
            assert!(self.model.online, "{frame} off line");
            Some(self.model.transmit(id, frame.data()))
        };
        self.in_flight.push(InFlight { token, sender, asked_back: false });
        assert!(self.in_flight.len() <= self.slave.max_in_flight());
    }

    fn withdraw(&mut self, token: TxToken) {
        let frame = self.in_flight.iter_mut().find(|frame| frame.token == token).expect("it is in flight");
        let owed = frame.sender.is_none_or(|sender| self.model.withdraw(sender));
        assert!(owed || frame.asked_back, "the frame is wanted");
        frame.asked_back = true;
    }

    fn told(&mut self, event: Event) {
        match event {
            Event::Slave(SlaveEvent::Io { connection, to, .. }) => {
                let state = ConnectionState::from(to);
                self.states[index(connection) + 1] = state.0;
                if to == IoState::Established {
                    self.modes[index(connection)] = IoMode::Inactive;
                }
            }
            Event::Slave(SlaveEvent::Explicit { instance, to, .. }) => {
                let at = if instance == 1 { 0 } else { usize::from(instance) - 1 };
                self.states[at] = ConnectionState::from(to).0;
            }
            Event::Slave(SlaveEvent::Allocation { choice, master }) => {
                (self.choice, self.master) = (choice.bits(), master.map(devicenet_core::MacId::number));
            }
            Event::Slave(SlaveEvent::Mode(connection, mode)) => self.modes[index(connection)] = mode,
            _ => {}
        }
    }

    fn compare(&mut self) {
        let Self { slave, model, .. } = self;
        assert_eq!(model.owes(), Vec::<String>::new(), "not done");
        let explicit = core::iter::once(&model.explicit);
        let dynamic = model.dynamic.iter().map(|one| &one.connection);
        let states: Vec<u8> =
            explicit.chain(&model.io).chain(dynamic).map(|connection| connection.state as u8).collect();
        let lost = slave.counters().events_lost;
        if lost > self.lost {
            // Who is called in time is told everything. Who is not has the counter, and asks.
            assert!(self.is_late, "{lost} events were lost although the slave was called in time");
            self.lost = lost;
            self.states.clone_from(&states);
            (self.choice, self.master, self.modes) = (model.choice(), model.master, model.modes);
        }
        assert_eq!(self.states, states, "the states of the connections");
        assert_eq!((self.choice, self.master), (model.choice(), model.master), "the allocation information");
        assert!(model.master.is_some() || !model.is_io_established(), "data flow, and nobody owns the slave");
        assert_eq!(slave.application().outputs, model.outputs, "the outputs");
        assert_eq!(self.modes, model.modes, "what the outputs mean");
        if model.online {
            let open = model.dynamic.iter().any(|one| one.connection.exists());
            let expected = if model.is_io_timed_out() {
                NetworkStatus::FlashingRed
            } else if model.master.is_some() || open {
                NetworkStatus::SolidGreen
            } else {
                NetworkStatus::FlashingGreen
            };
            assert_eq!(slave.network_status(), expected);
        }
        assert_eq!(slave.counters().stray_tx_done, 0);
        assert_eq!(lost, self.lost);
    }
}

/// More than one input can lead to: every line, connection and event of a server with two connections of the UCMM.
const MOST_ACTIONS: usize = 64;
