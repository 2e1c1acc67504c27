//! What time, frames, the controller and the link do to the node.

use core::time::Duration;

use devicenet_core::access::{BusOffWhileChecking, MacIdSource, MaskPredicate};
use link_core::link::LinkCommandKind;
use link_core::{Frame, Instant, LinkEvent};

use super::state::{Controller, Fault, Kind, Sending, State};
use super::{Model, own_bytes};

impl Model {
    /// Time passes; what is over before an input is over, what ends with it waits for `end` to be its own moment.
    pub(in crate::dn_access) fn advance(&mut self, now: Instant) {
        self.now = self.now.max(now);
        self.expire(self.now.saturating_sub(Duration::from_nanos(1)));
    }

    /// After an input: the waits that end at this moment.
    pub(in crate::dn_access) fn settle(&mut self) {
        self.expire(self.now);
    }

    fn expire(&mut self, until: Instant) {
        let over = |at: Instant| at <= until;
        match &mut self.state {
            // Row 4.
            State::Waiting { done: 1, until: end } if over(*end) => self.send_request(1),
            // Row 5.
            State::Waiting { until: end, .. } if over(*end) => {
                self.enter(State::OnLine { answer_due: false, second: Sending::Nothing, pause: None });
            }
            State::Sending { controller, .. } => match *controller {
                Controller::BackOff(at) if over(at) => *controller = RESTART,
                Controller::GivenBack(at) if over(at) => *controller = Controller::Ready,
                _ => {}
            },
            State::OnLine { second, pause, .. } => {
                second.expire(until);
                pause.take_if(|&mut at| over(at));
            }
            State::Faulted(Fault::Duplicate { who, flashing, .. }) => {
                who.expire(until);
                flashing.take_if(|&mut at| over(at));
            }
            _ => {}
        }
    }

    pub(in crate::dn_access) fn frame(&mut self, frame: &Frame) {
        if frame.is_extended() || frame.is_remote() {
            return;
        }
        let data = frame.data();
        match self.state {
            State::Faulted(Fault::Duplicate { .. }) if self.config.offline_set && frame.raw_id() == 0x7ED => {
                self.communication_faulted(data);
            }
            State::NonExistent | State::Faulted(_) => {}
            // Received before bus-off.
            _ if self.is_off_the_bus() => {}
            _ if frame.raw_id() != self.own_check() => {}
            _ if data.len() != 7 && !self.config.accept_bad_dlc => {}
            // Row 9.
            State::OnLine { second, pause, .. } if data.first().is_none_or(|byte| byte & 0x80 == 0) => {
                self.state = State::OnLine { answer_due: true, second, pause };
            }
            // Rows 6 and 10.
            State::Sending { .. } | State::Waiting { .. } | State::OnLine { .. } => {
                self.enter(State::Faulted(Fault::Duplicate {
                    who: Sending::Nothing,
                    identify: None,
                    flashing: None,
                }));
            }
        }
    }

    /// 2.9.5 of the offline connection set.
    fn communication_faulted(&mut self, data: &[u8]) {
        let now = self.now;
        let device_is_meant = data.get(2..8) == Some(&own_bytes()[1..]);
        match *data {
            [head, 0x4B, offset @ 0..=6] if self.is_meant(head) => {
                let units = own_bytes()[usize::from(offset)];
                let delay = Duration::from_millis(self.config.who_delay_unit.into()) * u32::from(units);
                *self.fault().0 = Sending::At(now + delay);
            }
            [head, 0x4C] if self.is_meant(head) => {
                self.fault().1.replace(head);
            }
            [0x3F, 0x4C, _, _, _, _, _, _] if device_is_meant => {
                let end = now + Duration::from_millis(self.config.identify_timeout.into());
                self.fault().1.replace(0x3F);
                self.fault().2.replace(end);
            }
            // Row 13.
            [mac @ 0..=0x3F, 0x4D, _, _, _, _, _, _] if device_is_meant => {
                if self.config.mac_id_source == MacIdSource::Software {
                    self.mac = mac;
                }
                self.send_request(0);
            }
            _ => {}
        }
    }

    fn fault(&mut self) -> (&mut Sending, &mut Option<u8>, &mut Option<Instant>) {
        match &mut self.state {
            State::Faulted(Fault::Duplicate { who, identify, flashing }) => (who, identify, flashing),
            other => panic!("not faulted by a duplicate: {other:?}"),
        }
    }

    fn is_meant(&self, head: u8) -> bool {
        let value = head & 0x3F;
        match (head >> 6, self.config.mask_predicate) {
            (0, MaskPredicate::Subset) => self.mac & !value == 0,
            (0, MaskPredicate::Intersects) => self.mac & value != 0,
            (1, _) => self.mac == value,
            _ => false,
        }
    }

