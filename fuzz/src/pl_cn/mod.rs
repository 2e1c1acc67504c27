//! A controlled node of POWERLINK, against a second, small program.
//!
//! What the bytes say happens to the machine; after each input every frame and event must be what the model allows:
//!
//! - nothing is sent but the answer to a PReq or to an invitation, one frame to each, of 60 to 1514 bytes, in the states in
//!   which that may be; without a managing node (`BasicEthernet`) SDO alone;
//! - a PRes tells the state in which the poll came, and has its constant length; an IdentResponse has 176 bytes; what RS and PR
//!   announce is sent when it is invited, and nothing else;
//! - each state follows from what happened, and from nothing else but a threshold that an error tells of;
//! - EN changes only when the managing node has seen the last errors, which stay as they are until then;
//! - outputs change by process data in `ReadyToOperate` and `Operational`, by SDO and by resets, and stay within their range; an
//!   input that could not be read is told, and RD says so;
//! - counters grow, and an input is over after few actions.

mod device;
mod heard;
mod model;
mod ops;
mod signalling;
mod states;

use core::time::Duration;

use arbitrary::Unstructured;
use link_core::Instant;
use link_core::ethernet::{Action, Input, MAX_FRAME, MacAddress, Machine};
use powerlink_core::NodeId;
use powerlink_core::ethernet::group;
use powerlink_core::node::NodeEvent;
use powerlink_core::wire::{
    Body, EntryType, ErrorEntry, Flags, Frame, NmtCommand, NmtCommandId, NmtStateCode, NodeList,
    POWERLINK_V2, PdoVersion, Preq, Pres, RequestedService, ServiceId, Soa, Soc,
};

use device::{Device, MAC, NODE, Node};
use heard::Heard;
use model::{Model, Why};
use ops::{Application, Op, Sdo};

/// Does to a controlled node what the bytes say.
pub fn run(data: &[u8]) {
    let mut input = Unstructured::new(data);
    let Ok(config) = device::config(&mut input) else { return };
    let node = Node::new(config, Device::default()).expect("a valid configuration");
    let (model, now) = (Model::new(&node), Instant::ZERO);
    let mut bench = Bench { model, node, now, told: now, clients: [Client::NEW; 2] };
    bench.application(Application::PowerOn);
    while !input.is_empty() {
        let Ok(op) = ops::op(&mut input) else { return };
        bench.apply(op);
    }
}

/// The machine, the model, and what a managing node and a tool know.
struct Bench {
    node: Node,
    model: Model,
    now: Instant,
    /// The latest time that the node was told.
    told: Instant,
    /// The managing node, and a diagnostic device.
    clients: [Client; 2],
}

/// A client that keeps to the protocol.
struct Client {
    is_open: bool,
    /// Its last number, and the last of the server.
    sent: u8,
    received: u8,
    transaction: u8,
    /// Its last command, from the sequence layer on.
    last: Vec<u8>,
}

impl Client {
    const NEW: Self = Self { is_open: false, sent: 0, received: 0, transaction: 0, last: Vec::new() };
}

impl Bench {
    fn apply(&mut self, op: Op) {
        match op {
            Op::Tick(span) => self.tick(self.now + span),
            Op::Elapse(span) => self.now += span,
            Op::Past(span) => {
                let past = self.now.saturating_sub(span);
                self.step_at(past, Why::Tick, |node| node.input(past, Input::Tick));
            }
            Op::Deadline { early } => {
                let Some(deadline) = self.node.deadline() else { return };
                let at = deadline.at.saturating_sub(Duration::from_nanos(early.into())).max(self.now);
                if at < self.now + LONGEST_WAIT {
                    self.tick(at);
                }
            }
            Op::Soc { from, multiplexed } => self.soc(NodeId(from), if multiplexed { 0x80 } else { 0 }),
            Op::Preq { from, flags, version, size, data, is_padded } => {
                let body = [&[0x03, NODE.0, from, 0, flags, 0, version, 0][..], &word(size), &data].concat();
                let mut bytes = [&MAC.0[..], &MN.0, &[0x88, 0xAB], &body].concat();
                if is_padded {
                    bytes.resize(bytes.len().max(60), 0);
                }
                self.hear(&bytes);
            }
            Op::Soa { service, is_own, flags } => {
                self.soa(service, if is_own { NODE } else { NodeId(2) }, flags)
            }
            Op::Command { from, command, whom } => {
                let to = [NODE, NodeId::BROADCAST, NodeId(2), NodeId::BROADCAST][usize::from(whom)];
                let mut list = NodeList::default();
                list.insert(if whom == 3 { NODE } else { NodeId(command) });
                let command = NmtCommand { command: NmtCommandId(command), data: &list.0 };
                self.send(group::ASND, to, NodeId(from), Body::NmtCommand(command));
            }
            Op::Pres { from, flags, version, data } => {
                let pres = Pres {
                    state: NmtStateCode::OPERATIONAL,
                    flags: Flags::from_bits_retain(flags),
                    request: Default::default(),
                    pdo_version: PdoVersion(version),
                    data: &data,
                };
                self.send(group::PRES, NodeId::BROADCAST, NodeId(from % 4), Body::Pres(pres));
            }
            Op::Sdo { is_diagnostic, frame } => self.client(usize::from(is_diagnostic), frame),
            Op::Sequence { bytes, data } => self.sdo(NodeId::MANAGING_NODE, &[&bytes, &data[..]].concat()),
            Op::Group { group, bytes } => {
                let head = [0x01, 0x11, 0x1E, 0, 0, group, 2, 0, 0, 0, 0, 0xF0, 0x88, 0xAB];
                self.hear(&[&head, &bytes[..]].concat());
            }
            Op::Link(event) => {
                let now = self.now;
                self.step(Why::Link(event), |node| node.input(now, Input::Link(event)));
            }
            Op::Application(application) => self.application(application),
            Op::Cycles(count) => (0..=count).for_each(|_| self.cycle()),
            Op::Start(depth) => self.start(depth),
            Op::Status { reset } => {
                let ea = if self.model.signalling.en { 0x04 } else { 0 };
                self.soa(0x02, NODE, ea | if reset { 0x02 } else { 0 });
            }
            Op::Bytes(bytes) => self.hear(&bytes),
        }
    }

