//! OA 40, which need not be anybody's: it asks without a connection and with one, contests addresses, gives some away, and passes
//! for a manager.

use link_core::Frame;
use link_core::frame::extended_id;
use transport_mock::nodes::External;

use super::node::{Node, Station};
use super::{NODES, OWN, Plant, device, oa};
use devicenex_core::message::Roam;

impl Plant {
    /// The stranger says something, or the manager is told to.
    pub(super) fn meddle(&mut self, argument: u8) {
        let to = [NODES[0], NODES[1], NODES[2], OWN][usize::from(argument & 3)];
        let what = argument >> 2;
        match what % 17 {
            15 => self.readdress(to, what),
            16 => self.identify(to),
            said => {
                self.transaction = self.transaction.wrapping_add(1);
                let frame = frame(said, to, what, self.transaction.into());
                self.network.command(self.stranger, |stranger: &mut External, now| {
                    // What cannot be sent now is not said.
                    _ = stranger.inject(now, (), frame);
                });
            }
        }
    }

    /// To a planned address or another.
    fn readdress(&mut self, from: u8, what: u8) {
        let to = [NEW, NODES[usize::from(what) % 3]][usize::from(what >> 5)];
        self.network.command(self.nodes[0], |node: &mut Node, _| {
            if let Station::Manager(manager) = &mut node.station {
                // What it may not do now it refuses.
                _ = manager.readdress(oa(from), oa(to));
            }
        });
    }

    fn identify(&mut self, to: u8) {
        self.network.command(self.nodes[0], |node: &mut Node, _| {
            if let Station::Manager(manager) = &mut node.station {
                let request = cip_core::message::Request::new(0x01.into(), 1.into(), 1.into(), &[]);
                _ = manager.request(oa(to), &request, 1);
            }
        });
    }
}

fn frame(said: u8, to: u8, what: u8, transaction: u32) -> Frame {
    let address = u32::from(to) << 17;
    let at = |class: u32| class << 24 | address | STRANGER << 9 | transaction;
    let (id, data): (u32, &[u8]) = match said {
        0 => (at(0x1C), &[0x0E, 1, 1, 7]),
        1 => (at(0x1C), &[0x10, 3, 1, 1, NEW]),
        2 => (at(0x1C), &[0x05, 1, 1]),
        3 => (at(0x1C), &[0x4B, 0xC0, 7, 0, 0, 0, 0]),
        4 => (at(0x1D), &[0x4B, 0xD0, 1, 0, 0xC4, 9, 1]),
        // Twice, so that the second finds the connection that the first may need.
        5 => (at(0x10), &[0x10, 3, 1, 1, NEW]),
        6 => (at(0x10), &[0x10, 3, 1, 1, NODES[1]]),
        7 => (at(0x1D), &[0x4B, 0xC0, 3, 0, 100, 0, 0]),
        8 => (at(0x1D), &[0x4B, 0x40]),
        // Hello with that address: a response, a request.
        9 => (0x1F00_0000 | address | 0x1_0000 | LOW, &[0, 0, 9, 0, 9, 0, 1, 0]),
        10 => (0x1F00_0000 | address | LOW, &[0, 0, 9, 0, 9, 0, 1, 0]),
        11 => {
            let target = device(what >> 4);
            return Roam { target, requested: oa(to) }.frame().expect("eight bytes");
        }
        12 | 13 => {
            let low = if said == 12 { 0x0100 } else { 0xFFFF };
            return Frame::remote(extended_id(0x1FFE_0000 | low), 8).expect("it is short");
        }
        _ => (at(0x1C), &[0x0E, 5, 7, 1]),
    };
    Frame::new(extended_id(id), data).expect("at most eight bytes")
}

const STRANGER: u32 = 40;
/// The low half of its serial number.
const LOW: u32 = 0x5555;
/// An address that is not planned.
const NEW: u8 = 13;