    pub(in crate::dn_access) fn sent(&mut self) {
        let Some((kind, wanted)) = self.in_flight.take() else { panic!("nothing is in flight") };
        self.withdraw_due = false;
        let until = self.now + T_DUP;
        match self.state {
            _ if !wanted || kind != Kind::CheckRequest => {}
            // Row 2, with Quick Connect and without.
            State::Sending { done: 0, .. } if self.quick_connect_active => {
                self.state = State::OnLine { answer_due: false, second: Sending::At(until), pause: None };
            }
            State::Sending { done, .. } => self.state = State::Waiting { done: done + 1, until },
            State::OnLine { answer_due, pause, .. } => {
                self.state = State::OnLine { answer_due, second: Sending::Nothing, pause };
            }
            _ => panic!("a wanted request in {:?}", self.state),
        }
    }

    pub(in crate::dn_access) fn given_back(&mut self) {
        let Some((kind, wanted)) = self.in_flight.take() else { panic!("nothing is in flight") };
        self.withdraw_due = false;
        let again = self.now + Duration::from_millis(self.config.bus_off_back_off.into());
        match (kind, &mut self.state) {
            _ if !wanted => {}
            (Kind::WhoResponse | Kind::IdentifyResponse(_), _) => {}
            (Kind::CheckRequest, State::Sending { controller, .. }) => {
                *controller = Controller::GivenBack(again);
            }
            (Kind::CheckRequest, State::OnLine { pause, .. }) => *pause = Some(again),
            (Kind::CheckResponse, State::OnLine { answer_due, pause, .. }) => {
                *answer_due = true;
                *pause = Some(again);
            }
            (_, other) => panic!("a wanted {kind:?} in {other:?}"),
        }
    }

    pub(in crate::dn_access) fn link(&mut self, event: LinkEvent) {
        let off_the_bus = self.is_off_the_bus();
        match (event, &mut self.state) {
            // Row 1.
            (LinkEvent::Up, State::NonExistent) => {
                self.quick_connect_active = self.quick_connect;
                self.send_request(0);
            }
            (
                LinkEvent::Up,
                State::Sending {
                    controller: controller @ (Controller::Restarting { .. } | Controller::GivenBack(_)),
                    ..
                },
            )
            | (
                LinkEvent::ModeSet(_),
                State::Sending { controller: controller @ Controller::GivenBack(_), .. },
            ) => {
                *controller = Controller::Ready;
            }
            (LinkEvent::Up | LinkEvent::ModeSet(_), State::OnLine { pause, .. }) => *pause = None,
            // Row 15.
            (LinkEvent::Down, _) => self.leave_the_bus(State::NonExistent),
            (LinkEvent::BusOff, State::NonExistent) => {}
            (LinkEvent::BusOff, _) if !off_the_bus => self.bus_off(),
            (
                LinkEvent::Refused(LinkCommandKind::Reset),
                State::Sending { controller: Controller::Restarting { .. }, .. },
            ) => self.leave_the_bus(State::Faulted(Fault::BusOff)),
            _ => {}
        }
    }

    /// Rows 7, 11 and 12.
    fn bus_off(&mut self) {
        self.bus_off_counter = self.bus_off_counter.saturating_add(1);
        let follows = match self.state {
            State::OnLine { .. } => true,
            State::Sending { .. } | State::Waiting { .. } => {
                self.config.bus_off_while_checking == BusOffWhileChecking::FollowInterrupt
            }
            State::NonExistent | State::Faulted(_) => false,
        };
        if follows && self.bus_off_interrupt {
            let controller =
                Controller::BackOff(self.now + Duration::from_millis(self.config.bus_off_back_off.into()));
            self.leave_the_bus(State::Sending { done: 0, controller });
        } else {
            self.leave_the_bus(State::Faulted(Fault::BusOff));
        }
    }

    pub(super) fn send_request(&mut self, done: u8) {
        let controller = if self.is_off_the_bus() { RESTART } else { Controller::Ready };
        self.enter(State::Sending { done, controller });
    }

    /// Another state: the frame of the old one is not wanted any more.
    fn enter(&mut self, state: State) {
        self.state = state;
        if let Some((_, wanted)) = &mut self.in_flight {
            self.withdraw_due |= *wanted;
            *wanted = false;
        }
    }

    /// As [`enter`](Self::enter), when the controller drops the frame by itself.
    fn leave_the_bus(&mut self, state: State) {
        self.enter(state);
        self.withdraw_due = false;
    }
}

const RESTART: Controller = Controller::Restarting { commanded: false };
const T_DUP: Duration = Duration::from_secs(1);
