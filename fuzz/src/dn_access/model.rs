//! Network access once more, as small as the table of CIP Vol. 3, chapter 2 allows: rows 1 to 15, the two waits, and the
//! offline connection set. Written from the table; it shares nothing with the machine but the configuration.

use core::time::Duration;

use devicenet_core::access::{
    BusOffWhileChecking, Config, CounterSetMode, MacIdSource, MaskPredicate, StateKind,
};
use link_core::link::LinkCommandKind;
use link_core::{Frame, Instant, LinkEvent};

use super::ops::{Command, DEVICE};

#[derive(Clone, Debug)]
pub(super) struct Model {
    config: Config,
    pub(super) now: Instant,
    pub(super) state: State,
    pub(super) mac: u8,
    pub(super) bus_off_interrupt: bool,
    pub(super) bus_off_counter: u8,
    pub(super) quick_connect: bool,
    quick_connect_active: bool,
    /// The frame in flight, and whether its fate still matters.
    pub(super) in_flight: Option<(Kind, bool)>,
    /// The machine owes a withdrawal.
    pub(super) withdraw_due: bool,
}

/// The states of the table, with what the rows need.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum State {
    NonExistent,
    Sending {
        done: u8,
        controller: Controller,
    },
    Waiting {
        done: u8,
        until: Instant,
    },
    /// With Quick Connect, the second request comes later.
    OnLine {
        answer_due: bool,
        second: Sending,
        /// The controller gave something back: nothing is sent before this.
        pause: Option<Instant>,
    },
    Faulted(Fault),
}

/// Whether the request can be handed to the controller.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Controller {
    Ready,
    BackOff(Instant),
    Restarting { commanded: bool },
    GivenBack(Instant),
}

/// A frame that is sent after a wait.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Sending {
    Nothing,
    At(Instant),
    Due,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Fault {
    BusOff,
    /// The Who response, byte 0 of the Identify response, and until when the indicator flashes.
    Duplicate {
        who: Sending,
        identify: Option<u8>,
        flashing: Option<Instant>,
    },
}

/// What a frame is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    CheckRequest,
    CheckResponse,
    WhoResponse,
    IdentifyResponse(u8),
}

impl Sending {
    fn expire(&mut self, until: Instant) {
        if matches!(*self, Self::At(at) if at <= until) {
            *self = Self::Due;
        }
    }
}

impl Model {
    pub(super) fn new(config: Config) -> Self {
        Self {
            now: Instant::ZERO,
            state: State::NonExistent,
            mac: config.mac_id.number(),
            bus_off_interrupt: config.bus_off_interrupt,
            bus_off_counter: 0,
            quick_connect: config.quick_connect,
            quick_connect_active: false,
            in_flight: None,
            withdraw_due: false,
            config,
        }
    }

    pub(super) fn kind(&self) -> StateKind {
        match self.state {
            State::NonExistent => StateKind::NonExistent,
            State::Sending { .. } => StateKind::SendingDupMac,
            State::Waiting { .. } => StateKind::WaitingDupMac,
            State::OnLine { .. } => StateKind::OnLine,
            State::Faulted(_) => StateKind::CommFault,
        }
    }

    /// The controller is off the bus, as far as the node knows.
    pub(super) fn is_off_the_bus(&self) -> bool {
        matches!(
            self.state,
            State::Faulted(Fault::BusOff)
                | State::Sending { controller: Controller::BackOff(_) | Controller::Restarting { .. }, .. }
        )
    }

    /// The identifier that the node must hear.
    pub(super) fn must_hear(&self) -> Option<u32> {
        match self.state {
            State::NonExistent | State::Faulted(Fault::BusOff) => None,
            State::Sending { .. } | State::Waiting { .. } | State::OnLine { .. } => Some(self.own_check()),
            State::Faulted(Fault::Duplicate { .. }) => self.config.offline_set.then_some(0x7ED),
        }
    }

    /// Time passes; what is over before an input is over, what ends with it waits for `end` to be its own moment.
    pub(super) fn advance(&mut self, now: Instant) {
        self.now = self.now.max(now);
        self.expire(self.now.saturating_sub(Duration::from_nanos(1)));
    }

