//! A network by hand: node 1 with MAC 02-..-01, the managing node with 02-..-F0, a frame every millisecond.

mod cycle;
mod frames;
mod laws;
mod nodes;
mod sdo;
mod slot;

use std::boxed::Box;
use std::string::{String, ToString};
use std::vec::Vec;

use super::*;
use crate::MacAddress;
use crate::ethernet::{MAX_FRAME, group};
use crate::wire::*;

struct Network {
    monitor: Box<Monitor>,
    n: u64,
    at: Instant,
}

/// What tests look at.
#[derive(Debug, PartialEq)]
struct Seen {
    kind: Kind,
    words: String,
    request: Option<u64>,
    problem: Option<Problem>,
    note: Option<Note>,
}

impl Network {
    fn new() -> Self {
        Self { monitor: Box::new(Monitor::new()), n: 0, at: Instant::ZERO }
    }

    fn bytes(&mut self, frame: Captured<'_>) -> Seen {
        self.n += 1;
        self.at = self.at.saturating_add_millis(1);
        let reading = self.monitor.observe(self.at, self.n, frame);
        Seen {
            kind: reading.kind,
            words: reading.words().to_string(),
            request: reading.request.map(|request| request.n),
            problem: reading.problem,
            note: reading.note,
        }
    }

    fn send(&mut self, to: u8, from: u8, body: Body<'_>) -> Seen {
        let destination = match body {
            Body::Soc(_) => group::SOC,
            Body::Preq(_) => mac(to),
            Body::Pres(_) => group::PRES,
            Body::Soa(_) => group::SOA,
            _ => group::ASND,
        };
        self.bytes((&*emitted(destination, mac(from), to, from, body)).into())
    }

    fn soc(&mut self, relative_time: u64) -> Seen {
        self.send(255, 240, Body::Soc(Soc { relative_time, ..Soc::default() }))
    }

    fn soa(&mut self, service: RequestedService, target: u8, reset: bool) -> Seen {
        let flags = if reset { Flags::EXCEPTION_RESET } else { Flags::empty() };
        let soa = Soa {
            state: NmtStateCode::PRE_OPERATIONAL_2,
            flags,
            service,
            target: NodeId(target),
            version: POWERLINK_V2,
        };
        self.send(255, 240, Body::Soa(soa))
    }

    fn preq(&mut self, to: u8, data: &[u8]) -> Seen {
        self.send(to, 240, Body::Preq(Preq { flags: Flags::DATA_VALID, pdo_version: PdoVersion(0), data }))
    }

    fn pres(&mut self, from: u8, state: NmtStateCode) -> Seen {
        let pres = Pres {
            state,
            flags: Flags::empty(),
            request: AsyncRequest::NONE,
            pdo_version: PdoVersion(0),
            data: &[1, 2],
        };
        self.send(255, from, Body::Pres(pres))
    }

    fn status(&mut self, from: u8, flags: Flags) -> Seen {
        let status = StatusResponse {
            flags,
            request: AsyncRequest::NONE,
            state: NmtStateCode::PRE_OPERATIONAL_1,
            static_errors: [0; 8],
            entries: heapless::Vec::new(),
        };
        self.send(255, from, Body::StatusResponse(status))
    }

    fn command(&mut self, to: u8, command: NmtCommandId) -> Seen {
        self.soa(RequestedService::NMT_REQUEST_INVITE, 240, false);
        self.send(to, 240, Body::NmtCommand(NmtCommand { command, data: &[] }))
    }
}

fn emitted(destination: MacAddress, source: MacAddress, to: u8, from: u8, body: Body<'_>) -> Vec<u8> {
    let mut buffer = [0; MAX_FRAME];
    let frame = Frame { destination, source, to: NodeId(to), from: NodeId(from), body };
    frame.emit(&mut buffer).unwrap().to_vec()
}

const fn mac(node: u8) -> MacAddress {
    MacAddress([2, 0, 0, 0, 0, node])
}

/// A growth is a decision: the documentation of [`Monitor`] names the size.
#[test]
#[cfg(target_pointer_width = "64")]
fn the_size_of_a_monitor_is_known() {
    assert_eq!(core::mem::size_of::<Monitor>(), 316_080);
}
