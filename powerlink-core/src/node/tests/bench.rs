//! One node, and what a managing node sends to it.

use core::time::Duration;
use std::string::{String, ToString};
use std::vec::Vec;

use link_core::Instant;
use link_core::codec::Writer;
use link_core::ethernet::{Action, Input, LinkEvent, Machine};

use super::super::*;
use crate::dictionary::{Access, Device, Entry, Mappable, ObjectAddress, ObjectSet, ObjectType};
use crate::ethernet::{MAX_FRAME, group};
use crate::nmt::NmtState;
use crate::pdo::MappingEntry;
use crate::wire::{
    AbortCode, Body, Con, Flags, Frame, Identity, NmtCommand, NmtCommandId, NmtStateCode, POWERLINK_V2,
    PdoVersion, Preq, Pres, RequestedService, Sdo, SdoCommand, SdoCommandId, SdoSequence, SequenceHalf, Soa,
    Soc,
};
use crate::{ControlledNode, MacAddress, NodeId};

pub(super) const NODE: NodeId = NodeId(1);
pub(super) const MAC: MacAddress = MacAddress([2, 0, 0, 0, 0, 1]);
const MN_MAC: MacAddress = MacAddress([2, 0, 0, 0, 0, 0xF0]);
/// The longest value of SDO.
pub(super) const VALUE: usize = 2048;
/// The cycle length that the bench configures, ms.
pub(super) const CYCLE: u64 = 20;

#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
pub(super) struct Io {
    pub(super) input: u8,
    pub(super) output: u8,
    pub(super) long: Vec<u8>,
    pub(super) switch: u8,
}

impl ObjectSet for Io {
    const ENTRIES: &'static [Entry] = &[
        Entry::new(0x2000, 0, "long", ObjectType::Bytes(4000), Access::ReadWrite),
        Entry::new(0x2001, 0, "secret", ObjectType::Unsigned(1), Access::WriteOnly),
        Entry::new(0x2002, 0, "switch", ObjectType::Boolean, Access::ReadWrite).mapped(Mappable::Both),
        Entry::new(0x2003, 0, "busy", ObjectType::Unsigned(1), Access::ReadWrite).mapped(Mappable::Both),
        Entry::new(0x6000, 1, "input", ObjectType::Unsigned(1), Access::ReadOnly).mapped(Mappable::Transmit),
        Entry::new(0x6200, 1, "output", ObjectType::Unsigned(1), Access::ReadWrite).mapped(Mappable::Receive),
    ];

    fn read(&self, at: ObjectAddress, out: &mut Writer<'_>) -> Result<(), AbortCode> {
        match at.index {
            0x2000 => out.bytes(&self.long),
            0x2002 => out.u8(self.switch),
            0x2003 => return Err(AbortCode::STATE),
            0x6000 => out.u8(self.input),
            _ => out.u8(self.output),
        }
        .map_err(|_| AbortCode::OUT_OF_MEMORY)
    }

    fn write(&mut self, at: ObjectAddress, data: &[u8]) -> Result<(), AbortCode> {
        let first = *data.first().ok_or(AbortCode::LENGTH)?;
        match at.index {
            0x2000 => self.long = data.to_vec(),
            0x2001 => {}
            0x2002 => self.switch = first,
            0x2003 => return Err(AbortCode::STATE),
            _ => self.output = first,
        }
        Ok(())
    }

    fn restore(&mut self) {
        self.output = 0;
    }
}

const fn byte(index: u16) -> MappingEntry {
    MappingEntry { object: ObjectAddress::new(index, 1), offset: 0, length: 8 }
}

pub(super) fn config() -> Config {
    let identity = Identity { vendor_id: 0x0123, product_code: 7, revision: 0x0001_0000, serial_number: 42 };
    let mut config = Config::new(NODE, MAC, Device::new(identity)).unwrap();
    config.values.cycle_length = 20_000;
    config.mapping =
        DefaultMapping { receive: const { &[byte(0x6200)] }, transmit: const { &[byte(0x6000)] } };
    config
}

