//! A network of probes, and what can be asked about it.

use std::collections::VecDeque;
use std::convert::Infallible;

use link_core::{
    Action, BitRate, Deadline, Frame, Input, Instant, LinkCommand, LinkEvent, Machine, TxOutcome, TxToken,
    frame::standard_id,
};
use transport_mock::bus::{BusError, Sender};
use transport_mock::record::{FrameRecord, Outcome};
use transport_mock::{BusConfig, Change, Counters, Ignore, Network, NodeConfig, NodeId, Record};

/// Does what it is told, and keeps what it hears.
#[derive(Clone, Debug, Default)]
pub(crate) struct Probe {
    actions: VecDeque<Action<Infallible>>,
    pub(crate) log: Vec<(Instant, Input)>,
    /// Resets its controller whenever it goes bus-off.
    pub(crate) recovers: bool,
    /// What it sends when it receives a frame.
    pub(crate) answer: Option<Frame>,
    now: Instant,
    next_token: u16,
}

impl Probe {
    pub(crate) fn send(&mut self, frame: Frame) -> TxToken {
        let token = TxToken(self.next_token);
        self.next_token += 1;
        self.actions.push_back(Action::Transmit(token, frame));
        token
    }

    pub(crate) fn withdraw(&mut self, token: TxToken) {
        self.actions.push_back(Action::Withdraw(token));
    }

    /// Withdraws the frame that was sent last.
    pub(crate) fn withdraw_last(&mut self) {
        if let Some(last) = self.next_token.checked_sub(1) {
            self.withdraw(TxToken(last));
        }
    }

    pub(crate) fn link(&mut self, command: LinkCommand) {
        self.actions.push_back(Action::Link(command));
    }

    pub(crate) fn frames(&self) -> Vec<Frame> {
        let frame = |(_, input): &(Instant, Input)| match input {
            Input::Frame(frame) => Some(*frame),
            _ => None,
        };
        self.log.iter().filter_map(frame).collect()
    }

    pub(crate) fn outcomes(&self) -> Vec<TxOutcome> {
        let outcome = |(_, input): &(Instant, Input)| match input {
            Input::TxDone(_, outcome) => Some(*outcome),
            _ => None,
        };
        self.log.iter().filter_map(outcome).collect()
    }

    pub(crate) fn link_events(&self) -> Vec<LinkEvent> {
        let event = |(_, input): &(Instant, Input)| match input {
            Input::Link(event) => Some(*event),
            _ => None,
        };
        self.log.iter().filter_map(event).collect()
    }

    pub(crate) fn when(&self, event: LinkEvent) -> Option<Instant> {
        self.log.iter().find(|(_, input)| *input == Input::Link(event)).map(|(at, _)| *at)
    }
}

impl Machine for Probe {
    type Event = Infallible;

    fn input(&mut self, now: Instant, input: Input) {
        self.now = now;
        if input != Input::Tick {
            self.log.push((now, input));
        }
        if self.recovers && input == Input::Link(LinkEvent::BusOff) {
            self.link(LinkCommand::Reset);
        }
        if let (Input::Frame(_), Some(frame)) = (input, self.answer.take()) {
            self.send(frame);
        }
    }

    fn poll(&mut self, _: Instant) -> Option<Action<Infallible>> {
        self.actions.pop_front()
    }

    fn deadline(&self) -> Option<Deadline> {
        (!self.actions.is_empty()).then(|| Deadline::now(self.now))
    }

    fn max_in_flight(&self) -> usize {
        64
    }
}

/// A frame record that can be kept.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Seen {
    pub(crate) start: Instant,
    pub(crate) end: Instant,
    pub(crate) frame: Frame,
    pub(crate) outcome: Outcome,
    pub(crate) senders: Vec<Sender>,
    pub(crate) receivers: Vec<usize>,
}

impl Seen {
    fn of(record: &FrameRecord<'_>) -> Self {
        Self {
            start: record.start,
            end: record.end,
            frame: *record.frame,
            outcome: record.outcome,
            senders: record.senders.to_vec(),
            receivers: record.receivers.iter().collect(),
        }
    }
}

/// A network at 500 kbit/s (a bit is 2 us) with what was seen on it.
pub(crate) struct Bench {
    pub(crate) network: Network<()>,
    pub(crate) frames: Vec<Seen>,
    pub(crate) errors: Vec<BusError>,
    pub(crate) counters: Vec<(Instant, NodeId, Counters)>,
    pub(crate) lines: Vec<String>,
    /// Whether anybody wants to see what happens.
    pub(crate) watched: bool,
}

pub(crate) const BIT: u64 = 2_000;

impl Bench {
    pub(crate) fn new(nodes: usize) -> Self {
        Self::with(BusConfig { shared: None, ..BusConfig::new(BitRate::K500, 1) }, nodes)
    }

    pub(crate) fn with(config: BusConfig, nodes: usize) -> Self {
        let mut network = Network::new(config);
        for node in 0..nodes {
            network.add_silent(NodeConfig::named(format!("probe {node}")), Probe::default());
        }
        let mut bench = Self {
            network,
            frames: Vec::new(),
            errors: Vec::new(),
            counters: Vec::new(),
            lines: Vec::new(),
            watched: true,
        };
        // Everybody has seen a free bus.
        bench.run_bits(12);
        bench
    }

    pub(crate) fn id(&self, node: usize) -> NodeId {
        self.network.nodes().nth(node).unwrap()
    }

    pub(crate) fn probe(&self, node: usize) -> &Probe {
        self.network.machine(self.id(node)).unwrap()
    }

    pub(crate) fn tell<R>(&mut self, node: usize, act: impl FnOnce(&mut Probe) -> R) -> R {
        let id = self.id(node);
        self.network.command(id, |probe: &mut Probe, _| act(probe)).unwrap()
    }

    pub(crate) fn send(&mut self, node: usize, frame: Frame) -> TxToken {
        self.tell(node, |probe| probe.send(frame))
    }

    pub(crate) fn change(&mut self, change: Change<()>) {
        let now = self.network.now();
        self.network.schedule(now, change);
    }

    pub(crate) fn counters(&self, node: usize) -> (u16, u16) {
        let Counters { tec, rec } = self.network.counters(self.id(node));
        (tec, rec)
    }

    pub(crate) fn run_bits(&mut self, bits: u64) {
        self.run_until(Instant::from_nanos(self.network.now().as_nanos() + bits * BIT));
    }

    pub(crate) fn run_until(&mut self, end: Instant) {
        let Self { network, frames, errors, counters, lines, watched } = self;
        if !*watched {
            return network.run_until(end, &mut Ignore);
        }
        network.run_until(end, &mut |record: &Record<'_, ()>| {
            lines.push(record.to_string());
            match record {
                Record::Frame(frame) => frames.push(Seen::of(frame)),
                Record::Error(error) => errors.push(*error),
                Record::Counters { at, node, counters: now } => counters.push((*at, *node, *now)),
                _ => {}
            }
        });
    }
}

pub(crate) fn data(id: u16, bytes: &[u8]) -> Frame {
    Frame::new(standard_id(id), bytes).unwrap()
}

pub(crate) fn bits(from: Instant, to: Instant) -> u64 {
    (to.as_nanos() - from.as_nanos()) / BIT
}
