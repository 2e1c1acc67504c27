//! Who may be on line, who owns what, and that data come from the owner only: seen from the bus, where nobody can lie about
//! who sends. It shares nothing with the machines.

use core::time::Duration;

use link_core::{Frame, Instant};

pub(super) struct Referee {
    nodes: Vec<Observed>,
}

/// What was seen of a node since it has power.
#[derive(Clone, Debug)]
struct Observed {
    mac: u8,
    /// Check requests that it sent, and when the last of them was.
    checks: u8,
    last_check: Instant,
    /// It heard another node with its MAC ID.
    faulted: bool,
    /// Of a slave: what it told, who owned it before, who asked it for an allocation, and the last poll command that it
    /// heard.
    owner: Option<u8>,
    former: Vec<u8>,
    asked: Vec<u8>,
    command: Option<(Option<u8>, Vec<u8>)>,
    output: u8,
    /// Of a master: the last poll response of each MAC ID that it heard, and whose Allocate each answered last with success.
    heard: Vec<(u8, Vec<u8>)>,
    allocated: Vec<(u8, u8)>,
}

impl Referee {
    pub(super) fn new(macs: &[u8]) -> Self {
        Self { nodes: macs.iter().map(|&mac| Observed::new(mac)).collect() }
    }

    pub(super) fn power_cycle(&mut self, at: usize) {
        let (owner, output) = (self.nodes[at].owner, self.nodes[at].output);
        let mut former = core::mem::take(&mut self.nodes[at].former);
        former.extend(owner);
        // What it had it gives up itself, and tells so.
        self.nodes[at] = Observed { owner, former, output, ..Observed::new(self.nodes[at].mac) };
    }

    /// Two check requests, a second after each, and nobody objected.
    pub(super) fn is_online(&self, at: usize, now: Instant) -> bool {
        let node = &self.nodes[at];
        node.checks >= 2 && !node.faulted && now.saturating_since(node.last_check) >= SECOND
    }

    pub(super) fn owner(&self, at: usize) -> Option<u8> {
        self.nodes[at].owner
    }

    /// Whether that master owned a slave before, and has not heard that it is another's now; or owned its twin.
    fn has_missed(&self, master: u8, at: usize, owner: u8) -> bool {
        let slave = &self.nodes[at];
        let owned = |slave: &Observed| slave.owner == Some(master) || slave.former.contains(&master);
        let knows = |node: &Observed| node.mac == master && node.allocated.contains(&(slave.mac, owner));
        // Twins that missed each other's checks are both on line.
        let is_twin = |(place, node): (usize, &Observed)| place != at && node.mac == slave.mac && owned(node);
        owned(slave) && !self.nodes.iter().any(knows) || self.nodes.iter().enumerate().any(is_twin)
    }

    /// A node sends a frame to its end.
    pub(super) fn sent(&mut self, at: usize, now: Instant, frame: &Frame) {
        let online = self.is_online(at, now);
        let node = &mut self.nodes[at];
        let (id, mac) = (frame.raw_id(), u32::from(node.mac));
        let is_check = id == 0x407 | mac << 3;
        if is_check && frame.data()[0] & 0x80 == 0 {
            assert!(!node.faulted, "{frame}: a node in a fault checks");
            (node.checks, node.last_check) = (node.checks + 1, now);
            assert!(node.checks <= 2, "{frame}: a third request");
            return;
        }
        if id == 0x7EC {
            assert!(node.faulted, "{frame}: no fault");
            return;
        }
        assert!(online, "{frame}: node {} is not on line", node.mac);
        if id == 0x3C0 | mac {
            assert!(node.owner.is_some(), "{frame}: data for nobody");
        }
    }

    /// A node hears a frame; the sender is a stranger if it is none of these.
    pub(super) fn heard(&mut self, at: usize, now: Instant, sender: Option<usize>, frame: &Frame) {
        let sender = sender.map(|sender| self.nodes[sender].mac);
        let node = &mut self.nodes[at];
        let (id, mac, data) = (frame.raw_id(), u32::from(node.mac), frame.data());
        if id == 0x407 | mac << 3 {
            // A node that checks gives way to everybody, one on line to those that were there before.
            node.faulted |= data[0] & 0x80 != 0 || node.checks < 2 || node.is_waiting(now);
        }
        let body = if id == 0x406 | mac << 3 || id == 0x404 | mac << 3 { data.get(1..) } else { None };
        if let Some([0x4B, 3, 1, _, allocator]) = body {
            node.asked.push(*allocator);
        }
        if id == 0x405 | mac << 3 {
            node.command = Some((sender, data.to_vec()));
        }
        if let (0x403, [header, 0xCB, _]) = (id & !0x1F8, data) {
            let slave = (id >> 3 & 0x3F) as u8;
            node.allocated.retain(|(other, _)| *other != slave);
            node.allocated.push((slave, header & 0x3F));
        }
        if id & !0x3F == 0x3C0 {
            let slave = (id & 0x3F) as u8;
            node.heard.retain(|(other, _)| *other != slave);
            node.heard.push((slave, data.to_vec()));
        }
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
    /// slave is obeyed as well, a stranger is not.
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

impl Observed {
    fn is_waiting(&self, now: Instant) -> bool {
        now.saturating_since(self.last_check) < SECOND
    }

    fn new(mac: u8) -> Self {
        Self {
            mac,
            checks: 0,
            last_check: Instant::ZERO,
            faulted: false,
            owner: None,
            former: Vec::new(),
            asked: Vec::new(),
            command: None,
            output: 0,
            heard: Vec::new(),
            allocated: Vec::new(),
        }
    }
}

const SECOND: Duration = Duration::from_secs(1);