pub(super) struct Bench {
    pub(super) node: ControlledNode<Io, 36, VALUE>,
    pub(super) now: Instant,
    /// Frames that were sent and not looked at yet, in words.
    sent: Vec<String>,
    /// The last frame that was sent.
    pub(super) last: Vec<u8>,
    pub(super) events: Vec<NodeEvent>,
    /// The last number of the managing node's SDO frames; nothing while there is no connection.
    sdo_number: Option<u8>,
}

impl Bench {
    /// A node that has gone through its initialisation.
    pub(super) fn listening(config: Config) -> Self {
        let node = ControlledNode::new(config, Io::default()).unwrap();
        let (sent, last, events) = (Vec::new(), Vec::new(), Vec::new());
        let mut bench = Self { node, now: Instant::from_millis(1), sent, last, events, sdo_number: None };
        bench.node.power_on(bench.now);
        bench.drain();
        bench.is(NmtState::NotActive);
        bench
    }

    /// A node in any communicating state.
    #[track_caller]
    pub(super) fn in_state(state: NmtState, config: Config) -> Self {
        let mut bench = Self::listening(config);
        bench.goes_to(state);
        bench
    }

    /// Leads a node that listens, or is in `PreOperational1`, to any communicating state.
    #[track_caller]
    pub(super) fn goes_to(&mut self, state: NmtState) {
        match state {
            NmtState::PreOperational1 => self.soa(),
            NmtState::PreOperational2
            | NmtState::ReadyToOperate
            | NmtState::Operational
            | NmtState::Stopped => {
                self.soa();
                self.cycle();
                if matches!(state, NmtState::ReadyToOperate | NmtState::Operational) {
                    self.command(NmtCommandId::ENABLE_READY_TO_OPERATE);
                }
                if state == NmtState::Operational {
                    self.command(NmtCommandId::START_NODE);
                }
                if state == NmtState::Stopped {
                    self.command(NmtCommandId::STOP_NODE);
                }
            }
            NmtState::BasicEthernet => self.wait(Duration::from_secs(5)),
            _ => {}
        }
        self.is(state);
        self.forget();
    }

    /// The same node after a reset that closed its connections, led to a state.
    #[track_caller]
    pub(super) fn reconnected(mut self, state: NmtState) -> Self {
        self.sdo_number = None;
        self.goes_to(state);
        self
    }

    pub(super) fn drain(&mut self) {
        let mut buffer = [0xA5; MAX_FRAME];
        while let Some(action) = self.node.poll(self.now, &mut buffer) {
            match action {
                Action::Transmit(bytes) => {
                    self.last = bytes.to_vec();
                    self.sent.push(Frame::parse(bytes).unwrap().to_string());
                }
                Action::Event(event) => self.events.push(event),
            }
        }
        let next = self.node.deadline().map(|deadline| deadline.why);
        assert_ne!(next, Some("output pending"));
    }

    pub(super) fn bytes(&mut self, bytes: &[u8]) {
        self.node.input(self.now, Input::Frame(bytes));
        self.drain();
    }

    pub(super) fn hears(&mut self, destination: MacAddress, to: NodeId, from: NodeId, body: Body<'_>) {
        let mut buffer = [0; MAX_FRAME];
        let frame = Frame { destination, source: MN_MAC, to, from, body };
        let bytes = frame.emit(&mut buffer).unwrap().to_vec();
        self.bytes(&bytes);
    }

    fn of_mn(&mut self, destination: MacAddress, to: NodeId, body: Body<'_>) {
        self.hears(destination, to, NodeId::MANAGING_NODE, body);
    }

    pub(super) fn soc(&mut self) {
        self.soc_with(Soc::default());
    }

    pub(super) fn soc_with(&mut self, soc: Soc) {
        self.of_mn(group::SOC, NodeId::BROADCAST, Body::Soc(soc));
    }

    pub(super) fn preq(&mut self, flags: Flags, data: &[u8]) {
        self.preq_of_version(PdoVersion(0), flags, data);
    }

    pub(super) fn preq_of_version(&mut self, pdo_version: PdoVersion, flags: Flags, data: &[u8]) {
        self.of_mn(MAC, NODE, Body::Preq(Preq { flags, pdo_version, data }));
    }

