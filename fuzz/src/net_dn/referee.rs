//! Who may be on line, who owns what, and that data come from the owner only: seen from the bus, where nobody can lie about
//! who sends. It shares nothing with the machines.
//!
//! | Rule | |
//! |---|---|
//! | on line | two check requests, a second after each, and nobody with the same MAC ID was heard |
//! | off the bus | nobody sends; who was on line comes back 100 ms later at the earliest if it is to, and checks again |
//! | faulted | nobody sends but answers on 0x7EC, each to a question on 0x7ED; Change_MAC_ID for it is the only way out |
//! | offline set | a tool speaks on 0x7ED and 0x7EE after two requests on 0x7EF that nobody answered |
//! | UCMM | an answer to each request at the most, and messages to who has a connection |
//! | identifiers | everybody sends under its own MAC ID; commands are those of masters |
//! | owner | it has asked, there is one, and only its data are obeyed |

mod observed;

use core::time::Duration;

use link_core::{Frame, Instant};

use super::node::Role;
use observed::Observed;

pub(super) struct Referee {
    nodes: Vec<Observed>,
    /// After bus-off on line a node comes back.
    bus_off_interrupt: bool,
}

impl Referee {
    /// The nodes in the order of their serial numbers, which begin with 1.
    pub(super) fn new(known: impl Iterator<Item = (u8, Role)>, bus_off_interrupt: bool) -> Self {
        let nodes = (1..).zip(known).map(|(serial, (mac, role))| Observed::new(serial, mac, role)).collect();
        Self { nodes, bus_off_interrupt }
    }

    pub(super) fn power_cycle(&mut self, at: usize) {
        self.nodes[at].start();
    }

    /// A controller has left the bus.
    pub(super) fn bus_off(&mut self, at: usize, now: Instant) {
        let comes_back = self.bus_off_interrupt && self.is_online(at, now);
        let node = &mut self.nodes[at];
        node.off = Some(now);
        node.faulted |= !comes_back;
    }

    /// A node resets its controller.
    pub(super) fn restarts(&self, at: usize, now: Instant) {
        let node = &self.nodes[at];
        let off = node.off.expect("its controller is off the bus");
        assert!(!node.faulted, "node {} is to stay away", node.mac);
        assert!(now.saturating_since(off) >= BACK_OFF, "node {} comes back too soon", node.mac);
    }

    /// Its controller takes part again.
    pub(super) fn returned(&mut self, at: usize) {
        self.nodes[at].start();
    }

    /// A tool has given up the offline connection set.
    pub(super) fn released(&mut self, at: usize) {
        self.nodes[at].claims = 0;
    }

    /// Two check requests, a second after each, and nobody objected.
    pub(super) fn is_online(&self, at: usize, now: Instant) -> bool {
        let node = &self.nodes[at];
        node.off.is_none() && node.checks >= 2 && !node.faulted && !node.is_waiting(now)
    }

    /// Its MAC ID, which a tool may have changed.
    pub(super) fn mac(&self, at: usize) -> u8 {
        self.nodes[at].mac
    }

    pub(super) fn owner(&self, at: usize) -> Option<u8> {
        self.nodes[at].owner
    }

    /// Whether that master owned a slave before, and has not heard that it is another's now; or owned its twin.
    fn has_missed(&self, master: u8, at: usize, owner: u8) -> bool {
        let slave = &self.nodes[at];
        let knows = |node: &Observed| node.mac == master && node.allocated.contains(&(slave.mac, owner));
        // Twins that missed each other's checks are both on line.
        let is_twin = |(place, node): (usize, &Observed)| {
            place != at && node.mac == slave.mac && node.is_or_was_of(master)
        };
        slave.is_or_was_of(master) && !self.nodes.iter().any(knows)
            || self.nodes.iter().enumerate().any(is_twin)
    }

    /// A node sends a frame to its end.
    pub(super) fn sent(&mut self, at: usize, now: Instant, frame: &Frame) {
        let online = self.is_online(at, now);
        let node = &mut self.nodes[at];
        let (id, mac, data) = (frame.raw_id(), u32::from(node.mac), frame.data());
        assert!(node.off.is_none(), "{frame}: its controller is off the bus");
        if id == 0x407 | mac << 3 && data[0] & 0x80 == 0 {
            assert!(!node.faulted, "{frame}: a node in a fault checks");
            (node.checks, node.last_check) = (node.checks + 1, now);
            assert!(node.checks <= 2, "{frame}: a third request");
            return;
        }
        if id == 0x7EC {
            assert!(node.faulted, "{frame}: no fault");
            assert!(node.questions > 0, "{frame}: nobody has asked");
            node.questions -= 1;
            return;
        }
        assert!(online, "{frame}: node {} is not on line", node.mac);
        node.speaks(now, frame);
    }

    /// A node hears a frame; the sender is a stranger if it is none of these.
    pub(super) fn heard(&mut self, at: usize, now: Instant, sender: Option<usize>, frame: &Frame) {
        let sender = sender.map(|sender| self.nodes[sender].mac);
        let is_online = self.is_online(at, now);
        self.nodes[at].hears(now, sender, is_online, frame);
    }

    /// A slave tells who owns it.
    pub(super) fn owned(&mut self, at: usize, owner: Option<u8>) {
        let node = &mut self.nodes[at];
        if let (Some(before), Some(after)) = (node.owner, owner) {
            assert_eq!(before, after, "slave {} changes hands", node.mac);
        }
        if let Some(owner) = owner {
            assert!(node.asked.contains(&owner), "slave {}: {owner} never asked", node.mac);
        } else {
            node.asked.clear();
        }
        node.former.extend(node.owner.filter(|_| owner.is_none()));
        node.owner = owner;
    }

    /// A slave has consumed a command. Its identifier does not tell who sent it: a master that did not hear that it lost the
    /// slave is obeyed as well, and the master of a twin that missed the checks; a stranger is not.
    pub(super) fn consumed(&mut self, at: usize) {
        let node = &self.nodes[at];
        let (sender, data) = node.command.clone().expect("it heard one");
        let missed = |(sender, owner)| self.has_missed(sender, at, owner);
        let is_deaf = sender.zip(node.owner).is_some_and(missed);
        assert!(
            sender == node.owner || is_deaf,
            "slave {} obeys another than its owner: {sender:?}",
            node.mac
        );
        self.nodes[at].output = data[0];
    }

    /// The output of a slave: that of the last command, or at rest.
    pub(super) fn outputs(&self, at: usize, output: u8) {
        let node = &self.nodes[at];
        assert!(output == node.output || output == 0, "slave {}: {output:02X} was never sent", node.mac);
        assert!(node.owner.is_some() || output == 0, "slave {}: an output of nobody", node.mac);
    }

    /// What a master has of a slave is what it heard last, if it has anything.
    pub(super) fn inputs(&self, at: usize, slave: u8, data: Option<&[u8]>) {
        let heard =
            self.nodes[at].heard.iter().find(|(other, _)| *other == slave).map(|(_, data)| data.as_slice());
        assert!(data.is_none() || data == heard, "{data:02X?} of slave {slave} is not {heard:02X?}");
    }
}

const SECOND: Duration = Duration::from_secs(1);
/// Between bus-off and the restart of a controller.
const BACK_OFF: Duration = Duration::from_millis(100);
