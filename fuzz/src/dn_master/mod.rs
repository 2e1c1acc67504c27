//! The master, against what a bus must never see of one.
//!
//! Three slaves, of which each connection is known, answer well, badly or not at all, while the application and the
//! controller do what they like. After each operation:
//!
//! - output data go only to a slave that runs, and that proved since it was contacted to be what its key asks for;
//! - a message that was sent whole has one value in all its bytes, as the application sets them: none is torn;
//! - input data are those of one whole message of a slave that runs;
//! - off line only network access sends; no token is used twice, and no more frames are in flight than was said;
//! - nothing is pending after a drain, a second tick changes nothing, and on line there is always something to wait for.

mod ops;
mod slaves;

use std::collections::BTreeMap;

use arbitrary::Unstructured;
use cip_core::code::DeviceType;
use cip_core::code::{ClassId, InstanceId, ServiceCode, VendorId};
use cip_core::fragment::{IoOutcome, IoReassembly};
use cip_core::identity::{DeviceIdentity, ProductName, Revision};
use cip_core::message::Request;
use devicenet_core::Identifier;
use devicenet_core::master::{
    AttributeWrite, Config, FirstContact, IoInstance, Master, MasterEvent, ReplacementMode, SlaveState,
};
use link_core::{Action, Frame, Input, Instant, Machine, TxOutcome, TxToken};

use ops::Op;
use slaves::{OWN, SLAVES, VENDOR, answer, entry, io, mac};

/// Does to a master what the bytes say.
pub fn run(data: &[u8]) {
    let mut input = Unstructured::new(data);
    let Ok(choices) = input.arbitrary() else { return };
    let mut network = Network::new(choices);
    while !input.is_empty() {
        let Ok(op) = ops::op(&mut input) else { return };
        network.apply(op);
    }
}

type Scanner = Master<4, 64>;

struct Network {
    master: Scanner,
    clock: Instant,
    in_flight: BTreeMap<u16, Frame>,
    slaves: BTreeMap<u8, Slave>,
}

/// What the bus knows of a slave.
#[derive(Default)]
struct Slave {
    /// The last request that was on the bus and has no answer.
    asked: Option<Frame>,
    /// It told a vendor that its key accepts, since it was contacted.
    matched: bool,
    /// The fragments of output data that were on the bus.
    heard: Option<IoReassembly<64>>,
}

impl Network {
    fn new(choices: u16) -> Self {
        let choice = |bit: u16| choices >> bit & 1 == 1;
        let device = DeviceIdentity {
            vendor: VendorId(0x1234),
            device_type: DeviceType::COMMUNICATIONS_ADAPTER,
            product_code: 1,
            revision: Revision { major: 1, minor: 1 },
            serial: 0x0A05_0301,
            name: ProductName::new("Example Master").expect("fourteen characters"),
        };
        let mut config = Config::new(device, mac(OWN));
        config.node.access.bus_off_interrupt = choice(0);
        config.deferred_delete = choice(1);
        config.first_contact = if choice(2) { FirstContact::Ucmm } else { FirstContact::Group2 };
        config.replacement = if choice(3) { ReplacementMode::On } else { ReplacementMode::Off };
        if choice(4) {
            config.interscan_delay = core::time::Duration::ZERO;
        }
        if choice(5) {
            config.tries = 1;
        }
        let mut master = Scanner::new(config);
        for number in SLAVES {
            master.add_slave(Instant::ZERO, entry(number)).expect("a good entry");
        }
        let value = [1, 2, 3];
        let write = AttributeWrite {
            class: ClassId(0x64),
            instance: InstanceId(1),
            attribute: 1.into(),
            value: &value,
        };
        if choice(6) {
            master.set_configuration(mac(SLAVES[0]), &[write, write]).expect("twenty bytes");
        }
        master.set_run(!choice(7));
        let slaves = SLAVES.into_iter().map(|number| (number, Slave::default())).collect();
        Self { master, clock: Instant::ZERO, in_flight: BTreeMap::new(), slaves }
    }

