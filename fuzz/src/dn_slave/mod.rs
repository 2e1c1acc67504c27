//! A slave, against a second, small program.
//!
//! Operations that are legal at that moment are done to the machine and to the reference model; after each, every frame,
//! withdrawal and event of the machine must be what the model allows and demands. So:
//!
//! - data go out only on established connections, and those exist only for the master that owns the slave;
//! - one frame at most is in flight on each line, group 1 lines in the order of their identifiers;
//! - an allocation changes everything or nothing, and attribute 5 is always that of the model;
//! - connections time out to the nanosecond, whatever the watchdog action and however late the tick;
//! - outputs are those of whole messages, at rest when the master is idle or lost;
//! - off line nothing is sent but what network access sends.

mod device;
mod model;
mod observe;
mod ops;

use core::time::Duration;

use arbitrary::Unstructured;
use devicenet_core::slave::{Config, IoMode, Slave};
use link_core::frame::standard_id;
use link_core::{Frame, Input, Instant, LinkEvent, Machine, TxOutcome, TxToken};

use device::Device;
use model::{LONGEST, Model, Sender};
use ops::Op;

/// Does to a slave what the bytes say.
pub fn run(data: &[u8]) {
    let mut input = Unstructured::new(data);
    let Ok((config, device)) = device::config(&mut input) else { return };
    match input.arbitrary::<u8>() {
        Ok(kind) if kind & 1 == 0 => drive(Node::<0>::new(config, device), &mut input),
        Ok(_) => drive(Node::<2>::new(config, device), &mut input),
        Err(_) => {}
    }
}

fn drive<const DYNAMIC: usize>(mut node: Node<DYNAMIC>, input: &mut Unstructured<'_>) {
    node.bring_up();
    while !input.is_empty() {
        let Ok(op) = ops::op(input) else { return };
        if node.apply(op).is_none() {
            return;
        }
    }
}

/// The machine, the model, and what a port and an application know between them.
struct Node<const DYNAMIC: usize> {
    slave: Slave<Device, LONGEST, DYNAMIC>,
    model: Model,
    clock: Instant,
    link: Link,
    in_flight: Vec<InFlight>,
    /// What the application was told last.
    choice: u8,
    master: Option<u8>,
    /// As attribute 1 has them: instances 1 to 5, then the dynamic ones.
    states: Vec<u8>,
    modes: [IoMode; 4],
    /// The last input came after a moment at which the slave had wanted to be called.
    is_late: bool,
    /// Events that were lost, because everything that was overdue happened in one input.
    lost: u16,
}

struct InFlight {
    token: TxToken,
    /// Nobody of the model: network access.
    sender: Option<Sender>,
    asked_back: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Link {
    Up,
    OffTheBus,
    Down,
}

/// The model goes on.
type Known = Option<()>;

impl<const DYNAMIC: usize> Node<DYNAMIC> {
    fn new(config: Config, device: Device) -> Self {
        let model = Model::new(&config, &device, DYNAMIC);
        Self {
            slave: Slave::new(config, device).expect("the sizes are valid"),
            model,
            clock: Instant::ZERO,
            link: Link::Down,
            in_flight: Vec::new(),
            choice: 0,
            master: None,
            states: vec![0; 5 + DYNAMIC],
            modes: [IoMode::Inactive; 4],
            is_late: false,
            lost: 0,
        }
    }

    /// Power, and the two check requests.
    fn bring_up(&mut self) {
        self.input(Instant::ZERO, Input::Link(LinkEvent::Up));
        self.link = Link::Up;
        for _ in 0..2 {
            self.done(0, TxOutcome::Sent);
            self.input(self.clock + Duration::from_secs(1), Input::Tick);
        }
        assert!(self.model.online);
    }

