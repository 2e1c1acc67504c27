//! Where frames go, and where they come from.

use super::allocation::{Door, Refusal};
use super::connections::{Connection, MULTICAST, POLLED};
use super::pipe::{Incoming, Piece, Reply};
use super::{Dynamic, Group, Model};
use devicenet_core::slave::Options;

/// Who has a frame in flight.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::dn_slave) enum Sender {
    Io(usize),
    Explicit,
    Ucmm,
    Dynamic(usize),
}

/// A frame on the explicit line or that of the UCMM.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Sent {
    Piece(Piece),
    Answer,
    /// It was for a connection of another life.
    Stale,
}

impl Model {
    /// A frame on line. False if the model knows no answer to the request in it.
    pub(in crate::dn_slave) fn frame(&mut self, id: u16, field: &[u8]) -> bool {
        if let Some(at) = self.dynamic_of(id) {
            return self.dynamic_message(at, field);
        }
        let (mac, message) = ((id >> 3 & 0x3F) as u8, id & 7);
        let own = mac == self.mac;
        match (id & 0x600, message) {
            (0x400, 5) if own => self.command(POLLED, field),
            (0x400, 4) if own => return self.explicit_message(field),
            (0x400, 6) if own => self.unconnected(field),
            (0x400, 2) if own => self.change_acknowledged(),
            (0x400, 0) if self.master == Some(mac) => self.strobe(field),
            (0x400, 1) if self.group == mac => self.command(MULTICAST, field),
            _ if !self.dynamic.is_empty() && (0x780..0x7C0).contains(&id) => {
                return self.ucmm((id & 0x3F) as u8, field);
            }
            _ => {}
        }
        true
    }

    fn explicit_message(&mut self, field: &[u8]) -> bool {
        let Some(header) = field.first() else { return true };
        if !self.explicit.exists() || self.master != Some(header & 0x3F) || self.leaving.is_some() {
            return true;
        }
        let now = self.now;
        self.explicit.message_on_explicit(now);
        self.message(0, Door::Predefined, header & 0x3F, 0, field)
    }

    fn dynamic_message(&mut self, at: usize, field: &[u8]) -> bool {
        let (now, own) = (self.now, self.mac);
        let dynamic = &mut self.dynamic[at];
        let expected = if dynamic.group == Group::Two { dynamic.client } else { own };
        let Some(header) = field.first() else { return true };
        if header & 0x3F != expected || self.leaving.is_some() {
            return true;
        }
        dynamic.connection.message_on_explicit(now);
        let (client, format) = (dynamic.client, dynamic.format);
        self.message(at + 1, Door::Dynamic(at), client, format, field)
    }

    fn message(&mut self, pipe: usize, door: Door, peer: u8, format: u8, field: &[u8]) -> bool {
        let reacknowledge = self.options.contains(Options::REACKNOWLEDGE_LAST);
        let now = self.now;
        if let Incoming::Request(body) = self.pipes[pipe].receive(now, peer, reacknowledge, field) {
            let reply = self.serve(door, peer, format, &body);
            if reply == Reply::Unknown {
                return false;
            }
            self.pipes[pipe].reply(reply);
        }
        true
    }

    fn unconnected(&mut self, field: &[u8]) {
        let [header, service, rest @ ..] = field else { return };
        if header & 0x80 != 0 || service & 0x80 != 0 || !self.has_room() {
            return;
        }
        let requester = header & 0x3F;
        let done = match *rest {
            [_, _, ..] if *service != 0x4B && *service != 0x4C => Err((0x02, 0x03)),
            [3, 1, ref data @ ..] if *service == 0x4B => self.allocate(Door::Unconnected, requester, data),
            [3, 1, ref data @ ..] => self.release(requester, data),
            [_, _, ..] => Err((0x16, 0xFF)),
            _ if self.options.contains(Options::ANSWER_SHORT_BODY) => Err((0x13, 0xFF)),
            _ => return,
        };
        self.answer(false, header & 0x7F, *service, done);
    }

    fn ucmm(&mut self, client: u8, field: &[u8]) -> bool {
        let [header, service, data @ ..] = field else { return true };
        if header & 0x3F != self.mac || header & 0x80 != 0 || service & 0x80 != 0 || !self.has_room() {
            return true;
        }
        let done = match service {
            0x4B | 0x4C if data.len() != 2 => Err((if data.len() < 2 { 0x13 } else { 0x15 }, 0xFF)),
            0x4B if data[0] & 0x0F == 4 => return false,
            0x4B => self.open(client, data[0] & 0x0F, data[1] >> 4, data[1] & 0x0F),
            0x4C => self.close(client, u16::from_le_bytes([data[0], data[1]])),
            _ => Err((0x08, 0xFF)),
        };
        self.answer(true, header & 0x40 | client, *service, done);
        true
    }