    fn apply(&mut self, op: Op) {
        let now = self.clock;
        match op {
            Op::Tick(span) => self.input(now + span, Input::Tick),
            Op::TickInThePast(span) => self.input(now.saturating_sub(span), Input::Tick),
            Op::TickAtDeadline => match self.master.deadline() {
                Some(deadline) => self.input(deadline.at, Input::Tick),
                None => return,
            },
            Op::Frame(frame) => {
                self.forged(&frame);
                self.input(now, Input::Frame(frame));
            }
            Op::Answer { slave, how } => {
                let number = SLAVES[usize::from(slave) % SLAVES.len()];
                let known = self.slaves.get_mut(&number).expect("all are known");
                let Some(request) = known.asked.take() else { return };
                let response = answer(&request, number, how);
                self.forged(&response);
                self.input(now, Input::Frame(response));
            }
            Op::Io { which, head, value } => self.input(now, Input::Frame(io(which, head, value))),
            Op::Check { slave, head } => {
                let number =
                    if slave & 0x40 == 0 { slave & 0x3F } else { SLAVES[usize::from(slave) % SLAVES.len()] };
                let check = [head, 0xE7, 0x03, 1, 2, 3, slave];
                let frame = Identifier::duplicate_mac_check(mac(number)).frame(&check).expect("seven bytes");
                self.input(now, Input::Frame(frame));
            }
            Op::Sent(which) => self.tx_done(which, TxOutcome::Sent),
            Op::GivenBack(which) => self.tx_done(which, TxOutcome::Dropped),
            Op::Link(event) => self.input(now, Input::Link(event)),
            Op::Output { slave, value } => {
                let number = SLAVES[usize::from(slave) % SLAVES.len()];
                let len = entry(number).output_len();
                _ = self.master.set_output(mac(number), &vec![value | 1; len]);
                self.drain(now);
            }
            Op::Ask { slave, len } => {
                let number = SLAVES[usize::from(slave) % SLAVES.len()];
                let data = vec![0x55; usize::from(len % 80)];
                let request = Request::new(ServiceCode(0x32), ClassId(0x64), InstanceId(1), &data);
                _ = self.master.request(now, mac(number), &request, 1 + slave / 128);
                self.drain(now);
            }
            Op::Command { which, slave } => self.command(which, SLAVES[usize::from(slave) % SLAVES.len()]),
        }
        self.check();
    }

    fn command(&mut self, which: u8, number: u8) {
        let now = self.clock;
        match which % 8 {
            0 => _ = self.master.restart_slave(now, mac(number)),
            1 => _ = self.master.remove_slave(mac(number)),
            2 => _ = self.master.add_slave(now, entry(number)),
            3 => self.master.set_run(!self.master.is_running()),
            4 => self.master.reset(now),
            5 => _ = self.master.set_mac_id(now, mac(which / 4)),
            6 => _ = self.master.set_strobe_bit(mac(number), which & 0x80 != 0),
            _ => _ = self.master.set_multicast_output(&[which]),
        }
        self.drain(now);
    }

    fn input(&mut self, now: Instant, input: Input) {
        self.clock = self.clock.max(now);
        self.master.input(now, input);
        self.drain(now);
        // Once more, for waits that the drain began and that are over at once.
        self.master.input(now, Input::Tick);
        self.drain(now);
    }

    fn tx_done(&mut self, which: u8, outcome: TxOutcome) {
        let tokens: Vec<u16> = self.in_flight.keys().copied().collect();
        let Some(&token) = tokens.get(usize::from(which) % tokens.len().max(1)) else { return };
        let frame = self.in_flight.remove(&token).expect("it is in flight");
        if outcome == TxOutcome::Sent {
            self.on_the_bus(&frame);
        }
        self.input(self.clock, Input::TxDone(TxToken(token), outcome));
    }

    /// A frame of the master is on the bus: what do its slaves learn from it?
    fn on_the_bus(&mut self, frame: &Frame) {
        let Some(id) = Identifier::of_frame(frame) else { panic!("{frame}: no identifier of DeviceNet") };
        for (&number, slave) in &mut self.slaves {
            let node = mac(number);
            let ucmm_header = frame.data().first().is_some_and(|head| head & 0x3F == number);
            let explicit = id == Identifier::explicit_request(node)
                || id == Identifier::group2_unconnected_request(node)
                || (id.raw() >= 0x600 && ucmm_header);
            if explicit {
                slave.asked = Some(*frame);
            }
            if id != Identifier::poll_command(node) || entry(number).output_len() <= 8 {
                continue;
            }
            let heard = slave.heard.get_or_insert_with(|| IoReassembly::new(entry(number).output_len()));
            if let IoOutcome::Complete(message) = heard.frame(frame.data()) {
                let first = message.first().copied().unwrap_or(0);
                assert!(message.iter().all(|&byte| byte == first), "a torn message: {message:?}");
                assert!(
                    [0, entry(number).output_len()].contains(&message.len()),
                    "half a message: {message:?}"
                );
            }
        }
    }

    /// Whoever sends it: a frame that a slave could have sent may tell its vendor.
    fn forged(&mut self, frame: &Frame) {
        for (&number, slave) in &mut self.slaves {
            let node = Identifier::of_frame(frame).and_then(Identifier::mac_id);
            if node == Some(mac(number)) {
                let (low, high) = VENDOR;
                slave.matched |= frame.data().get(1..) == Some(&[0x8E, low, high]);
            }
        }
    }

    fn drain(&mut self, now: Instant) {
        let mut actions = 0;
        while let Some(action) = self.master.poll(now) {
            self.observe(action);
            actions += 1;
            assert!(actions < 300, "the drain does not end");
        }
        assert_ne!(self.master.deadline().map(|deadline| deadline.why), Some("output pending"));
    }

