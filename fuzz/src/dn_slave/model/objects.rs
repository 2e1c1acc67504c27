//! What the objects answer, as far as it concerns connections.

use super::Model;
use super::allocation::{Door, Refusal};
use super::connections::{CHANGE, Connection, State, Which};
use super::pipe::Reply;

type Result<T> = core::result::Result<T, Refusal>;

impl Model {
    /// A complete request, from the service byte on, in the body format of its connection.
    pub(super) fn serve(&mut self, door: Door, requester: u8, format: u8, body: &[u8]) -> Reply {
        if body.first().is_none_or(|service| service & 0x80 != 0) {
            return Reply::Ignored;
        }
        let Some((service, class, instance, data)) = split(format, body) else {
            let answers = self.options.contains(devicenet_core::slave::Options::ANSWER_SHORT_BODY);
            return if answers { Reply::Exact(vec![0x94, 0x13, 0xFF]) } else { Reply::Ignored };
        };
        let done = match (class, service) {
            (3, _) if instance > 1 => Err((0x16, 0xFF)),
            (3, 0x4B) if instance == 1 => self.allocate(door, requester, data),
            (3, 0x4C) if instance == 1 => self.release(requester, data),
            (3, 0x0E) if instance == 1 && data == [5] => Ok(vec![self.choice(), self.master.unwrap_or(255)]),
            (3, 0x0E) if data.first() != Some(&12) => return Reply::Short(service),
            (3, 0x10) if instance == 1 && data.first() == Some(&1) => self.set_mac(door, data),
            (3, 0x10) if instance == 1 => return Reply::Short(service),
            (3, 0x0E) => return Reply::Unknown,
            (3, _) => Err((0x08, 0xFF)),
            (5, _) if instance == 0 => return Reply::Unknown,
            (5, _) => self.connection_object(service, instance, data),
            (0x2B, 0x10) if instance == 1 => match *data {
                [1, low, high] if low | high != 0 => {
                    self.acknowledge_time = u16::from_le_bytes([low, high]);
                    return Reply::Short(service);
                }
                [2, limit] => {
                    self.retry_limit = limit;
                    return Reply::Short(service);
                }
                _ => return Reply::Short(service),
            },
            (0x2B, _) => return Reply::Short(service),
            (1, 0x0E) if instance == 1 && data == [7] => {
                let name = crate::dn_slave::device::NAME.as_bytes();
                Ok([&[name.len() as u8][..], name].concat())
            }
            (1, 0x05) if instance == 1 => match *data {
                [] | [0] => {
                    self.leave(door);
                    Ok(Vec::new())
                }
                _ => return Reply::Short(service),
            },
            (1, 0x01 | 0x11) => return Reply::Unknown,
            (1, _) => return Reply::Short(service),
            _ => Err((0x16, 0xFF)),
        };
        match done {
            Err(SHORT) => Reply::Short(service),
            Err((general, additional)) => Reply::Exact(vec![0x94, general, additional]),
            Ok(data) => Reply::Exact([&[0x80 | service][..], &data].concat()),
        }
    }

    fn set_mac(&mut self, door: Door, data: &[u8]) -> Result<Vec<u8>> {
        match *data {
            [_, mac] if mac < 64 => self.leave(door),
            [_, _] => return Err((0x09, 0xFF)),
            [_] => return Err((0x13, 0xFF)),
            _ => return Err((0x15, 0xFF)),
        }
        Ok(Vec::new())
    }

    fn leave(&mut self, door: Door) {
        self.leaving = Some(match door {
            Door::Dynamic(at) => at + 1,
            Door::Predefined | Door::Unconnected => 0,
        });
    }

    pub(super) fn which(&self, instance: u16) -> Option<Which> {
        match usize::from(instance) {
            1 => self.explicit.exists().then_some(Which::Explicit),
            at @ 2..=5 => self.io[at - 2].exists().then_some(Which::Io(at - 2)),
            at => {
                let at = at.checked_sub(6)?;
                self.dynamic.get(at)?.connection.exists().then_some(Which::Dynamic(at))
            }
        }
    }

    fn connection_object(&mut self, service: u8, instance: u16, data: &[u8]) -> Result<Vec<u8>> {
        let which = self.which(instance).ok_or((0x16, 0xFF))?;
        let none = |data: &[u8]| if data.is_empty() { Ok(()) } else { Err((0x15, 0xFF)) };
        match service {
            0x0E => return self.get(which, data),
            0x10 => {
                let (&attribute, value) = data.split_first().ok_or((0x13, 0xFF))?;
                return self.set(which, attribute, value);
            }
            0x05 => none(data).and_then(|()| self.reset_connection(which))?,
            0x09 => {
                none(data)?;
                match which {
                    Which::Io(at) => self.remove_io(at),
                    _ => self.connection(which).end(),
                }
            }
            0x0D => {
                let Which::Io(at) = which else { return Err((0x08, 0xFF)) };
                none(data)?;
                if self.io[at].state != State::Configuring {
                    return Err((0x0C, 0xFF));
                }
                self.establish(at, true);
            }
            0x11 => return Err(SHORT),
            _ => return Err((0x08, 0xFF)),
        }
        Ok(Vec::new())
    }

