//! One slave, and the tester as the rest of the bus.

use core::time::Duration;
use std::collections::VecDeque;
use std::string::{String, ToString};
use std::vec::Vec;

use cip_core::code::{DeviceType, VendorId};
use cip_core::identity::{DeviceIdentity, ProductName, Revision};
use cip_core::message::AllocationChoice;
use cip_core::object::{Identity, Resets};
use link_core::{
    Action, Frame, Input, Instant, LinkCommand, LinkEvent, Machine, TxOutcome, TxToken, frame::standard_id,
};

use crate::access::StateKind;
use crate::id::MacId;
use crate::slave::{Application, Config, Event, Fragmented, IoKind, LongMessages, Slave, SlaveEvent};

/// The device of the worked trace: MAC ID 63, vendor 0x03E7, serial 0x11223344, two input bytes, one output byte.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Block {
    pub(super) device: DeviceIdentity,
    pub(super) inputs: [u8; 2],
    pub(super) outputs: [u8; 1],
}

/// The same with all connections, and as many bytes as a test likes.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Everything {
    pub(super) device: DeviceIdentity,
    pub(super) inputs: Vec<u8>,
    pub(super) outputs: [Vec<u8>; 4],
    pub(super) selected: u16,
    pub(super) valid: bool,
    pub(super) status: cip_core::identity::IdentityStatus,
}

pub(super) fn device() -> DeviceIdentity {
    DeviceIdentity {
        vendor: VendorId(0x03E7),
        device_type: DeviceType::GENERAL_PURPOSE_DISCRETE_IO,
        product_code: 0x2A,
        revision: Revision::new(1, 1).unwrap(),
        serial: 0x1122_3344,
        name: ProductName::new("Example Block 2I1O").unwrap(),
    }
}

impl Application for Block {
    const IO: AllocationChoice = AllocationChoice::POLL;
    type Long = ();

    fn identity(&self) -> Identity<'_> {
        let mut identity = Identity::new(&self.device);
        identity.resets = Resets::OUT_OF_BOX | Resets::KEEP_COMMUNICATION;
        identity
    }

    fn produced(&self, _: IoKind) -> &[u8] {
        &self.inputs
    }

    fn consumed(&mut self, _: IoKind) -> &mut [u8] {
        &mut self.outputs
    }
}

impl Application for Everything {
    const IO: AllocationChoice = AllocationChoice::all();
    const SELECTS_ASSEMBLIES: bool = true;
    type Long = Fragmented<32>;

    fn identity(&self) -> Identity<'_> {
        let mut identity = Identity::new(&self.device);
        identity.status = self.status;
        identity
    }

    fn produced(&self, connection: IoKind) -> &[u8] {
        if !self.valid {
            return &[];
        }
        if connection == IoKind::BitStrobe { &self.inputs[..self.inputs.len().min(8)] } else { &self.inputs }
    }

    fn consumed(&mut self, connection: IoKind) -> &mut [u8] {
        &mut self.outputs[index(connection)]
    }

    fn produced_size(&self, connection: IoKind) -> u16 {
        let size = self.inputs.len();
        u16::try_from(if connection == IoKind::BitStrobe { size.min(8) } else { size }).unwrap()
    }

    fn assembly(&self, connection: IoKind, end: crate::slave::End) -> Option<cip_core::code::InstanceId> {
        let number = match end {
            crate::slave::End::Produced => self.selected,
            crate::slave::End::Consumed => 100 + connection.instance().0,
        };
        Some(cip_core::code::InstanceId(number))
    }

    fn select_assembly(
        &mut self,
        _: IoKind,
        end: crate::slave::End,
        assembly: cip_core::code::InstanceId,
    ) -> bool {
        if end == crate::slave::End::Consumed || !(1..=9).contains(&assembly.0) {
            return false;
        }
        self.selected = assembly.0;
        self.inputs = std::vec![0xEE; usize::from(assembly.0) * 8];
        true
    }
}

pub(super) fn index(connection: IoKind) -> usize {
    IoKind::ALL.iter().position(|&kind| kind == connection).unwrap()
}

pub(super) fn block() -> Block {
    Block { device: device(), inputs: [0x34, 0x12], outputs: [0] }
}

/// Two bytes of input; one of output for poll and multicast poll, the bit of bit-strobe.
pub(super) fn everything() -> Everything {
    Everything {
        device: device(),
        inputs: std::vec![0x34, 0x12],
        outputs: [std::vec![0], std::vec![0], Vec::new(), std::vec![0]],
        selected: 1,
        valid: true,
        status: cip_core::identity::IdentityStatus::empty(),
    }
}

pub(super) fn config() -> Config {
    Config::new(&device(), MacId::DEFAULT)
}

