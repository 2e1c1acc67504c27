//! Whole POWERLINK networks: a managing node and up to four controlled nodes on the simulated segment, with faults, and with
//! frames of strangers.
//!
//! Byte 0 is what the network is like:
//!
//! | Bits | Content |
//! |---|---|
//! | 1-0 | the controlled nodes, less one |
//! | 2 | the last of them is optional |
//! | 3 | the last of them is polled in every other cycle |
//! | 4 | the second of them is not polled at all |
//! | 5 | everybody is in operation before it begins |
//!
//! Then each operation is one byte with its argument behind it, taken modulo 12:
//!
//! | Byte | Operation | Argument |
//! |---|---|---|
//! | 0-2 | the network runs | [span](crate::input::span) |
//! | 3 | a power cycle of a node | which |
//! | 4 | the cable of a node is pulled, or plugged in | which |
//! | 5 | a power cycle of the managing node; from 0x80 on its power fails, and it comes back at the next 5 | |
//! | 6 | frames go wrong | how in bits 1-0 (lost, twice, wrong CRC, late), at which station in bits 4-2, how many in bits 7-5 |
//! | 7 | outputs of a node | which in bits 1-0, the value in bits 7-2 |
//! | 8 | inputs of the nodes | value |
//! | 9 | an NMT command of the application | which in bits 2-0, to whom in bits 5-3: a node, or all |
//! | 10 | a stranger says something | what |
//! | 11 | an object is read or written | of which node in bits 1-0, what in bits 7-2 |
//!
//! What must hold is judged by an observer who sees every frame with its real sender: it is the module `referee`. In the end
//! nothing goes wrong any more, and every node must be in operation.

mod referee;
mod stranger;

use std::time::Duration;

use arbitrary::Unstructured;
use devicenet_tests::powerlink::{Net, Station, TEXT, config, plan};
use powerlink_core::NodeId;
use powerlink_core::dictionary::ObjectAddress;
use powerlink_core::managing::{Config, NodePlan};
use powerlink_core::nmt::NmtState;
use powerlink_core::wire::NmtCommandId;
use transport_mock::ethernet::{Fate, SegmentConfig};

use referee::Referee;

/// Lets a network live as the bytes say.
pub fn run(data: &[u8]) {
    let mut input = Unstructured::new(data);
    let Ok(plan) = input.arbitrary::<u8>() else { return };
    let mut network = Network::new(plan);
    let mut left = MOST_OPERATIONS;
    while let (false, Ok([op, argument])) = (input.is_empty() || left == 0, input.arbitrary::<[u8; 2]>()) {
        network.apply(op, argument);
        left -= 1;
    }
    network.come_to_rest();
}

struct Network {
    net: Net,
    nodes: u8,
    /// How long it may still run before it comes to rest.
    left: Duration,
    referee: Referee,
}

impl Network {
    fn new(byte: u8) -> Self {
        let nodes = (byte & 3) + 1;
        let plans: Vec<NodePlan<'static>> = (1..=nodes)
            .map(|number| NodePlan {
                is_mandatory: number < nodes || byte & 0x04 == 0,
                multiplexed_slot: (number == nodes && byte & 0x08 != 0).then_some(1),
                is_async_only: number == 2 && byte & 0x10 != 0,
                ..plan(number)
            })
            .collect();
        // A node that was switched off and on unseen is noticed at its next StatusRequest.
        let status_period = Duration::from_millis(500);
        let config = Config { multiplexed_cycles: 2, status_period, ..config() };
        let net = Net::with(config, &plans, SegmentConfig::default());
        let referee = Referee::new(nodes, config, net.mn, &net.cns);
        let mut network = Self { net, nodes, left: LONGEST_RUN, referee };
        if byte & 0x20 != 0 {
            assert!(network.net.run_until_complete(3_000), "undisturbed it boots");
        }
        network.judge();
        network
    }