    fn get(&mut self, which: Which, data: &[u8]) -> Result<Vec<u8>> {
        let connection = self.connection(which);
        match *data {
            [1] => Ok(vec![connection.state as u8]),
            [9] => Ok(connection.rate.to_le_bytes().to_vec()),
            [12] => Ok(vec![connection.action]),
            [17] => Ok(connection.inhibit.to_le_bytes().to_vec()),
            [18] => Ok(vec![connection.multiplier]),
            _ => Err(SHORT),
        }
    }

    fn reset_connection(&mut self, which: Which) -> Result<()> {
        let (now, owned) = (self.now, self.master.is_some());
        let consumes = !matches!(which, Which::Io(at) if !self.consumes(at));
        let connection = self.connection(which);
        match (which, connection.state) {
            (_, State::Configuring | State::Deferred) => return Err((0x0C, 0xFF)),
            // The data would flow for nobody.
            (Which::Io(_), State::TimedOut) if !owned => return Err((0x0C, 0xFF)),
            (Which::Io(at), State::TimedOut) => self.establish(at, false),
            _ if !consumes => connection.watchdog = None,
            _ => connection.restart(now, 0),
        }
        Ok(())
    }

    fn set(&mut self, which: Which, attribute: u8, value: &[u8]) -> Result<Vec<u8>> {
        let is_io = matches!(which, Which::Io(_));
        let configures_group =
            which == Which::Io(super::connections::MULTICAST) && self.io[3].state == State::Configuring;
        let size = match attribute {
            9 => 2,
            5 if configures_group => 2,
            12 | 18 => 1,
            17 if is_io => 2,
            1..=8 | 13..=17 => return Err((0x0E, 0xFF)),
            _ => return Err((0x14, 0xFF)),
        };
        if value.len() != size {
            return Err((if value.len() < size { 0x13 } else { 0x15 }, 0xFF));
        }
        let number = u16::from_le_bytes([value[0], value.get(1).copied().unwrap_or(0)]);
        let invalid = Err((0x09, 0xFF));
        let resolution = self.resolution;
        let connection = self.connection(which);
        match attribute {
            5 => {
                if number & !0x1F8 != 0x401 {
                    return invalid;
                }
                self.group = (number >> 3 & 0x3F) as u8;
            }
            9 => {
                let used = number.div_ceil(resolution).checked_mul(resolution);
                let Some(used) = used.filter(|&used| used == 0 || connection.inhibit <= used) else {
                    return invalid;
                };
                connection.rate = used;
                self.rate_set(which);
                return Ok(used.to_le_bytes().to_vec());
            }
            12 if is_io && value[0] > 2 || !is_io && ![1, 3].contains(&value[0]) => return invalid,
            12 => connection.action = value[0],
            17 if connection.rate != 0 && number > connection.rate => return invalid,
            17 => {
                connection.inhibit = number;
                if self.options.contains(devicenet_core::slave::Options::ANSWER_INHIBIT_TIME) {
                    return Ok(value.to_vec());
                }
            }
            18 if value[0] > 7 => return invalid,
            _ => connection.multiplier = value[0],
        }
        Ok(Vec::new())
    }

    fn rate_set(&mut self, which: Which) {
        let now = self.now;
        let consumes = match which {
            Which::Io(at) => self.consumes(at),
            _ => true,
        };
        let connection: &mut Connection = self.connection(which);
        match (which, connection.state) {
            (Which::Io(at), State::Configuring) => self.establish(at, true),
            (_, State::Established) if consumes => connection.restart(now, 0),
            _ => {}
        }
        if which == Which::Io(CHANGE) && self.io[CHANGE].state == State::Established {
            self.start_trigger();
        }
    }
}

/// A request in one of the body formats 0 to 3: service, class, instance, data.
fn split(format: u8, body: &[u8]) -> Option<(u8, u16, u16, &[u8])> {
    let number = |bytes: &[u8]| u16::from_le_bytes([bytes[0], bytes.get(1).copied().unwrap_or(0)]);
    let (class, instance) = match format {
        0 => (1, 1),
        1 => (1, 2),
        2 => (2, 2),
        _ => (2, 1),
    };
    let (&service, rest) = body.split_first()?;
    let (class, rest) = rest.split_at_checked(class)?;
    let (instance, data) = rest.split_at_checked(instance)?;
    Some((service, number(class), number(instance), data))
}

/// Not a refusal: an answer that is not foretold.
const SHORT: Refusal = (0, 0);
