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

use std::collections::BTreeMap;

use arbitrary::Unstructured;
use cip_core::code::DeviceType;
use cip_core::code::{ClassId, InstanceId, ServiceCode, VendorId};
use cip_core::fragment::{IoOutcome, IoReassembly};
use cip_core::identity::{DeviceIdentity, ProductName, Revision};
use cip_core::message::Request;
use devicenet_core::master::{
    AttributeWrite, BitStrobeConnection, Config, ElectronicKey, FirstContact, IoInstance, Master,
    MasterEvent, PollConnection, ReplacementMode, ScanEntry, SlaveState, StateChangeConnection,
};
use devicenet_core::{Identifier, MacId};
use link_core::{Action, Frame, Input, Instant, Machine, TxOutcome, TxToken};

use ops::Op;

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

/// Slave 10 is polled with long data both ways, 20 strobed and polled, 63 sends changes.
fn entry(number: u8) -> ScanEntry {
    let poll = |produce, consume| Some(PollConnection { produce, consume, expected_packet_rate: 75 });
    let vendor = VendorId(u16::from_le_bytes([VENDOR.0, VENDOR.1]));
    let key = ElectronicKey { vendor: Some(vendor), ..ElectronicKey::default() };
    let base = ScanEntry { key, replaceable: true, ..ScanEntry::explicit_only(mac(number)) };
    match number {
        10 => ScanEntry { poll: poll(16, 16), ..base },
        20 => ScanEntry {
            poll: poll(1, 1),
            bit_strobe: Some(BitStrobeConnection { produce: 1, expected_packet_rate: 0 }),
            multicast_poll: poll(1, 1),
            ..base
        },
        _ => {
            let change = StateChangeConnection {
                cyclic: false,
                acknowledged: true,
                produce: 2,
                consume: 16,
                expected_packet_rate: 0,
                inhibit: 0,
            };
            ScanEntry { state_change: Some(change), ..base }
        }
    }
}

/// What a slave answers: `how` 0 to 7 well, then other numbers, errors and other headers.
fn answer(request: &Frame, number: u8, how: u8) -> Frame {
    let data = request.data();
    let (header, body) = data.split_first().map_or((0, &[][..]), |(header, body)| (*header, body));
    let ucmm = request.raw_id() >= 0x780;
    let node = mac(number);
    let id = match request.raw_id() {
        0x780.. => Identifier::unconnected_response(node),
        0x600.. => Identifier::group3(4, node).expect("Message ID 4"),
        _ => Identifier::explicit_response(node),
    };
    // On Group 3 the request's header names the slave.
    let client = if request.raw_id() >= 0x600 { request.raw_id() as u8 & 0x3F } else { header & 0x3F };
    let header = header & 0xC0 | client;
    if header & 0x80 != 0 {
        // A fragment: its acknowledge, or after the last one a response.
        let byte = body.first().copied().unwrap_or(0);
        let acknowledge = [header, 0xC0 | byte & 0x3F, u8::from(how == 0xFF)];
        return id.frame(&acknowledge).expect("three bytes");
    }
    let service = body.first().copied().unwrap_or(0) | 0x80;
    let number = |good: u8, high: u8| vec![if how % 16 == 8 { 0x77 } else { good }, high];
    let consume = entry(node.number()).output_len() as u8;
    let connection = |instance: u8, produce: bool| {
        let size = match (node.number(), instance, produce) {
            (10, 2, _) => 16,
            (20, ..) => 1,
            (_, 2, false) => consume,
            _ => 2,
        };
        number(size, 0)
    };
    let wide = body.len() > 5 && body.get(2) == Some(&0);
    let fields: Vec<u8> = if wide {
        body.iter()
            .copied()
            .enumerate()
            .filter(|(at, _)| ![2, 4].contains(at))
            .map(|(_, byte)| byte)
            .collect()
    } else {
        body.to_vec()
    };
    let value = match fields[..] {
        [0x4B, ..] if ucmm => vec![how & 2, 0x04, 6, 0],
        [0x4B, ..] => vec![0],
        [0x0E, 1, 1, 1] => number(VENDOR.0, VENDOR.1),
        [0x0E, 5, instance, 7] => connection(instance, true),
        [0x0E, 5, instance, 8] => connection(instance, false),
        [0x10, 5, _, 9, low, high] => vec![low, high],
        [0x0E, ..] => vec![1, 0],
        _ => Vec::new(),
    };
    let bytes = match how % 16 {
        9 => vec![header, 0x94, 0x0B, 0x02],
        10 => vec![header, 0x94, 0x0C, 0x01],
        11 => vec![header, 0x94, 0x08, 0xFF],
        12 => vec![header ^ 0x40, service],
        13 => vec![header | 0x80, how, 0x8E, 1, 2, 3, 4, 5],
        _ => [vec![header, service], value].concat(),
    };
    id.frame(&bytes).expect("at most eight bytes")
}

/// A frame of I/O data: bits 1-0 of `which` the slave, bits 3-2 the connection, bits 6-4 the length if bit 7 is set.
fn io(which: u8, head: u8, value: u8) -> Frame {
    let node = mac(SLAVES[usize::from(which & 3) % SLAVES.len()]);
    let (id, size) = match which >> 2 & 3 {
        0 => (Identifier::poll_response(node), 1),
        1 => (Identifier::bit_strobe_response(node), 1),
        2 => (Identifier::change_of_state(node), 2),
        _ => (Identifier::multicast_poll_response(node), 1),
    };
    let fragmented = node.number() == 10;
    let len = match (which >> 7, fragmented) {
        (0, true) => 8,
        (0, false) => size,
        _ => usize::from(which >> 4 & 7),
    };
    let mut data = vec![value; len];
    if fragmented && let Some(first) = data.first_mut() {
        *first = head;
    }
    id.frame(&data).expect("at most eight bytes")
}

fn mac(number: u8) -> MacId {
    MacId::new(number & 0x3F).expect("six bits")
}

const OWN: u8 = 4;
const SLAVES: [u8; 3] = [10, 20, 63];
const VENDOR: (u8, u8) = (0xE7, 0x03);

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
