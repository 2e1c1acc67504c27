//! The families of messages through a whole monitor, and the monitor's storage.

mod access;
mod connections;
mod created;
mod explicit;
mod io;
mod offline;
mod services;
mod storage;
mod watchdogs;

use std::boxed::Box;
use std::string::{String, ToString};
use std::vec::Vec;

use super::*;
use crate::id::{Identifier, MacId};

/// A bus that a monitor listens to.
struct Bus {
    monitor: Box<Monitor>,
    now: u64,
    n: u64,
}

/// What is kept of a reading.
#[derive(Debug, Clone, PartialEq)]
struct Heard {
    n: u64,
    kind: Kind,
    text: String,
    src: Option<u8>,
    dst: Option<u8>,
    dynamic: Option<DynamicConnection>,
    problem: Option<Problem>,
    note: Option<Note>,
    request: Option<Answered>,
    message: Option<Vec<u8>>,
    assumed: bool,
}

impl Bus {
    fn new() -> Self {
        Self { monitor: Box::new(Monitor::new(MonitorConfig::default())), now: 0, n: 0 }
    }

    /// A slave with its explicit connection, and the choice beyond it, allocated by master 1.
    fn with_slave(slave: u8, choice: u8) -> Self {
        let mut bus = Self::new();
        bus.group2(slave, 6, &[0x01, 0x4B, 3, 1, choice | 1, 1]);
        bus.group2(slave, 3, &[0x01, 0xCB, 0]);
        bus
    }

    /// Sets the expected packet rate of a connection of a slave of master 1.
    fn establish(&mut self, slave: u8, instance: u8, epr: u16) {
        let [low, high] = epr.to_le_bytes();
        self.group2(slave, 4, &[0x01, 0x10, 5, instance, 9, low, high]);
        let heard = self.group2(slave, 3, &[0x01, 0x90, low, high]);
        assert_eq!(heard.problem, None);
    }

    fn wait(&mut self, millis: u64) -> &mut Self {
        self.now += millis;
        self
    }

    /// A frame a millisecond after the last.
    #[track_caller]
    fn frame(&mut self, id: u16, data: &[u8]) -> Heard {
        self.now += 1;
        self.n += 1;
        let frame = Identifier::new(id).unwrap().frame(data).unwrap();
        let reading = self.monitor.observe(Instant::from_millis(self.now), self.n, &frame);
        Heard {
            n: reading.n,
            kind: reading.kind,
            text: reading.to_string(),
            src: reading.src.map(u8::from),
            dst: reading.dst.map(u8::from),
            dynamic: reading.dynamic,
            problem: reading.problem,
            note: reading.note,
            request: reading.request,
            message: reading.message.map(|message| message.data.to_vec()),
            assumed: reading.assumed,
        }
    }

    #[track_caller]
    fn group1(&mut self, message: u8, source: u8, data: &[u8]) -> Heard {
        self.frame(Identifier::group1(message, mac(source)).unwrap().raw(), data)
    }

    #[track_caller]
    fn group2(&mut self, node: u8, message: u8, data: &[u8]) -> Heard {
        self.frame(Identifier::group2(mac(node), message).unwrap().raw(), data)
    }

    #[track_caller]
    fn group3(&mut self, message: u8, source: u8, data: &[u8]) -> Heard {
        self.frame(Identifier::group3(message, mac(source)).unwrap().raw(), data)
    }

    fn node(&self, number: u8) -> NodeRecord {
        self.monitor.nodes().find(|node| node.mac == mac(number)).unwrap()
    }

    fn state(&self, slave: u8, which: Predefined) -> ConnectionState {
        self.connection(slave, which).state
    }

    fn connection(&self, slave: u8, which: Predefined) -> ConnectionRecord {
        let name = ConnectionName::Predefined(which);
        self.monitor.connections().find(|held| held.server == mac(slave) && held.name == name).unwrap()
    }
}

impl Heard {
    /// The number of the frame that it answers.
    fn answers(&self) -> Option<u64> {
        self.request.map(|request| request.n)
    }
}

fn mac(number: u8) -> MacId {
    MacId::new(number).unwrap()
}