    fn open(&mut self, client: u8, format: u8, group: u8, source: u8) -> Result<Vec<u8>, Refusal> {
        let format = if format < 4 { format } else { 0 };
        let group = match group {
            15 => return Ok(vec![format, 0, 0, 0]),
            0 => Group::One,
            1 => Group::Two,
            3 if source <= 4 => Group::Three,
            _ => return Err((0x20, 0xFF)),
        };
        let mut opened = Dynamic {
            connection: Connection::explicit(self.now),
            client,
            format,
            group,
            request: source,
            response: 0,
            in_flight: None,
            withdraw: false,
        };
        if group != Group::Two
            && let Some(forgotten) = self.dynamic_of(opened.consumed(self.mac))
        {
            self.dynamic[forgotten].connection.end();
            self.drop_pipe(forgotten);
            self.settle();
        }
        let at = self.dynamic.iter().position(|one| !one.connection.exists()).ok_or((0x02, 0xFF))?;
        let open = || self.dynamic.iter().filter(|one| one.connection.exists() && one.group == group);
        let (most, additional) = match group {
            Group::One => (12, 3),
            Group::Two => (6, 1),
            Group::Three => (5, 4),
        };
        let taken = if group == Group::Two { self.message_ids(self.held) } else { 0 };
        let mut free = (0..most).filter(|&id: &u8| {
            let used = open().any(|one| one.response == id || group == Group::Two && one.request == id);
            !used && (id > 7 || taken >> id & 1 == 0)
        });
        let none = (0x02, additional);
        if group == Group::Two {
            opened.request = free.next().ok_or(none)?;
        }
        opened.response = free.next().ok_or(none)?;
        drop(free);
        let destination = if group == Group::Two { opened.request } else { 0 };
        let answer = vec![format, destination << 4 | opened.response, at as u8 + 6, 0];
        (opened.in_flight, opened.withdraw) = (self.dynamic[at].in_flight, self.dynamic[at].withdraw);
        self.dynamic[at] = opened;
        self.drop_pipe(at);
        Ok(answer)
    }

    fn close(&mut self, client: u8, instance: u16) -> Result<Vec<u8>, Refusal> {
        if instance < 6 {
            return Err(if self.which(instance).is_some() { (0x0C, 0xFF) } else { (0x16, 0xFF) });
        }
        let dynamic = self.dynamic.get_mut(usize::from(instance - 6));
        let dynamic = dynamic.filter(|one| one.connection.exists()).ok_or((0x16, 0xFF))?;
        if dynamic.client != client {
            return Err((0x0C, 0xFF));
        }
        dynamic.connection.end();
        Ok(Vec::new())
    }

    fn drop_pipe(&mut self, at: usize) {
        self.pipes[at + 1].clear();
        if let Some(matters) = &mut self.dynamic[at].in_flight {
            *matters = None;
            self.dynamic[at].withdraw = true;
        }
    }

    fn has_room(&self) -> bool {
        self.answers.len() < 3 && self.leaving.is_none()
    }

    fn answer(&mut self, ucmm: bool, header: u8, service: u8, done: Result<Vec<u8>, Refusal>) {
        let body = match done {
            Ok(data) => [&[header, 0x80 | service][..], &data].concat(),
            Err((general, additional)) => vec![header, 0x94, general, additional],
        };
        self.answers.push((ucmm, body));
    }

    fn dynamic_of(&self, id: u16) -> Option<usize> {
        self.dynamic.iter().position(|one| one.connection.exists() && one.consumed(self.mac) == id)
    }

    pub(super) fn dynamic_message_ids(&self) -> u8 {
        let used = |one: &&Dynamic| one.connection.exists() && one.group == Group::Two;
        self.dynamic.iter().filter(used).fold(0, |ids, one| ids | 1 << one.request | 1 << one.response)
    }

    /// The network is gone: nothing of what was to be sent is left.
    pub(super) fn silence(&mut self, dropped: bool) {
        for line in &mut self.lines {
            line.stop(dropped);
            // A controller off the bus has dropped it by itself.
            line.withdraw &= !dropped;
        }
        self.pipes.iter_mut().for_each(super::pipe::Pipe::clear);
        self.answers.clear();
        for (sent, withdraw) in [
            (&mut self.explicit_in_flight, &mut self.explicit_withdraw),
            (&mut self.ucmm_in_flight, &mut self.ucmm_withdraw),
        ] {
            if let Some(sent) = sent {
                (*sent, *withdraw) = (Sent::Stale, !dropped);
            }
        }
        for dynamic in &mut self.dynamic {
            dynamic.withdraw = dynamic.in_flight.is_some() && !dropped;
            dynamic.in_flight = dynamic.in_flight.map(|_| None);
        }
    }