    pub(super) fn pres_of_another(&mut self) {
        self.pres_with(NodeId(2), PdoVersion(0), Flags::DATA_VALID, &[9]);
    }

    pub(super) fn pres_with(&mut self, from: NodeId, pdo_version: PdoVersion, flags: Flags, data: &[u8]) {
        let (state, request) = (NmtStateCode::OPERATIONAL, crate::wire::AsyncRequest::NONE);
        let pres = Pres { state, flags, request, pdo_version, data };
        self.hears(group::PRES, NodeId::BROADCAST, from, Body::Pres(pres));
    }

    pub(super) fn soa(&mut self) {
        self.invite(RequestedService::NO_SERVICE, NodeId::NONE, Flags::empty());
    }

    pub(super) fn invite(&mut self, service: RequestedService, target: NodeId, flags: Flags) {
        let state = NmtStateCode::PRE_OPERATIONAL_1;
        let soa = Soa { state, flags, service, target, version: POWERLINK_V2 };
        self.of_mn(group::SOA, NodeId::BROADCAST, Body::Soa(soa));
    }

    /// A SoA that asks this node for something.
    pub(super) fn asks(&mut self, service: RequestedService) {
        self.invite(service, NODE, Flags::empty());
    }

    pub(super) fn command(&mut self, command: NmtCommandId) {
        self.command_to(NODE, command, &[]);
    }

    pub(super) fn command_to(&mut self, to: NodeId, command: NmtCommandId, data: &[u8]) {
        self.of_mn(group::ASND, to, Body::NmtCommand(NmtCommand { command, data }));
    }

    /// A command of a node that is not the managing node.
    pub(super) fn command_of(&mut self, from: NodeId, command: NmtCommandId) {
        self.hears(group::ASND, NODE, from, Body::NmtCommand(NmtCommand { command, data: &[] }));
    }

    /// A command, of which the node has not done yet what follows.
    pub(super) fn command_undrained(&mut self, command: NmtCommandId) {
        self.undrained(group::ASND, Body::NmtCommand(NmtCommand { command, data: &[] }));
    }

    /// A poll, of which the answer is not fetched.
    pub(super) fn preq_undrained(&mut self) {
        self.undrained(
            MAC,
            Body::Preq(Preq { flags: Flags::DATA_VALID, pdo_version: PdoVersion(0), data: &[0] }),
        );
    }

    /// A SoA that asks this node for something; the answer is not fetched.
    pub(super) fn asks_undrained(&mut self, service: RequestedService) {
        let (state, target) = (NmtStateCode::OPERATIONAL, NODE);
        let soa = Soa { state, flags: Flags::empty(), service, target, version: POWERLINK_V2 };
        self.undrained(group::SOA, Body::Soa(soa));
    }

    fn undrained(&mut self, destination: MacAddress, body: Body<'_>) {
        let mut buffer = [0; MAX_FRAME];
        let frame = Frame { destination, source: MN_MAC, to: NODE, from: NodeId::MANAGING_NODE, body };
        self.node.input(self.now, Input::Frame(frame.emit(&mut buffer).unwrap()));
    }

    /// SDO of the managing node, from the sequence layer on.
    pub(super) fn sdo(&mut self, hex: &str) {
        self.sdo_of(NodeId::MANAGING_NODE, hex);
    }

    /// A client opens a connection, within one asynchronous phase.
    pub(super) fn opens_connection(&mut self, client: NodeId) {
        for frame in ["00 01 00 00", "01 02 00 00"] {
            self.sdo_of(client, frame);
            self.asks(RequestedService::UNSPECIFIED_INVITE);
        }
    }

    /// SDO of any client, from the sequence layer on.
    pub(super) fn sdo_of(&mut self, client: NodeId, hex: &str) {
        let body: Vec<u8> = hex.split(' ').map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect();
        let service = crate::wire::ServiceId::SDO;
        self.hears(group::ASND, NODE, client, Body::OtherAsnd(service, &body));
    }