    /// Does one operation, if it is possible now, and checks everything.
    fn apply(&mut self, op: Op) -> Known {
        let now = self.clock;
        let own = u16::from(self.model.mac);
        let request = 0x404 | own << 3;
        match op {
            Op::Elapse(span) => self.clock += span,
            Op::Tick(span) => self.input(now + span, Input::Tick)?,
            Op::TickInThePast(span) => self.input(now.saturating_sub(span), Input::Tick)?,
            Op::TickAtDeadline | Op::TickBeforeDeadline => {
                let Some(deadline) = self.slave.deadline() else { return Some(()) };
                let early = if op == Op::TickAtDeadline { 0 } else { 1 };
                let at = deadline.at.saturating_sub(Duration::from_nanos(early));
                if at < now + LONGEST_WAIT {
                    self.input(at, Input::Tick)?;
                }
            }
            Op::Frame(frame) => self.frame(&frame)?,
            Op::Unconnected { node, body } => {
                self.send(0x406 | own << 3, &[&[self.mac(node)], &body[..]].concat())?;
            }
            Op::Request { node, xid, body } => {
                self.send(request, &[&[self.mac(node) | u8::from(xid) << 6], &body[..]].concat())?;
            }
            Op::Fragment { node, xid, byte, data } => {
                let header = 0x80 | u8::from(xid) << 6 | self.mac(node);
                self.send(request, &[&[header, byte], &data[..]].concat())?;
            }
            Op::Acknowledge { node, count, status } => {
                let count = count.or(self.model.pipes[0].waiting()).unwrap_or(0);
                self.send(request, &[0x80 | self.mac(node), 0xC0 | count, status])?;
            }
            Op::Io { line, node, data } => {
                let id = match line {
                    0 => 0x405 | own << 3,
                    1 => 0x400 | u16::from(self.mac(node)) << 3,
                    2 => 0x402 | own << 3,
                    _ => 0x401 | u16::from(self.model.group) << 3,
                };
                self.send(id, &data)?;
            }
            Op::Done { which, sent } => {
                let outcome = if sent { TxOutcome::Sent } else { TxOutcome::Dropped };
                self.done(which, outcome)?;
            }
            Op::Link(event) => self.link(event)?,
            Op::Inputs(value) => self.change_inputs(value)?,
            Op::Ucmm { node, body } => {
                let client = self.mac(node);
                self.send(0x780 | u16::from(client), &[&[self.model.mac], &body[..]].concat())?;
            }
            Op::Dynamic { which, xid, body } => {
                if let Some((id, header)) = self.dynamic(which) {
                    self.send(id, &[&[header | u8::from(xid) << 6], &body[..]].concat())?;
                }
            }
            Op::InFragments { node, body } => self.in_fragments(request, self.mac(node), &body)?,
        }
        Some(())
    }

    fn mac(&self, node: u8) -> u8 {
        match node % 8 {
            0..=4 => 4,
            5 => 5,
            6 => (self.model.mac + 1) & 0x3F,
            _ => self.model.mac,
        }
    }

    fn dynamic(&self, which: usize) -> Option<(u16, u8)> {
        let open: Vec<_> = self.model.dynamic.iter().filter(|one| one.connection.exists()).collect();
        let one = open.get(which % open.len().max(1))?;
        let header = if one.group == model::Group::Two { one.client } else { self.model.mac };
        Some((one.consumed(self.model.mac), header))
    }

    /// Up to eight bytes of data.
    fn send(&mut self, id: u16, data: &[u8]) -> Known {
        let data = &data[..data.len().min(8)];
        self.frame(&Frame::new(standard_id(id), data).expect("at most eight bytes"))
    }

    /// A frame can be heard only on a bus.
    fn frame(&mut self, frame: &Frame) -> Known {
        if self.link == Link::Up { self.input(self.clock, Input::Frame(*frame)) } else { Some(()) }
    }

    /// The fragments of a request of two pieces or more, with every frame of the slave sent in between.
    fn in_fragments(&mut self, id: u16, mac: u8, body: &[u8]) -> Known {
        let pieces: Vec<&[u8]> = body.chunks(3).collect();
        for (at, piece) in pieces.iter().enumerate() {
            let kind = if at == 0 {
                0
            } else if at + 1 == pieces.len() {
                0x80
            } else {
                0x40
            };
            self.send(id, &[&[0x80 | mac, kind | at as u8], *piece].concat())?;
            while !self.in_flight.is_empty() && self.link == Link::Up {
                self.done(0, TxOutcome::Sent)?;
            }
        }
        Some(())
    }

    /// A controller that left the bus sends nothing.
    fn done(&mut self, which: usize, outcome: TxOutcome) -> Known {
        if self.in_flight.is_empty() {
            return Some(());
        }
        let frame = self.in_flight.remove(which % self.in_flight.len());
        let outcome = match outcome {
            TxOutcome::Sent if self.link == Link::Up => TxOutcome::Sent,
            _ if frame.asked_back => TxOutcome::Withdrawn,
            _ => TxOutcome::Dropped,
        };
        self.before(self.clock);
        if let Some(sender) = frame.sender {
            self.model.done(sender, outcome == TxOutcome::Sent);
        }
        self.after(self.clock, Input::TxDone(frame.token, outcome))
    }

    fn link(&mut self, event: LinkEvent) -> Known {
        match event {
            LinkEvent::Up => self.link = Link::Up,
            LinkEvent::Down => self.link = Link::Down,
            LinkEvent::BusOff if self.link == Link::Down => return Some(()),
            LinkEvent::BusOff => self.link = Link::OffTheBus,
            _ => {}
        }
        self.input(self.clock, Input::Link(event))
    }