    fn tick(&mut self, at: Instant) {
        self.now = self.now.max(at);
        let now = self.now;
        self.step(Why::Tick, |node| node.input(now, Input::Tick));
    }

    /// SoC, PReq with EA = EN, SoA, and the time of a cycle.
    fn cycle(&mut self) {
        self.soc(NodeId::MANAGING_NODE, 0);
        self.poll();
        self.soa(0, NodeId::NONE, 0);
        self.tick(self.now + Duration::from_millis(20));
    }

    fn poll(&mut self) {
        let flags = if self.model.signalling.en { Flags::EXCEPTION_ACKNOWLEDGE } else { Flags::empty() };
        let preq =
            Preq { flags: flags | Flags::DATA_VALID, pdo_version: PdoVersion(0), data: &[1, 2, 3, 4, 5] };
        self.of_mn(MAC, NODE, Body::Preq(preq));
    }

    /// Both steps of the error signalling, then state by state.
    fn start(&mut self, depth: u8) {
        self.soa(0, NodeId::NONE, 0);
        self.soa(0x02, NODE, 0x02);
        self.soa(0x02, NODE, 0);
        let commands = [NmtCommandId::ENABLE_READY_TO_OPERATE, NmtCommandId::START_NODE];
        if depth > 0 {
            self.cycle();
        }
        for command in commands.into_iter().take(usize::from(depth).saturating_sub(1)) {
            self.of_mn(group::ASND, NODE, Body::NmtCommand(NmtCommand { command, data: &[] }));
            self.cycle();
        }
    }

    fn soc(&mut self, from: NodeId, flags: u8) {
        let soc = Soc { flags: Flags::from_bits_retain(flags), ..Soc::default() };
        self.send(group::SOC, NodeId::BROADCAST, from, Body::Soc(soc));
    }

    fn soa(&mut self, service: u8, target: NodeId, flags: u8) {
        let soa = soa(service, target, flags);
        self.of_mn(group::SOA, NodeId::BROADCAST, soa);
    }

    fn of_mn(&mut self, destination: MacAddress, to: NodeId, body: Body<'_>) {
        self.send(destination, to, NodeId::MANAGING_NODE, body);
    }

    fn send(&mut self, destination: MacAddress, to: NodeId, from: NodeId, body: Body<'_>) {
        let mut buffer = [0; MAX_FRAME];
        let frame = Frame { destination, source: MN, to, from, body };
        let bytes = frame.emit(&mut buffer).expect("short enough").to_vec();
        self.hear(&bytes);
    }

    /// From the sequence layer on.
    fn sdo(&mut self, from: NodeId, bytes: &[u8]) {
        self.send(group::ASND, NODE, from, Body::OtherAsnd(ServiceId::SDO, bytes));
    }

    fn client(&mut self, which: usize, frame: Sdo) {
        let from = [NodeId::MANAGING_NODE, NodeId::DIAGNOSTIC][which];
        let client = &mut self.clients[which];
        let bytes = match frame {
            Sdo::Open if client.is_open => vec![client.received << 2 | 2, client.sent << 2 | 2, 0, 0],
            Sdo::Open => {
                *client = Client { is_open: true, ..Client::NEW };
                self.sdo(from, &[0, 1, 0, 0]);
                vec![1, 2, 0, 0]
            }
            Sdo::Command { id, segmentation, wants_acknowledge, data } => {
                client.sent = (client.sent + 1) & 0x3F;
                if segmentation & 0x20 == 0 {
                    client.transaction = client.transaction.wrapping_add(1);
                }
                let scon = if wants_acknowledge { 3 } else { 2 };
                let sequence = [client.received << 2 | 2, client.sent << 2 | scon, 0, 0];
                let head =
                    [&[0, client.transaction, segmentation, id], &word(data.len())[..], &[0, 0]].concat();
                client.last = [&sequence[..], &head, &data].concat();
                client.last.clone()
            }
            Sdo::Again => client.last.clone(),
            Sdo::Close => {
                *client = Client::NEW;
                vec![0, 0, 0, 0]
            }
        };
        self.sdo(from, &bytes);
    }