    /// The managing node writes an object, with an invitation for each answer.
    ///
    /// # Errors
    /// The abort code of the node.
    #[track_caller]
    pub(super) fn writes(&mut self, index: u16, sub: u8, value: &[u8]) -> Result<(), AbortCode> {
        let [low, high] = index.to_le_bytes();
        let data = [&[low, high, sub, 0], value].concat();
        self.asks_object(SdoCommandId::WRITE_BY_INDEX, &data).map(|_| ())
    }

    /// The managing node reads an object.
    ///
    /// # Errors
    /// The abort code of the node.
    #[track_caller]
    pub(super) fn reads(&mut self, index: u16, sub: u8) -> Result<Vec<u8>, AbortCode> {
        let [low, high] = index.to_le_bytes();
        self.asks_object(SdoCommandId::READ_BY_INDEX, &[low, high, sub, 0])
    }

    #[track_caller]
    fn asks_object(&mut self, command: SdoCommandId, data: &[u8]) -> Result<Vec<u8>, AbortCode> {
        self.sends_command(SdoCommand::request(0, command, data));
        let last = self.last.clone();
        let Ok(Frame { body: Body::Sdo(Sdo { command: Some(answer), .. }), .. }) = Frame::parse(&last) else {
            panic!("no answer: {last:02X?}")
        };
        assert_eq!(Some(answer.transaction), self.sdo_number);
        self.forget();
        answer.abort().map_or_else(|| Ok(answer.data.to_vec()), Err)
    }

    /// The managing node sends an SDO command with the next number, which is its transaction as well if it has none, and invites
    /// the answer. It opens the connection before the first one.
    pub(super) fn sends_command(&mut self, command: SdoCommand<'_>) {
        if self.sdo_number.is_none() {
            for opening in ["00 01 00 00", "01 02 00 00"] {
                self.sdo(opening);
                self.gives_a_slot();
            }
        }
        let last = self.sdo_number.unwrap_or(0);
        let number = (last + 1) & 0x3F;
        self.sdo_number = Some(number);
        let transaction = if command.transaction == 0 { number } else { command.transaction };
        let command = SdoCommand { transaction, ..command };
        let sequence = SdoSequence {
            receive: SequenceHalf::new(last, Con::Valid),
            send: SequenceHalf::new(number, Con::Valid),
        };
        self.of_mn(group::ASND, NODE, Body::Sdo(Sdo { sequence, command: Some(command) }));
        self.gives_a_slot();
    }

    /// The next asynchronous slot, with the cycle before it where there is one.
    pub(super) fn gives_a_slot(&mut self) {
        if self.node.state().is_cyclic() {
            self.soc();
            self.preq(Flags::DATA_VALID, &[0]);
        }
        self.asks(RequestedService::UNSPECIFIED_INVITE);
    }

    /// A whole cycle with a poll.
    pub(super) fn cycle(&mut self) {
        self.soc();
        self.preq(Flags::DATA_VALID, &[0]);
        self.soa();
        self.wait(Duration::from_millis(CYCLE));
    }

    /// Time passes; the node is called when it wants to be.
    pub(super) fn wait(&mut self, span: Duration) {
        let end = self.now + span;
        while let Some(deadline) = self.node.deadline().filter(|deadline| deadline.at <= end) {
            self.now = deadline.at;
            self.node.input(self.now, Input::Tick);
            self.drain();
        }
        self.now = end;
    }

    pub(super) fn link(&mut self, event: LinkEvent) {
        self.node.input(self.now, Input::Link(event));
        self.drain();
    }

    #[track_caller]
    pub(super) fn is(&self, state: NmtState) {
        assert_eq!(self.node.state(), state);
    }

    #[track_caller]
    pub(super) fn says(&mut self, words: &str) {
        assert!(!self.sent.is_empty(), "it says nothing instead of: {words}");
        assert_eq!(self.sent.remove(0), words);
    }

    #[track_caller]
    pub(super) fn says_nothing(&mut self) {
        assert_eq!(self.sent, [""; 0]);
    }

    pub(super) fn forget(&mut self) {
        self.sent.clear();
        self.events.clear();
    }

    #[track_caller]
    pub(super) fn tells(&mut self, event: NodeEvent) {
        assert!(self.events.contains(&event), "{event:?} is not in {:?}", self.events);
        self.events.clear();
    }
}