pub(super) const MASTER: u8 = 4;
pub(super) const CHECK: u16 = 0x5FF;
/// Explicit request, response, unconnected request of MAC ID 63.
pub(super) const REQUEST: u16 = 0x5FC;
pub(super) const RESPONSE: u16 = 0x5FB;
pub(super) const UNCONNECTED: u16 = 0x5FE;
pub(super) const POLL: u16 = 0x5FD;
pub(super) const POLL_RESPONSE: u16 = 0x3FF;
pub(super) const COS: u16 = 0x37F;
pub(super) const COS_ACK: u16 = 0x5FA;
/// Of master 4.
pub(super) const STROBE: u16 = 0x420;
pub(super) const STROBE_RESPONSE: u16 = 0x3BF;
pub(super) const MULTICAST: u16 = 0x421;
pub(super) const MULTICAST_RESPONSE: u16 = 0x33F;

pub(super) type G2o = Bus<Block, 0>;
pub(super) type Full = Bus<Everything, 0>;
pub(super) type Ucmm = Bus<Everything, 3>;

#[derive(Clone)]
pub(super) struct Bus<A: Application, const DYNAMIC: usize> {
    pub(super) slave: Slave<A, 64, DYNAMIC>,
    pub(super) now: Instant,
    /// Every frame is acknowledged at once.
    pub(super) acknowledging: bool,
    pub(super) in_flight: VecDeque<(TxToken, Frame)>,
    transmits: VecDeque<Frame>,
    pub(super) withdrawn: Vec<TxToken>,
    pub(super) links: Vec<LinkCommand>,
    pub(super) events: Vec<SlaveEvent>,
}

impl Bus<Block, 0> {
    pub(super) fn g2o() -> Self {
        Self::online(config(), block())
    }
}

impl Bus<Everything, 0> {
    pub(super) fn full() -> Self {
        Self::online(config(), everything())
    }
}

impl Bus<Everything, 3> {
    pub(super) fn ucmm_server() -> Self {
        Self::online(config(), everything())
    }
}

impl<A: Application, const DYNAMIC: usize> Bus<A, DYNAMIC> {
    pub(super) fn dark(config: Config, application: A) -> Self {
        Self {
            slave: Slave::new(config, application).unwrap(),
            now: Instant::ZERO,
            acknowledging: true,
            in_flight: VecDeque::new(),
            transmits: VecDeque::new(),
            withdrawn: Vec::new(),
            links: Vec::new(),
            events: Vec::new(),
        }
    }

    /// A slave on line, two seconds after power-up.
    pub(super) fn online(config: Config, application: A) -> Self {
        let mut bus = Self::dark(config, application);
        bus.link(LinkEvent::Up);
        bus.wait(2000);
        assert_eq!(bus.slave.access().state().kind(), StateKind::OnLine);
        bus.transmits.clear();
        bus.events.clear();
        bus
    }

    /// The explicit connection is allocated to the master.
    pub(super) fn allocated(mut self, choice: u8) -> Self {
        self.hears(UNCONNECTED, &[MASTER, 0x4B, 3, 1, choice, MASTER]);
        self.sends(RESPONSE, &[MASTER, 0xCB, 0]);
        self.events.clear();
        self
    }

    /// And the packet rate of these I/O connections is set to 80 ms.
    pub(super) fn established(self, choice: u8, instances: &[u8]) -> Self {
        let mut bus = self.allocated(choice);
        for &instance in instances {
            bus.asks(&[0x10, 5, instance, 9, 80, 0], &[0x90, 80, 0]);
        }
        bus.events.clear();
        bus
    }

    pub(super) fn input(&mut self, input: Input) {
        self.slave.input(self.now, input);
        self.drain();
    }

    pub(super) fn link(&mut self, event: LinkEvent) {
        self.input(Input::Link(event));
    }

    pub(super) fn hears(&mut self, id: u16, data: &[u8]) {
        self.input(Input::Frame(Frame::new(standard_id(id), data).unwrap()));
    }

    /// The master asks, unfragmented, and the slave answers so; service byte first.
    #[track_caller]
    pub(super) fn asks(&mut self, request: &[u8], response: &[u8]) {
        self.hears(REQUEST, &[&[MASTER], request].concat());
        self.sends(RESPONSE, &[&[MASTER], response].concat());
    }

    /// A request on the unconnected port, of any node.
    #[track_caller]
    pub(super) fn asks_unconnected(&mut self, mac: u8, request: &[u8], response: &[u8]) {
        self.hears(UNCONNECTED, &[&[mac], request].concat());
        self.sends(RESPONSE, &[&[mac], response].concat());
    }