    /// After an input: the waits that end at this moment.
    pub(super) fn settle(&mut self) {
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

    pub(super) fn frame(&mut self, frame: &Frame) {
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
                let delay = self.config.who_delay_unit * u32::from(units);
                *self.fault().0 = Sending::At(now + delay);
            }
            [head, 0x4C] if self.is_meant(head) => {
                self.fault().1.replace(head);
            }
            [0x3F, 0x4C, _, _, _, _, _, _] if device_is_meant => {
                let end = now + self.config.identify_timeout;
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

    pub(super) fn sent(&mut self) {
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

    pub(super) fn given_back(&mut self) {
        let Some((kind, wanted)) = self.in_flight.take() else { panic!("nothing is in flight") };
        self.withdraw_due = false;
        let again = self.now + self.config.bus_off_back_off;
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

    pub(super) fn link(&mut self, event: LinkEvent) {
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
            let controller = Controller::BackOff(self.now + self.config.bus_off_back_off);
            self.leave_the_bus(State::Sending { done: 0, controller });
        } else {
            self.leave_the_bus(State::Faulted(Fault::BusOff));
        }
    }

    /// Whether the machine must accept the command.
    pub(super) fn command(&mut self, command: Command) -> bool {
        match command {
            Command::Reset => self.reset(),
            Command::ResetWithSwitches(mac) => {
                self.mac = mac.number();
                self.reset();
            }
            Command::SetMacId(_) if self.config.mac_id_source == MacIdSource::Switches => return false,
            Command::SetMacId(mac) => {
                if mac.number() != self.mac || self.config.same_mac_id_restarts {
                    self.mac = mac.number();
                    self.start_anew();
                }
            }
            Command::SetBusOffInterrupt(on) => self.bus_off_interrupt = on,
            Command::SetBusOffCounter(value) => {
                if value != 0 && self.config.counter_set_mode == CounterSetMode::OnlyZero {
                    return false;
                }
                self.bus_off_counter = 0;
            }
            Command::ClearBusOffCounter => self.bus_off_counter = 0,
            Command::SetQuickConnect(on) => self.quick_connect = on,
        }
        true
    }

    /// Rows 1 and 14.
    fn reset(&mut self) {
        self.bus_off_interrupt = self.config.bus_off_interrupt;
        self.bus_off_counter = 0;
        self.quick_connect_active = self.quick_connect;
        self.start_anew();
    }

    fn start_anew(&mut self) {
        if self.state != State::NonExistent {
            self.send_request(0);
        }
    }

    fn send_request(&mut self, done: u8) {
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

    /// What must be handed to the controller now.
    pub(super) fn wants(&self) -> Vec<Kind> {
        if self.in_flight.is_some() {
            return Vec::new();
        }
        match self.state {
            State::Sending { controller: Controller::Ready, .. } => vec![Kind::CheckRequest],
            State::OnLine { pause: Some(_), .. } => Vec::new(),
            State::OnLine { answer_due: true, .. } => vec![Kind::CheckResponse],
            State::OnLine { second: Sending::Due, .. } => vec![Kind::CheckRequest],
            State::Faulted(Fault::Duplicate { who, identify, .. }) => {
                let who = (who == Sending::Due).then_some(Kind::WhoResponse);
                who.into_iter().chain(identify.map(Kind::IdentifyResponse)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Whether the machine must restart the controller now.
    pub(super) fn restart_due(&mut self) -> Option<&mut bool> {
        match &mut self.state {
            State::Sending { controller: Controller::Restarting { commanded }, .. } if !*commanded => {
                Some(commanded)
            }
            _ => None,
        }
    }

    /// The machine hands this to the controller. Panics if it must not.
    pub(super) fn transmit(&mut self, frame: &Frame) {
        let wants = self.wants();
        let kind = wants.iter().copied().find(|&kind| self.frame_of(kind) == *frame);
        let kind = kind.unwrap_or_else(|| panic!("{frame} in {:?}, which wants {wants:?}", self.state));
        self.in_flight = Some((kind, true));
        match (kind, &mut self.state) {
            (Kind::CheckResponse, State::OnLine { answer_due, .. }) => *answer_due = false,
            (Kind::WhoResponse, State::Faulted(Fault::Duplicate { who, .. })) => *who = Sending::Nothing,
            (Kind::IdentifyResponse(_), State::Faulted(Fault::Duplicate { identify, .. })) => {
                *identify = None
            }
            _ => {}
        }
    }

    /// 2.1 and 2.9.2: the bytes of what a node sends.
    fn frame_of(&self, kind: Kind) -> Frame {
        let mut check = own_bytes();
        let (id, data): (u32, &[u8]) = match kind {
            Kind::CheckRequest => (self.own_check(), &check),
            Kind::CheckResponse => {
                check[0] |= 0x80;
                (self.own_check(), &check)
            }
            Kind::WhoResponse => (0x7EC, &check),
            Kind::IdentifyResponse(head) => (0x7EC, &[head, 0xCC]),
        };
        Frame::new(link_core::frame::standard_id(id as u16), data).expect("at most eight bytes")
    }

    fn own_check(&self) -> u32 {
        0x407 + 8 * u32::from(self.mac)
    }
}

/// Port, vendor and serial number.
fn own_bytes() -> [u8; 7] {
    let [low, high] = DEVICE.vendor.0.to_le_bytes();
    let [a, b, c, d] = DEVICE.serial.to_le_bytes();
    [0, low, high, a, b, c, d]
}

const RESTART: Controller = Controller::Restarting { commanded: false };
const T_DUP: Duration = Duration::from_secs(1);
