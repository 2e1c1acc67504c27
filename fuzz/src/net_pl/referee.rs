//! Who sends what when, and what comes of it: seen from the wire, where nobody can lie about who sends. It shares nothing with
//! the machines.
//!
//! | Rule | |
//! |---|---|
//! | controlled nodes | each frame is what an invitation asked for that was on the wire, one for each; in `BasicEthernet` an SDO server answers unasked |
//! | the managing node | after an invitation it waits for the answer, or until the time for it is over |
//! | inputs | the managing node tells their end once, and only of those that it has told |
//! | outputs | those of an application, given to the managing node for this node; told as valid in `Operational` only, and after a PReq with RD |

use std::cell::RefCell;
use std::collections::HashSet;
use std::rc::Rc;
use std::time::Duration;

use devicenet_tests::powerlink::Event;
use link_core::Instant;
use powerlink_core::NodeId;
use powerlink_core::managing::{Config, MnEvent};
use powerlink_core::nmt::NmtState;
use powerlink_core::node::NodeEvent;
use powerlink_core::wire::{Body, Flags, Frame, RequestedService};
use transport_mock::ethernet::{FrameRecord, Record, StationId};

/// What was done to frames on their way.
#[derive(Default)]
pub(super) struct Disturbed {
    /// Frames that arrived twice, where, and when they were sent.
    pub(super) twice: Vec<(StationId, Instant, Vec<u8>)>,
    /// The managing node got a frame late or twice: it may take that for the answer to another question.
    pub(super) answers: bool,
}

pub(super) struct Referee {
    nodes: Vec<Node>,
    config: Config,
    mn: StationId,
    /// The last invitation of the managing node that is not answered: of whom, until when it waits.
    open: Option<(NodeId, Instant)>,
    disturbed: Rc<RefCell<Disturbed>>,
}

/// What is known of a node.
struct Node {
    id: StationId,
    state: NmtState,
    /// When it was in `BasicEthernet` last.
    basic: Option<Instant>,
    /// What it was asked for, and when.
    invitations: Vec<(Invitation, Instant)>,
    /// Outputs that were given to the managing node for it.
    given: HashSet<u8>,
    /// A PReq with RD was sent to it since it began.
    had_valid_poll: bool,
    /// The managing node told that it has inputs of it, and no end of them.
    has_inputs: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Invitation {
    Poll,
    Ident,
    Status,
    NmtRequest,
    Generic,
}

impl Referee {
    pub(super) fn new(nodes: u8, config: Config, mn: StationId, ids: &[StationId]) -> Self {
        let nodes = ids.iter().take(nodes.into()).map(|&id| Node::new(id)).collect();
        Self { nodes, config, mn, open: None, disturbed: Rc::default() }
    }

    pub(super) fn disturbed(&self) -> Rc<RefCell<Disturbed>> {
        Rc::clone(&self.disturbed)
    }

    /// What is on its way to the node meanwhile, its new life may answer.
    pub(super) fn power_cycle(&mut self, at: Instant, number: u8) {
        let node = &mut self.nodes[usize::from(number) - 1];
        node.invitations.retain(|(_, sent)| at.saturating_since(*sent) < A_WHILE);
        let (given, invitations) = (std::mem::take(&mut node.given), std::mem::take(&mut node.invitations));
        *node = Node { given, invitations, has_inputs: node.has_inputs, ..Node::new(node.id) };
    }

    /// Another managing node does not know whom the last one asked.
    pub(super) fn restarts_mn(&mut self) {
        self.open = None;
        self.nodes.iter_mut().for_each(|node| node.has_inputs = false);
    }

    pub(super) fn gives(&mut self, number: u8, outputs: u8) {
        if let Some(node) = self.nodes.get_mut(usize::from(number) - 1) {
            node.given.insert(outputs);
        }
    }

    /// Whether the managing node has inputs of a node.
    pub(super) fn inputs(&self, number: u8, has_inputs: bool) {
        let node = &self.nodes[usize::from(number) - 1];
        assert_eq!(node.has_inputs, has_inputs, "node {number}: what was told of its inputs");
    }

    /// What the application of a node has.
    pub(super) fn outputs(&self, number: u8, outputs: u8) {
        let node = &self.nodes[usize::from(number) - 1];
        assert!(outputs == 0 || node.given.contains(&outputs), "node {number} has outputs that nobody gave");
    }

    pub(super) fn judge(&mut self, records: &[Record<Event>]) {
        let twice = std::mem::take(&mut self.disturbed.borrow_mut().twice);
        for (to, arrived, bytes) in twice {
            if let (Ok(frame), Some(node)) =
                (Frame::parse(&bytes), self.nodes.iter().position(|node| node.id == to))
            {
                self.invited(node, arrived, &frame);
            }
        }
        for record in records {
            match record {
                Record::Frame(frame) => self.frame(frame),
                Record::Event { at, station, event: Event::Cn(event) } => self.event(*at, *station, event),
                Record::Event { event: Event::Mn(MnEvent::Inputs { node, is_valid }), .. } => {
                    let had = &mut self.nodes[usize::from(node.0) - 1].has_inputs;
                    assert!(*had || *is_valid, "{node}: the end of inputs that there are not");
                    *had = *is_valid;
                }
                Record::Event { event: Event::Mn(_), .. } | Record::Link { .. } => {}
            }
        }
    }