    fn change_inputs(&mut self, value: u8) -> Known {
        for inputs in [&mut self.slave.application_mut().inputs, &mut self.model.inputs] {
            inputs.iter_mut().for_each(|bytes| bytes.fill(value));
        }
        let now = self.clock;
        self.model.advance(now);
        self.model.inputs_changed();
        self.slave.inputs_changed(now);
        self.drain(now);
        // Commands leave waits that are over to the tick that is due.
        self.input(now, Input::Tick)
    }

    /// An input that is nobody's answer.
    fn input(&mut self, now: Instant, input: Input) -> Known {
        self.before(now);
        if let Input::Frame(frame) = input
            && self.model.online
            && !frame.is_extended()
            && !frame.is_remote()
        {
            let id = frame.raw_id() as u16;
            let check = id == 0x407 | u16::from(self.model.mac) << 3;
            if !check && id < 0x7F0 && !self.model.frame(id, frame.data()) {
                return None;
            }
        }
        self.after(now, input)
    }

    /// Waits that ended before this moment ended before its input.
    fn before(&mut self, now: Instant) {
        self.clock = self.clock.max(now);
        self.is_late = self.slave.deadline().is_some_and(|deadline| deadline.at < now);
        self.model.advance(now);
        let before = self.model.now.saturating_sub(Duration::from_nanos(1));
        self.model.expire(before);
        let mut earlier = self.slave.clone();
        earlier.input(before, Input::Tick);
        self.model.online |= earlier.access().is_online();
    }

    fn after(&mut self, now: Instant, input: Input) -> Known {
        self.model.settle();
        self.model.expire(self.model.now);
        self.slave.input(now, input);
        self.drain(now);
        let mut ticked = self.slave.clone();
        ticked.input(now, Input::Tick);
        assert_eq!(ticked, self.slave, "a second tick changes nothing");
        Some(())
    }

    /// Network access has the say on whether the node is on line, and under which MAC ID.
    fn follow_access(&mut self) {
        let access = self.slave.access();
        let moved = access.mac_id().number() != self.model.mac;
        if self.model.online && (!access.is_online() || moved) {
            let wanted = self.model.leaving.is_some();
            self.model.lose_network(self.link != Link::Up);
            if wanted {
                self.model.reset();
            }
        }
        self.model.mac = access.mac_id().number();
        self.model.online = access.is_online();
    }
}

/// Nobody waits longer for a deadline: the clock has an end.
const LONGEST_WAIT: Duration = Duration::from_secs(100_000);
const OUTPUT_PENDING: &str = link_core::Deadline::now(Instant::ZERO).why;

#[cfg(test)]
mod tests {
    use super::*;

    /// MAC ID 10, no options, short messages.
    const PLAIN: [u8; 4] = [10, 0, 0, 0];
    const ALLOCATE: [u8; 5] = [5, 0, 0, 0x03, 0];
    const SET_RATE: [u8; 5] = [6, 0, 0x24, 75, 0];
    const SENT: [u8; 1] = [10];
    const POLL: [u8; 4] = [9, 0, 1, 0xA5];

    fn after(ops: &[&[u8]]) -> Node<0> {
        let bytes = [&PLAIN[..], &ops.concat()].concat();
        run(&bytes);
        let mut input = Unstructured::new(&bytes[..3]);
        let (config, device) = device::config(&mut input).unwrap();
        let mut node = Node::new(config, device);
        node.bring_up();
        let mut input = Unstructured::new(&bytes[4..]);
        while !input.is_empty() {
            node.apply(ops::op(&mut input).unwrap()).unwrap();
        }
        node
    }

    fn polled() -> Vec<u8> {
        [&ALLOCATE[..], &SENT, &SET_RATE, &SENT, &POLL].concat()
    }

    #[test]
    fn a_slave_is_polled() {
        let node = after(&[&polled()]);
        assert_eq!((node.choice, node.master, node.states[1]), (0x03, Some(4), 3));
        assert_eq!((node.model.outputs[0][0], node.in_flight.len()), (0xA5, 1));
    }

    #[test]
    fn a_slave_loses_its_master() {
        let node = after(&[&polled(), &SENT, &[0, 0xC1]]);
        assert_eq!((node.choice, node.states[1], node.model.outputs[0][0]), (0x01, 4, 0));
        let node = after(&[&polled(), &SENT, &[0, 0xCA]]);
        assert_eq!((node.choice, node.master), (0, None));
    }

    #[test]
    fn a_second_master_is_refused() {
        let node = after(&[&polled(), &SENT, &[5, 5, 0, 0x01, 1]]);
        assert_eq!(node.master, Some(4));
    }
}
