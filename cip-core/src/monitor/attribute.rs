//! What reading and setting the attributes of a Connection object tells of the connection.

use link_core::Instant;

use super::{Connection, ConnectionState};
use crate::code::InstanceId;
use crate::epath::Epath;

impl Connection {
    /// An attribute was read.
    pub fn was_read(&mut self, attribute: u16, data: &[u8], at: Instant) {
        match (attribute, data) {
            (STATE, &[value]) => {
                if let Some(state) = ConnectionState::from_attribute(value)
                    && (state != self.state || self.assumed)
                {
                    let active = self.active;
                    self.enter(state, at);
                    if state == ConnectionState::Established && active != Instant::ZERO {
                        self.touch(at);
                    }
                }
            }
            (PRODUCED_SIZE, &[low, high]) => self.produced.size = Some(u16::from_le_bytes([low, high])),
            (CONSUMED_SIZE, &[low, high]) => self.consumed.size = Some(u16::from_le_bytes([low, high])),
            (EXPECTED_PACKET_RATE, &[low, high]) => self.epr = Some(u16::from_le_bytes([low, high])),
            (WATCHDOG_ACTION, &[action]) => self.watchdog_action = Some(action),
            (PRODUCED_PATH, path) => self.produced.path = instance_of(path),
            (CONSUMED_PATH, path) => self.consumed.path = instance_of(path),
            (INHIBIT_TIME, &[low, high]) => self.inhibit = Some(u16::from_le_bytes([low, high])),
            (TIMEOUT_MULTIPLIER, &[multiplier]) => self.multiplier = multiplier,
            _ => {}
        }
    }

    /// An attribute was set: `argument` is what the request has set it to, as [`Asked`](super::Asked) keeps it, `data` what
    /// the response says. `applies`: the expected packet rate establishes a predefined connection; others wait for
    /// Apply_Attributes.
    pub fn was_set(&mut self, attribute: u16, argument: u32, data: &[u8], at: Instant, applies: bool) {
        let [low, high, ..] = argument.to_le_bytes();
        let argument = u16::from_le_bytes([low, high]);
        let path = Some(InstanceId(argument)).filter(|instance| !instance.is_class());
        match attribute {
            EXPECTED_PACKET_RATE => {
                // A response without data means that the value sent is used.
                let used = match *data {
                    [low, high] => u16::from_le_bytes([low, high]),
                    _ => argument,
                };
                self.epr = Some(used);
                match self.state {
                    // A new rate does not bring a connection back that has timed out.
                    ConnectionState::TimedOut if !self.assumed => {}
                    // The ten seconds are for the first time only.
                    ConnectionState::Established => self.touch(at),
                    _ if applies => self.enter(ConnectionState::Established, at),
                    _ => {}
                }
            }
            PRODUCED_SIZE => self.produced.size = Some(argument),
            CONSUMED_SIZE => self.consumed.size = Some(argument),
            WATCHDOG_ACTION => self.watchdog_action = Some(low),
            INHIBIT_TIME => self.inhibit = Some(argument),
            TIMEOUT_MULTIPLIER => self.multiplier = low,
            // Another assembly: the sizes follow it and are to be learned again.
            PRODUCED_PATH => {
                self.produced.size = None;
                self.produced.path = path;
            }
            CONSUMED_PATH => {
                self.consumed.size = None;
                self.consumed.path = path;
            }
            _ => {}
        }
    }
}

/// The instance that a connection path names.
#[must_use]
pub fn instance_of(path: &[u8]) -> Option<InstanceId> {
    Epath::packed(path).logical().ok()?.instance
}

const STATE: u16 = 1;
/// The identifier that the server produces on.
pub const PRODUCED_ID: u16 = 4;
/// The identifier that it consumes.
pub const CONSUMED_ID: u16 = 5;
const PRODUCED_SIZE: u16 = 7;
const CONSUMED_SIZE: u16 = 8;
/// In milliseconds.
pub const EXPECTED_PACKET_RATE: u16 = 9;
const WATCHDOG_ACTION: u16 = 12;
/// Where the data come from.
pub const PRODUCED_PATH: u16 = 14;
/// Where they go.
pub const CONSUMED_PATH: u16 = 16;
const INHIBIT_TIME: u16 = 17;
const TIMEOUT_MULTIPLIER: u16 = 18;