    pub(super) fn drain(&mut self) {
        while let Some(action) = self.slave.poll(self.now) {
            match action {
                Action::Transmit(token, frame) => {
                    assert!(
                        self.in_flight.iter().all(|(other, _)| *other != token),
                        "two frames in flight with {token:?}"
                    );
                    self.may_send(&frame);
                    self.in_flight.push_back((token, frame));
                    assert!(self.in_flight.len() <= self.slave.max_in_flight());
                    self.transmits.push_back(frame);
                    if self.acknowledging {
                        self.done(TxOutcome::Sent);
                    }
                }
                Action::Withdraw(token) => self.withdrawn.push(token),
                Action::Link(command) => self.links.push(command),
                Action::Event(Event::Slave(event)) => self.events.push(event),
                Action::Event(Event::Access(_)) => {}
            }
        }
        assert!(self.slave.deadline().is_none_or(|deadline| deadline.why != "output pending"));
    }

    /// The controller says what became of the oldest frame.
    #[track_caller]
    pub(super) fn done(&mut self, outcome: TxOutcome) {
        let (token, _) = self.in_flight.pop_front().expect("nothing is in flight");
        self.slave.input(self.now, Input::TxDone(token, outcome));
        self.drain();
    }

    /// Lets time pass, with a tick at each deadline on the way.
    pub(super) fn wait(&mut self, millis: u64) {
        let until = self.now + Duration::from_millis(millis);
        while let Some(deadline) = self.slave.deadline().filter(|deadline| deadline.at <= until) {
            self.now = self.now.max(deadline.at);
            self.input(Input::Tick);
        }
        self.now = until;
    }

    /// Lets time pass, and nobody calls the slave before its end.
    pub(super) fn sleep(&mut self, millis: u64) {
        self.now += Duration::from_millis(millis);
        self.input(Input::Tick);
    }

    #[track_caller]
    pub(super) fn sends(&mut self, id: u16, data: &[u8]) {
        let expected = Frame::new(standard_id(id), data).unwrap();
        let found = self.transmits.pop_front().map(|frame| frame.to_string());
        assert_eq!(found, Some(expected.to_string()));
    }

    /// The data of the next frame, which is a response.
    #[track_caller]
    pub(super) fn response(&mut self) -> Vec<u8> {
        let frame = self.transmits.pop_front().expect("no response");
        assert_eq!(frame.raw_id(), u32::from(RESPONSE));
        frame.data().to_vec()
    }

    /// All frames since they were looked at last.
    pub(super) fn take_transmits(&mut self) -> Vec<Frame> {
        self.transmits.drain(..).collect()
    }

    /// Some frame.
    #[track_caller]
    pub(super) fn skip(&mut self) {
        assert!(self.transmits.pop_front().is_some());
    }

    /// A frame, if there is one.
    pub(super) fn skip_any(&mut self) -> bool {
        self.transmits.pop_front().is_some()
    }

    #[track_caller]
    pub(super) fn sends_nothing(&self) {
        let frames: Vec<String> = self.transmits.iter().map(ToString::to_string).collect();
        assert!(frames.is_empty(), "{frames:?}");
    }

    #[track_caller]
    pub(super) fn tells(&self, event: SlaveEvent) {
        assert!(self.events.contains(&event), "{event:?} is not among {:?}", self.events);
    }

    /// Class 5, attribute 1.
    #[track_caller]
    pub(super) fn is_state(&mut self, instance: u8, state: u8) {
        self.asks(&[0x0E, 5, instance, 1], &[0x8E, state]);
    }

    /// Class 3, attribute 5, asked through nobody's connection.
    pub(super) fn allocation(&self) -> (u8, Option<u8>) {
        (self.slave.node.choice().bits(), self.slave.node.master.map(MacId::number))
    }

    /// What a slave may send, whatever happened to it.
    #[track_caller]
    fn may_send(&self, frame: &Frame) {
        let access = self.slave.access();
        let mac = u16::from(access.mac_id().number());
        let raw = u16::try_from(frame.raw_id()).unwrap();
        let check = raw == 0x407 + 8 * mac && frame.dlc() == 7;
        let allowed = match access.state().kind() {
            StateKind::NonExistent | StateKind::WaitingDupMac => false,
            StateKind::SendingDupMac => check,
            StateKind::CommFault => raw == 0x7EC,
            StateKind::OnLine => {
                raw < 0x400 && raw & 0x3F == mac
                    || (0x400..0x600).contains(&raw) && (raw >> 3) & 0x3F == mac
                    || (0x600..0x780).contains(&raw) && raw & 0x3F == mac
            }
        };
        assert!(allowed, "{frame} in {:?}", access.state());
    }
}

/// A long message survives where there is memory for it.
const _: () = assert!(<Fragmented<32> as LongMessages>::CAPACITY == 32);
