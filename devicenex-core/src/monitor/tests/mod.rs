//! The families of messages through a whole monitor, and the monitor's storage. The bytes are those of the paper's figures
//! 3 to 10, or where the paper is silent those of the tables in [`crate::id`] and [`crate::message`].

mod access;
mod connect;
mod explicit;
mod implicit;
mod storage;

use std::boxed::Box;
use std::string::{String, ToString};
use std::vec::Vec;

use link_core::frame::{extended_id, standard_id};

use super::*;
use crate::id::{Direction, Framing, MessageId, Route};
use crate::message::{DeviceIdentity, Hello, MiniWho, PortByte, Roam};

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
    problem: Option<Problem>,
    note: Option<Note>,
    request: Option<Answered>,
    message: Option<Vec<u8>>,
    stage: Option<Stage>,
    assumed: bool,
}

impl Bus {
    fn new() -> Self {
        Self { monitor: Box::new(Monitor::new(MonitorConfig::default())), now: 0, n: 0 }
    }

    fn wait(&mut self, millis: u64) -> &mut Self {
        self.now += millis;
        self
    }

    /// A frame a millisecond after the last.
    #[track_caller]
    fn frame(&mut self, frame: &Frame) -> Heard {
        self.now += 1;
        self.n += 1;
        let reading = self.monitor.observe(Instant::from_millis(self.now), self.n, frame);
        let stage = match reading.fields.detail {
            Detail::Hello(stage) => Some(stage),
            _ => None,
        };
        Heard {
            n: reading.n,
            kind: reading.kind,
            text: reading.to_string(),
            src: reading.src.map(u8::from),
            dst: reading.dst.map(u8::from),
            problem: reading.problem,
            note: reading.note,
            request: reading.request,
            message: reading.message.map(|message| message.data.to_vec()),
            stage,
            assumed: reading.assumed,
        }
    }

    #[track_caller]
    fn extended(&mut self, id: u32, data: &[u8]) -> Heard {
        self.frame(&Frame::new(extended_id(id), data).unwrap())
    }

    #[track_caller]
    fn standard(&mut self, id: u16, data: &[u8]) -> Heard {
        self.frame(&Frame::new(standard_id(id), data).unwrap())
    }

    #[track_caller]
    fn hello(&mut self, source: u8, device: DeviceIdentity) -> Heard {
        self.hello_of(source, Direction::Request, device)
    }

    #[track_caller]
    fn hello_of(&mut self, source: u8, direction: Direction, device: DeviceIdentity) -> Heard {
        self.frame(&Hello { source: oa(source), direction, device, port: PortByte::ZERO }.frame().unwrap())
    }

    #[track_caller]
    fn mini_who(&mut self, serial_low: u16) -> Heard {
        self.frame(&MiniWho { serial_low }.frame().unwrap())
    }

    #[track_caller]
    fn roam(&mut self, target: DeviceIdentity, requested: u8) -> Heard {
        self.frame(&Roam { target, requested: oa(requested) }.frame().unwrap())
    }

    /// Both Hellos of a node, and the wait after them.
    fn join(&mut self, source: u8, device: DeviceIdentity) -> &mut Self {
        assert_eq!(self.hello(source, device).stage, Some(Stage::First));
        self.wait(1000);
        assert_eq!(self.hello(source, device).stage, Some(Stage::Second));
        self.wait(1000)
    }

    /// A connection request of one node to another, and its response.
    #[track_caller]
    fn connect(&mut self, client: u8, server: u8, request: &[u8], response: &[u8]) -> (Heard, Heard) {
        let asked = self.frame(&connection(client, server, Direction::Request, 9, request));
        let answered = self.frame(&connection(client, server, Direction::Response, 9, response));
        (asked, answered)
    }

    /// Set_Attribute_Single of attribute 5 of a connection, on the explicit connection of Message ID 0.
    #[track_caller]
    fn consume(&mut self, server: u8, instance: u8, id: u32) {
        let [a, b, c, d] = id.to_le_bytes();
        self.explicit(1, server, Direction::Request, 7, &[0x10, 5, instance, 5, a, b, c, d]);
        let heard = self.explicit(1, server, Direction::Response, 7, &[0x90]);
        assert_eq!(heard.problem, None);
    }

    #[track_caller]
    fn explicit(
        &mut self,
        client: u8,
        server: u8,
        direction: Direction,
        transaction: u8,
        data: &[u8],
    ) -> Heard {
        let framing = Framing::Complete { transaction };
        let id =
            Identifier::explicit(MessageId::default(), route(client, server, direction), framing).unwrap();
        self.frame(&id.frame(data).unwrap())
    }

    #[track_caller]
    fn connectionless(
        &mut self,
        client: u8,
        server: u8,
        direction: Direction,
        framing: Framing,
        data: &[u8],
    ) -> Heard {
        let id = Identifier::connectionless(route(client, server, direction), framing);
        self.frame(&id.frame(data).unwrap())
    }

    fn node(&self, address: u8) -> NodeRecord {
        self.monitor.node(oa(address)).unwrap()
    }

    fn held(&self, server: u8, instance: u16) -> ConnectionRecord {
        let name = ConnectionName::Instance(InstanceId(instance));
        self.monitor.connections().find(|held| held.server == oa(server) && held.name == name).unwrap()
    }
}

impl Heard {
    /// The number of the frame that it answers.
    fn answers(&self) -> Option<u64> {
        self.request.map(|request| request.n)
    }

    fn code(&self) -> Option<&'static str> {
        self.problem.map(|problem| problem.code())
    }
}

fn connection(client: u8, server: u8, direction: Direction, transaction: u8, data: &[u8]) -> Frame {
    Identifier::connection(route(client, server, direction), transaction).frame(data).unwrap()
}

fn route(client: u8, server: u8, direction: Direction) -> Route {
    let (source, destination) = match direction {
        Direction::Request => (client, server),
        Direction::Response => (server, client),
    };
    Route { destination: oa(destination), direction, source: oa(source) }
}

fn oa(number: u8) -> OperationalAddress {
    OperationalAddress::new(number).unwrap()
}

/// A fictitious device.
fn device(serial: u32) -> DeviceIdentity {
    DeviceIdentity { vendor: 0x0123.into(), product_code: 0x0456, major_revision: 2, serial }
}