    fn observe(&mut self, action: Action<MasterEvent>) {
        match action {
            Action::Transmit(TxToken(token), frame) => {
                assert!(!self.in_flight.contains_key(&token), "{frame}: token {token} twice");
                self.in_flight.insert(token, frame);
                assert!(self.in_flight.len() <= self.master.max_in_flight());
                // Network access checks and answers, on line and off.
                let access = Identifier::of_frame(&frame).is_some_and(|id| {
                    id == Identifier::duplicate_mac_check(self.master.access().mac_id())
                        || id == Identifier::COMMUNICATION_FAULTED_RESPONSE
                });
                assert!(access || self.master.access().is_online(), "{frame} off line");
                self.outputs_are_allowed(&frame);
            }
            Action::Withdraw(TxToken(token)) => {
                assert!(self.in_flight.contains_key(&token), "nothing to withdraw");
            }
            // It must prove anew who it is.
            Action::Event(MasterEvent::Slave { mac_id, event }) => {
                if let devicenet_core::master::SlaveEvent::StateChanged { to: SlaveState::Contacting, .. } =
                    event
                    && let Some(slave) = self.slaves.get_mut(&mac_id.number())
                {
                    slave.matched = false;
                }
            }
            Action::Event(_) | Action::Link(_) => {}
        }
    }

    fn outputs_are_allowed(&self, frame: &Frame) {
        for (&number, slave) in &self.slaves {
            if Identifier::of_frame(frame) == Some(Identifier::poll_command(mac(number))) {
                assert_eq!(self.master.state(mac(number)), Some(SlaveState::Running), "{frame}");
                assert!(slave.matched, "{frame}: outputs to the wrong device");
                assert!(
                    self.master.is_running() || frame.data().is_empty() || entry(number).output_len() > 8
                );
            }
        }
    }

    fn check(&self) {
        for number in SLAVES {
            let running = self.master.state(mac(number)) == Some(SlaveState::Running);
            for instance in IoInstance::ALL {
                let Some(data) = self.master.input_data(mac(number), instance) else { continue };
                assert!(running, "input data of slave {number}, which does not run");
                let first = data.first().copied().unwrap_or(0);
                // Frames of any content can be whole messages of up to eight bytes.
                assert!(
                    data.len() <= 8 || data.iter().skip(7).all(|&byte| byte == data[7]) || first != data[7]
                );
            }
        }
        let waits = self.master.deadline().is_some() || !self.in_flight.is_empty();
        let listed = self.master.scan_list().len() != 0;
        let busy = |number: &u8| {
            self.master
                .state(mac(*number))
                .is_some_and(|state| !matches!(state, SlaveState::Offline | SlaveState::Running))
        };
        assert!(waits || !listed || !SLAVES.iter().any(busy), "stuck");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn up(choices: u16) -> Network {
        let mut network = Network::new(choices);
        network.apply(Op::Link(link_core::LinkEvent::Up));
        for _ in 0..2 {
            network.apply(Op::Sent(0));
            network.apply(Op::TickAtDeadline);
        }
        for round in 0..120 {
            network.apply(Op::Sent(round));
            network.apply(Op::Answer { slave: round % 3, how: 0 });
            if SLAVES.iter().all(|number| network.state(*number) == Some(SlaveState::Running)) {
                break;
            }
        }
        network
    }

    impl Network {
        fn state(&self, number: u8) -> Option<SlaveState> {
            self.master.state(mac(number))
        }
    }

    /// Without this the oracle would have nothing to judge.
    #[test]
    fn slaves_that_answer_well_run() {
        for choices in [0, 0x02, 0x42] {
            let mut network = up(choices);
            for number in SLAVES {
                assert_eq!(network.state(number), Some(SlaveState::Running), "slave {number}, {choices:02X}");
            }
            for (head, value) in [(0x00, 9), (0x41, 9), (0x82, 9)] {
                network.apply(Op::Io { which: 0, head, value });
            }
            for _ in 0..20 {
                network.apply(Op::Output { slave: 0, value: 0x21 });
                network.apply(Op::Sent(1));
                network.apply(Op::Sent(0));
            }
            assert!(network.slaves[&10].heard.is_some(), "fragments of output data");
        }
    }

    #[test]
    #[should_panic(expected = "outputs to the wrong device")]
    fn outputs_to_the_wrong_device_are_found() {
        let mut network = up(0);
        network.slaves.get_mut(&10).unwrap().matched = false;
        network.outputs_are_allowed(&Identifier::poll_command(mac(10)).frame(&[]).unwrap());
    }

    #[test]
    #[should_panic(expected = "a torn message")]
    fn torn_messages_are_found() {
        let mut network = up(0);
        for data in [[0x00, 1, 1, 1, 1, 1, 1, 1], [0x41, 1, 1, 1, 1, 1, 1, 1], [0x82, 2, 2, 0, 0, 0, 0, 0]] {
            let len = if data[0] == 0x82 { 3 } else { 8 };
            network.on_the_bus(&Identifier::poll_command(mac(10)).frame(&data[..len]).unwrap());
        }
    }
}
