//! What was seen of a node since it has power.

use link_core::{Frame, Instant};

use super::SECOND;
use crate::net_dn::node::{Role, VENDOR};

#[derive(Clone, Debug)]
pub(super) struct Observed {
    pub(super) serial: u32,
    pub(super) mac: u8,
    pub(super) role: Role,
    /// Since when its controller is off the bus.
    pub(super) off: Option<Instant>,
    /// Check requests that it sent, and when the last of them was.
    pub(super) checks: u8,
    pub(super) last_check: Instant,
    /// It heard another node with its MAC ID, or went off the bus for good.
    pub(super) faulted: bool,
    /// Questions to faulted nodes that it heard and has not answered.
    pub(super) questions: u32,
    /// Of a tool: requests for the offline connection set that were not answered, when the last was, and whether another
    /// tool asked.
    pub(super) claims: u32,
    last_claim: Instant,
    contested: bool,
    /// Whose requests to its UCMM it has not answered, who has a connection by that and under which Message ID of this node,
    /// and which servers gave it one.
    clients: Vec<u8>,
    opened: Vec<(u8, u8)>,
    servers: Vec<u8>,
    /// Of a slave: what it told, who owned it before, who asked it for an allocation, and the last poll command that it
    /// heard.
    pub(super) owner: Option<u8>,
    pub(super) former: Vec<u8>,
    pub(super) asked: Vec<u8>,
    pub(super) command: Option<(Option<u8>, Vec<u8>)>,
    pub(super) output: u8,
    /// Of a master: the last poll response of each MAC ID that it heard, and whose Allocate each answered last with success.
    pub(super) heard: Vec<(u8, Vec<u8>)>,
    pub(super) allocated: Vec<(u8, u8)>,
}

impl Observed {
    pub(super) fn new(serial: u32, mac: u8, role: Role) -> Self {
        Self {
            serial,
            mac,
            role,
            off: None,
            checks: 0,
            last_check: Instant::ZERO,
            faulted: false,
            questions: 0,
            claims: 0,
            last_claim: Instant::ZERO,
            contested: false,
            clients: Vec::new(),
            opened: Vec::new(),
            servers: Vec::new(),
            owner: None,
            former: Vec::new(),
            asked: Vec::new(),
            command: None,
            output: 0,
            heard: Vec::new(),
            allocated: Vec::new(),
        }
    }

    /// Power comes back, or the controller: it begins anew. What it had it gives up itself, and tells so.
    pub(super) fn start(&mut self) {
        let (owner, output) = (self.owner, self.output);
        let mut former = core::mem::take(&mut self.former);
        former.extend(owner);
        *self = Self { owner, former, output, ..Self::new(self.serial, self.mac, self.role) };
    }

    /// Whether that master owns it, or has owned it.
    pub(super) fn is_or_was_of(&self, master: u8) -> bool {
        self.owner == Some(master) || self.former.contains(&master)
    }

    /// The second after its last check runs.
    pub(super) fn is_waiting(&self, now: Instant) -> bool {
        now.saturating_since(self.last_check) < SECOND
    }

    /// On line it sends what is its own to send.
    pub(super) fn speaks(&mut self, now: Instant, frame: &Frame) {
        let (id, mac, data) = (frame.raw_id(), u32::from(self.mac), frame.data());
        let header = data.first().map_or(0, |byte| byte & 0x3F);
        let is_own = match id {
            // The response to a poll.
            0..0x400 => self.role == Role::Slave && id == 0x3C0 | mac && self.owner.is_some(),
            // Explicit responses and the defence of the MAC ID; commands and requests of a master.
            0x400..0x600 => match id & 7 {
                3 => id >> 3 & 0x3F == mac && self.role == Role::Slave,
                7 => id >> 3 & 0x3F == mac,
                4 | 6 => self.role == Role::Master && header == self.mac,
                5 => self.role == Role::Master,
                _ => false,
            },
            0x600..0x740 => id & 0x3F == mac && self.has_connection(header, (id >> 6 & 7) as u8),
            0x740..0x780 => id & 0x3F == mac && self.clients.contains(&header),
            0x780..0x7C0 => id & 0x3F == mac && self.role == Role::Master,
            0x7ED => self.role == Role::Tool && self.owns_offline_set(now),
            0x7EE => self.role == Role::Tool && self.claims > 0 && self.contested,
            0x7EF => self.role == Role::Tool,
            _ => false,
        };
        assert!(is_own, "{frame}: node {} may not say that", self.mac);
        match id {
            0x740..0x780 => {
                let place = self.clients.iter().position(|&client| client == header);
                self.clients.remove(place.expect("it has asked"));
                if let [_, 0xCB, _, ids, ..] = data {
                    self.opened.push((header, ids & 0x0F));
                }
            }
            0x7EF => (self.claims, self.last_claim) = (self.claims + 1, now),
            _ => {}
        }
    }