    /// Judges a frame that the slave sends on line.
    pub(in crate::dn_slave) fn transmit(&mut self, id: u16, field: &[u8]) -> Sender {
        let own = u16::from(self.mac);
        let due = |at: &usize| self.pipes[at + 1].is_due() && self.dynamic[*at].in_flight.is_none();
        let produces = |at: &usize| self.dynamic[*at].produced(self.mac) == id && due(at);
        if let Some(at) = (0..self.dynamic.len()).find(produces) {
            self.dynamic[at].in_flight = Some(Some(self.pipes[at + 1].hand_out(field)));
            return Sender::Dynamic(at);
        }
        if let Some(at) = LINES.iter().position(|&message| message << 6 | own == id) {
            let lower = (0..4).filter(|&other| LINES[other] < LINES[at] && self.lines[other].is_ready());
            assert_eq!(lower.count(), 0, "{id:03X} before a frame of higher priority");
            self.produce(at, field);
            return Sender::Io(at);
        }
        if id == 0x403 | own << 3 {
            assert!(self.explicit_in_flight.is_none(), "{field:02X?}: two frames on one line");
            self.explicit_in_flight = Some(if self.pipes[0].must_acknowledge() {
                Sent::Piece(self.pipes[0].hand_out(field))
            } else if let Some(at) = self.answers.iter().position(|(ucmm, _)| !ucmm) {
                assert_eq!(field, self.answers.remove(at).1, "an unconnected response");
                Sent::Answer
            } else {
                Sent::Piece(self.pipes[0].hand_out(field))
            });
            return Sender::Explicit;
        }
        assert_eq!(id, 0x740 | own, "{field:02X?}: nothing of this node");
        assert!(self.ucmm_in_flight.is_none(), "{field:02X?}: two frames on one line");
        let at = self.answers.iter().position(|(ucmm, _)| *ucmm).expect("a UCMM request was answered");
        assert_eq!(field, self.answers.remove(at).1, "a response of the UCMM");
        self.ucmm_in_flight = Some(Sent::Answer);
        Sender::Ucmm
    }

    /// The frame of this identifier is with the controller no longer.
    pub(in crate::dn_slave) fn done(&mut self, line: Sender, sent: bool) {
        let now = self.now;
        match line {
            Sender::Io(at) => self.produced(at, sent),
            Sender::Explicit => {
                self.explicit_withdraw = false;
                if let Some(Sent::Piece(piece)) = self.explicit_in_flight.take() {
                    self.pipes[0].handed(now, piece);
                }
            }
            Sender::Ucmm => {
                self.ucmm_withdraw = false;
                self.ucmm_in_flight = None;
            }
            Sender::Dynamic(at) => {
                self.dynamic[at].withdraw = false;
                if let Some(Some(piece)) = self.dynamic[at].in_flight.take() {
                    self.pipes[at + 1].handed(now, piece);
                }
            }
        }
    }

    /// A withdrawal is asked for; whether it was owed.
    pub(in crate::dn_slave) fn withdraw(&mut self, line: Sender) -> bool {
        core::mem::take(match line {
            Sender::Io(at) => &mut self.lines[at].withdraw,
            Sender::Explicit => &mut self.explicit_withdraw,
            Sender::Ucmm => &mut self.ucmm_withdraw,
            Sender::Dynamic(at) => &mut self.dynamic[at].withdraw,
        })
    }

    /// What is still to be sent, in words; empty when the slave has nothing more to do.
    pub(in crate::dn_slave) fn owes(&self) -> Vec<String> {
        let mut owed = Vec::new();
        let mut owe = |owes: bool, what: &str, at: usize| {
            if owes {
                owed.push(format!("{what} {at}"));
            }
        };
        for (at, line) in self.lines.iter().enumerate() {
            owe(line.is_ready() && self.online, "I/O message of instance", at + 2);
            owe(line.withdraw, "withdrawal of I/O message of instance", at + 2);
        }
        let explicit = self.pipes[0].is_due() || self.answers.iter().any(|(ucmm, _)| !ucmm);
        owe(explicit && self.explicit_in_flight.is_none(), "explicit frame", 1);
        owe(self.explicit_withdraw, "withdrawal of explicit frame", 1);
        let ucmm = self.answers.iter().any(|(ucmm, _)| *ucmm);
        owe(ucmm && self.ucmm_in_flight.is_none(), "response of the UCMM", 0);
        owe(self.ucmm_withdraw, "withdrawal of a response of the UCMM", 0);
        for (at, dynamic) in self.dynamic.iter().enumerate() {
            owe(self.pipes[at + 1].is_due() && dynamic.in_flight.is_none(), "explicit frame", at + 6);
            owe(dynamic.withdraw, "withdrawal of explicit frame", at + 6);
        }
        let left = self.leaving.is_some_and(|pipe| self.pipes[pipe].is_quiet());
        owe(left, "departure", 0);
        owed
    }
}

/// The Message IDs of the I/O lines, group 1.
const LINES: [u16; 4] = [0xF, 0xE, 0xD, 0xC];