    fn frame(&mut self, record: &FrameRecord) {
        let frame = Frame::parse(&record.bytes);
        if let Some(index) = self.nodes.iter().position(|node| Some(node.id) == record.from) {
            let frame = frame.unwrap_or_else(|error| panic!("node {} sends nonsense: {error}", index + 1));
            return self.answer(index, record, &frame);
        }
        // A stranger may answer for a node, if only by the head of a frame.
        if record.from.is_none()
            && let Some((asked, _)) = self.open
            && record.bytes.get(16) == Some(&asked.0)
        {
            self.open = None;
        }
        if Some(self.mn) == record.from {
            let frame = frame.as_ref().unwrap_or_else(|error| panic!("the MN sends nonsense: {error}"));
            self.turn(record, frame);
        }
        if let Ok(frame) = frame {
            (0..self.nodes.len()).for_each(|index| self.invited(index, record.end, &frame));
        }
    }

    /// Who is asked for what by a frame of a managing node, whoever sent it, and when.
    fn invited(&mut self, index: usize, at: Instant, frame: &Frame<'_>) {
        if frame.from != NodeId::MANAGING_NODE {
            return;
        }
        let number = NodeId(index as u8 + 1);
        let invitation = match &frame.body {
            Body::Preq(preq) if frame.to == number => {
                self.nodes[index].had_valid_poll |= preq.flags.contains(Flags::DATA_VALID);
                Invitation::Poll
            }
            Body::Soa(soa) if soa.target == number => match soa.service {
                RequestedService::IDENT_REQUEST => Invitation::Ident,
                RequestedService::STATUS_REQUEST => Invitation::Status,
                RequestedService::NMT_REQUEST_INVITE => Invitation::NmtRequest,
                RequestedService::UNSPECIFIED_INVITE => Invitation::Generic,
                _ => return,
            },
            _ => return,
        };
        self.nodes[index].invitations.push((invitation, at));
    }

    /// A controlled node sends.
    fn answer(&mut self, index: usize, record: &FrameRecord, frame: &Frame<'_>) {
        let (number, node) = (NodeId(index as u8 + 1), &mut self.nodes[index]);
        assert_eq!(frame.from, number, "{frame}: it sends under its own number");
        let invitation = match frame.body {
            Body::Pres(_) => Invitation::Poll,
            Body::IdentResponse(_) => Invitation::Ident,
            Body::StatusResponse(_) => Invitation::Status,
            Body::NmtRequest(_) => Invitation::NmtRequest,
            Body::Sdo(_) => Invitation::Generic,
            _ => panic!("{frame}: no controlled node sends that"),
        };
        if let Some((asked, _)) = self.open
            && asked == number
        {
            self.open = None;
        }
        if let Some(place) = node.invitations.iter().position(|(known, _)| *known == invitation) {
            node.invitations.swap_remove(place);
            return;
        }
        let is_basic = node.state == NmtState::BasicEthernet
            || node.basic.is_some_and(|basic| record.start.saturating_since(basic) < A_WHILE);
        assert!(is_basic && invitation == Invitation::Generic, "{frame}: nobody asked for it");
    }

    /// The managing node sends.
    fn turn(&mut self, record: &FrameRecord, frame: &Frame<'_>) {
        assert_eq!(frame.from, NodeId::MANAGING_NODE, "{frame}");
        if let Some((asked, until)) = self.open.take() {
            let is_patient = record.start >= until || self.disturbed.borrow().answers;
            assert!(is_patient, "{frame}: at {}, {asked} had time until {until}", record.start);
        }
        let wait = match &frame.body {
            Body::Preq(_) => Some((frame.to, PRES_TIMEOUT)),
            Body::Soa(soa) if soa.target != NodeId::NONE && soa.target != NodeId::MANAGING_NODE => {
                Some((soa.target, self.config.async_slot))
            }
            _ => None,
        };
        self.open = wait.map(|(node, wait)| (node, record.start + wait));
    }

    fn event(&mut self, at: Instant, station: StationId, event: &NodeEvent) {
        let Some(node) = self.nodes.iter_mut().find(|node| node.id == station) else { return };
        match event {
            NodeEvent::StateChanged { from, to, .. } => {
                node.state = *to;
                if *from == NmtState::BasicEthernet {
                    node.basic = Some(at);
                }
            }
            NodeEvent::ProcessData { is_valid: true, .. } => {
                assert_eq!(node.state, NmtState::Operational, "{station} takes outputs at {at}");
                assert!(node.had_valid_poll, "{station} takes outputs that do not count at {at}");
            }
            _ => {}
        }
    }
}

impl Node {
    fn new(id: StationId) -> Self {
        Self {
            id,
            state: NmtState::Off,
            basic: None,
            invitations: Vec::new(),
            given: HashSet::new(),
            had_valid_poll: false,
            has_inputs: false,
        }
    }
}

/// Of every plan of the suites.
const PRES_TIMEOUT: Duration = Duration::from_micros(25);
/// What an adapter may still hold.
const A_WHILE: Duration = Duration::from_millis(2);