    /// With whom: as a server under this Message ID, or as a client under any. A client that does not wait for the answer to
    /// its Open may have one already, for the answer has the higher identifier.
    fn has_connection(&self, other: u8, message: u8) -> bool {
        self.opened.contains(&(other, message))
            || self.servers.contains(&other)
            || self.clients.contains(&other)
    }

    /// Two requests, a second after each, and nobody answered.
    fn owns_offline_set(&self, now: Instant) -> bool {
        self.claims >= 2 && now.saturating_since(self.last_claim) >= SECOND
    }

    pub(super) fn hears(&mut self, now: Instant, sender: Option<u8>, is_online: bool, frame: &Frame) {
        let (id, mac, data) = (frame.raw_id(), u32::from(self.mac), frame.data());
        let header = data.first().map(|byte| byte & 0x3F);
        match id {
            0x7ED => return self.hears_tool(data),
            0x7EE => self.claims = 0,
            0x7EF => self.contested = true,
            _ => {}
        }
        if id == 0x407 | mac << 3 {
            // A node that checks gives way to everybody, one on line to those that were there before.
            self.faulted |= data[0] & 0x80 != 0 || self.checks < 2 || self.is_waiting(now);
            if self.faulted {
                self.claims = 0;
            }
        }
        let for_it = id == 0x406 | mac << 3
            || id == 0x404 | mac << 3
            || (0x600..0x740).contains(&id) && header == Some(self.mac);
        if for_it && let Some([0x4B, 3, 1, _, allocator] | [0x4B, 3, 0, 1, 0, _, allocator]) = data.get(1..) {
            self.asked.push(*allocator);
        }
        if id & !0x3F == 0x780 && header == Some(self.mac) && is_online {
            self.clients.push((id & 0x3F) as u8);
        }
        if let (0x740, true, [_, 0xCB, ..]) = (id & !0x3F, header == Some(self.mac), data) {
            self.servers.push((id & 0x3F) as u8);
        }
        if id == 0x405 | mac << 3 {
            self.command = Some((sender, data.to_vec()));
        }
        if let (0x403, [header, 0xCB, _]) = (id & !0x1F8, data) {
            let slave = (id >> 3 & 0x3F) as u8;
            self.allocated.retain(|(other, _)| *other != slave);
            self.allocated.push((slave, header & 0x3F));
        }
        if id & !0x3F == 0x3C0 {
            let slave = (id & 0x3F) as u8;
            self.heard.retain(|(other, _)| *other != slave);
            self.heard.push((slave, data.to_vec()));
        }
    }

    /// In a fault it is asked who it is, or is given a MAC ID, with which it begins anew.
    fn hears_tool(&mut self, data: &[u8]) {
        if !self.faulted {
            return;
        }
        let known = [&VENDOR.to_le_bytes()[..], &self.serial.to_le_bytes()].concat();
        match data {
            [_, 0x4B | 0x4C, ..] => self.questions += 1,
            [mac @ 0..64, 0x4D, device @ ..] if device == known => {
                self.mac = *mac;
                self.start();
            }
            _ => {}
        }
    }
}