    fn apply(&mut self, op: u8, argument: u8) {
        let anyone = argument % self.nodes + 1;
        match op % 12 {
            0..=2 => {
                let span = crate::input::span(argument).min(self.left);
                self.left -= span;
                self.net.segment.run_for(span);
            }
            3 => {
                self.judge();
                self.referee.power_cycle(self.net.segment.now(), anyone);
                self.net.restart_cn(anyone);
            }
            4 => {
                let id = self.net.id(anyone);
                if self.net.segment.is_plugged(id) {
                    self.net.segment.cut(id);
                } else {
                    self.net.segment.plug(id);
                }
            }
            5 => {
                self.judge();
                self.referee.restarts_mn();
                self.net.kill_mn();
                if argument < 0x80 {
                    self.net.restart_mn();
                }
            }
            6 => self.fault(argument),
            7 => {
                let (node, value) = (argument & 3, argument >> 2);
                self.referee.gives(node + 1, value);
                // A node that is not there cannot be given any.
                self.with_mn(|mn| mn.set_outputs(NodeId(node + 1), &[value]).is_ok());
            }
            8 => {
                for number in 1..=self.nodes {
                    self.net.cn(number, |cn, _| cn.objects_mut().inputs = argument ^ number);
                }
            }
            9 => {
                let command = COMMANDS[usize::from(argument & 7)];
                let node = argument >> 3 & 7;
                self.with_mn(|mn| {
                    if node == 7 { mn.command_all(command) } else { mn.command(NodeId(node), command) }
                        .is_ok()
                });
            }
            10 => {
                let frame = stranger::frame(argument, self.nodes);
                self.net.segment.inject(&frame);
            }
            _ => {
                let (node, what) = (NodeId(argument & 3), usize::from(argument >> 2));
                let text = vec![argument; what * 4];
                self.with_mn(|mn| match what % 3 {
                    0 => mn.sdo_read(node, TEXT).is_ok(),
                    1 => mn.sdo_read(node, ObjectAddress::new(0x1018, what as u8)).is_ok(),
                    _ => mn.sdo_write(node, TEXT, &text[..text.len().min(252)]).is_ok(),
                });
            }
        }
        self.judge();
    }

    /// The next frames at a station go wrong.
    fn fault(&mut self, argument: u8) {
        let at = usize::from(argument >> 2 & 7) % (usize::from(self.nodes) + 1);
        let fate = match argument & 3 {
            0 => Fate::Lose,
            1 => Fate::Twice,
            2 => Fate::Corrupt,
            _ => Fate::Late(Duration::from_micros(700)),
        };
        let mut left = (argument >> 5) * 3 + 1;
        let (disturbed, mn) = (self.referee.disturbed(), self.net.mn);
        self.net.segment.add_fault(move |passage| {
            if left == 0 || passage.to.index() != at {
                return Fate::Pass;
            }
            left -= 1;
            let mut disturbed = disturbed.borrow_mut();
            disturbed.answers |= passage.to == mn && matches!(fate, Fate::Twice | Fate::Late(_));
            if fate == Fate::Twice {
                disturbed.twice.push((passage.to, passage.start, passage.bytes.to_vec()));
            }
            fate.clone()
        });
    }

    /// Asks something of the managing node, which may refuse it, or be dead.
    fn with_mn(&mut self, ask: impl FnOnce(&mut devicenet_tests::powerlink::Mn) -> bool) {
        if matches!(self.net.segment.machine(self.net.mn), Station::Mn(_)) {
            self.net.mn(|mn, _| ask(mn));
        }
    }

    fn judge(&mut self) {
        let records = self.net.segment.take_records();
        self.referee.judge(&records);
        for number in 1..=self.nodes {
            let outputs = self.net.cn(number, |cn, _| cn.objects().outputs);
            self.referee.outputs(number, outputs);
            if let Station::Mn(mn) = self.net.segment.machine(self.net.mn) {
                self.referee.inputs(number, mn.inputs(NodeId(number)).is_some());
            }
        }
    }

    /// Undisturbed, every node is in operation after a while.
    fn come_to_rest(&mut self) {
        self.net.segment.clear_faults();
        for number in 1..=self.nodes {
            let id = self.net.id(number);
            self.net.segment.plug(id);
        }
        if matches!(self.net.segment.machine(self.net.mn), Station::Dead) {
            self.net.restart_mn();
        }
        self.net.mn(|mn, _| mn.command_all(NmtCommandId::START_NODE).expect("it is a command"));
        // Whatever went wrong is noticed by now.
        self.net.run(1_500);
        self.judge();
        let is_complete = self.net.run_until_complete(20_000);
        let phases: Vec<_> =
            (1..=self.nodes).map(|number| self.net.mn(|mn, _| mn.phase(NodeId(number)))).collect();
        assert!(is_complete, "{:?}, {phases:?}", self.net.states());
        self.net.run(100);
        self.judge();
        assert!(
            self.net.states().iter().all(|state| *state == NmtState::Operational),
            "{:?}, {phases:?}",
            self.net.states()
        );
    }
}

const COMMANDS: [NmtCommandId; 8] = [
    NmtCommandId::START_NODE,
    NmtCommandId::STOP_NODE,
    NmtCommandId::ENTER_PRE_OPERATIONAL_2,
    NmtCommandId::ENABLE_READY_TO_OPERATE,
    NmtCommandId::RESET_NODE,
    NmtCommandId::RESET_COMMUNICATION,
    NmtCommandId::RESET_CONFIGURATION,
    NmtCommandId::SW_RESET,
];
const MOST_OPERATIONS: usize = 64;
const LONGEST_RUN: Duration = Duration::from_secs(8);