    fn application(&mut self, what: Application) {
        let now = self.now;
        match what {
            Application::PowerOn => self.step(Why::PowerOn, |node| node.power_on(now)),
            Application::Reset => self.step(Why::Reset, |node| node.reset(now)),
            Application::SwitchOff => self.step(Why::SwitchOff, |node| node.switch_off(now)),
            Application::Ready => self.step(Why::Ready, |node| {
                let is_asked = node.state() == powerlink_core::nmt::NmtState::PreOperational2;
                assert_eq!(node.ready(now).is_ok(), is_asked);
            }),
            Application::Request(command) => {
                let id = NmtCommandId(command);
                let is_taken = self.node.request_command(id, NODE).is_ok();
                self.model.asked(id, is_taken);
            }
            Application::Error(mode) => {
                let kind = EntryType(u16::from(mode) << 12 | 0x0001);
                let entry = ErrorEntry { kind, additional: 7, ..ErrorEntry::default() };
                self.step(Why::Other, |node| {
                    assert_eq!(node.report_error(now, entry).is_ok(), mode & 0x03 != 0, "{kind:?}");
                });
            }
            Application::Inputs(value) => self.node.objects_mut().inputs = (value, u64::from(value) << 32),
            Application::Validity(are_valid) => {
                self.node.set_inputs_valid(are_valid);
                self.model.are_inputs_valid = are_valid;
            }
            Application::Register(register) => self.node.set_error_register(register),
        }
    }

    fn hear(&mut self, bytes: &[u8]) {
        let (now, heard) = (self.now, heard::read(bytes));
        // What the node would say of its queue at this very moment.
        let waiting = match heard {
            Heard::Soa { service: 0xFF, is_own: true, .. } => self.waiting(),
            _ => None,
        };
        if let Heard::Sdo { from, transaction: Some(transaction) } = heard {
            self.model.transactions.insert((from, transaction));
        }
        self.step(Why::Heard(heard, waiting), |node| node.input(now, Input::Frame(bytes)));
    }

    /// PR and RS of a StatusResponse of a copy of the node.
    fn waiting(&self) -> Option<u8> {
        let mut copy = self.node.clone();
        let mut buffer = [0; MAX_FRAME];
        let soa = soa(0x02, NODE, 0);
        let (to, from) = (NodeId::BROADCAST, NodeId::MANAGING_NODE);
        let frame = Frame { destination: group::SOA, source: MN, to, from, body: soa };
        copy.input(self.now, Input::Frame(frame.emit(&mut buffer).expect("short")));
        let mut buffer = [0; MAX_FRAME];
        while let Some(action) = copy.poll(self.now, &mut buffer) {
            if let Action::Transmit(bytes) = action {
                return Some(bytes[19]);
            }
        }
        None
    }

    fn step(&mut self, why: Why, what: impl FnOnce(&mut Node)) {
        self.step_at(self.now, why, what);
    }

    /// Does something to the machine, fetches what follows, and has it judged. Time does not run backwards for it.
    fn step_at(&mut self, now: Instant, why: Why, what: impl FnOnce(&mut Node)) {
        self.told = self.told.max(now);
        let before = model::Before::of(&self.node);
        what(&mut self.node);
        let (mut sent, mut events) = (Vec::new(), Vec::<NodeEvent>::new());
        let mut buffer = [0xA5; MAX_FRAME];
        while let Some(action) = self.node.poll(now, &mut buffer) {
            match action {
                Action::Transmit(bytes) => sent.push(bytes.to_vec()),
                Action::Event(event) => events.push(event),
            }
            assert!(sent.len() + events.len() <= MOST_ACTIONS, "work without end: {events:?}");
        }
        for bytes in &sent {
            self.follow(bytes);
        }
        self.model.judge(why, &before, &sent, &events, &self.node, self.told);
    }

    /// A client takes note of the number of an answer.
    fn follow(&mut self, bytes: &[u8]) {
        for (client, node) in self.clients.iter_mut().zip([240, 253]) {
            if bytes[14] == 0x06 && bytes[17] == 0x05 && bytes[15] == node {
                client.received = bytes[19] >> 2;
            }
        }
    }
}

fn soa(service: u8, target: NodeId, flags: u8) -> Body<'static> {
    Body::Soa(Soa {
        state: NmtStateCode::PRE_OPERATIONAL_1,
        flags: Flags::from_bits_retain(flags),
        service: RequestedService(service),
        target,
        version: POWERLINK_V2,
    })
}

fn word(number: usize) -> [u8; 2] {
    u16::try_from(number).unwrap_or(u16::MAX).to_le_bytes()
}

const MN: MacAddress = MacAddress([2, 0, 0, 0, 0, 0xF0]);
const LONGEST_WAIT: Duration = Duration::from_secs(100);
const MOST_ACTIONS: usize = 64;
