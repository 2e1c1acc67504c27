//! Traffic of a DeviceNet network of any length: the same seed gives the same frames.
//!
//! A master (MAC ID 1) starts up nineteen slaves, polls, strobes and acknowledges them at 500 kbit/s, and reads their
//! attributes now and then, in one frame or in fragments; from time to time a slave loses power and comes back.

pub(crate) mod powerlink;

use std::collections::VecDeque;
use std::time::Duration;

use devicenet_core::id::{Identifier, MacId};
use link_core::{Frame, Instant};

/// An endless recording.
pub(crate) struct Traffic {
    now: Instant,
    random: u64,
    slaves: Vec<Slave>,
    cycle: u64,
    pending: VecDeque<(Instant, Frame)>,
}

#[derive(Clone, Copy)]
struct Slave {
    mac: MacId,
    io: Io,
    serial: u32,
    produced: usize,
    consumed: usize,
    counter: u8,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Io {
    Poll,
    Strobe,
    ChangeOfState,
}

impl Traffic {
    /// Starts with the power-up of the network.
    pub(crate) fn new(seed: u64) -> Self {
        let mut traffic = Self {
            now: Instant::from_nanos(1_700_000_000_000_000_000),
            random: seed,
            slaves: Vec::new(),
            cycle: 0,
            pending: VecDeque::new(),
        };
        for (index, mac) in MacId::all().skip(2).step_by(3).take(19).enumerate() {
            let io = match index % 8 {
                6 => Io::Strobe,
                7 => Io::ChangeOfState,
                _ => Io::Poll,
            };
            let (produced, consumed) = (1 + traffic.below(8), traffic.below(9));
            let serial = 0x0100_0000 + index as u32;
            traffic.slaves.push(Slave { mac, io, serial, produced, consumed, counter: 0 });
        }
        for round in 0..2 {
            traffic.pause(Duration::from_millis(1000 * round));
            for slave in traffic.slaves.clone() {
                traffic.duplicate_mac_check(slave);
            }
        }
        traffic.pause(Duration::from_millis(1000));
        for slave in traffic.slaves.clone() {
            traffic.allocate(slave);
        }
        traffic
    }

    /// One scan of all slaves, and what happens beside it.
    fn scan(&mut self) {
        self.cycle += 1;
        for index in 0..self.slaves.len() {
            let mut slave = self.slaves[index];
            let data = [slave.counter, 0x55, slave.counter, 0, 0xFF, 1, 2, 3];
            match slave.io {
                Io::Poll => {
                    self.send(Identifier::poll_command(slave.mac), &data[..slave.consumed], MASTER_PAUSE);
                    self.send(Identifier::poll_response(slave.mac), &data[..slave.produced], REACTION);
                }
                Io::ChangeOfState if self.below(8) == 0 => {
                    self.send(Identifier::change_of_state(slave.mac), &data[..slave.produced], REACTION);
                    self.send(Identifier::change_of_state_acknowledge(slave.mac), &[], MASTER_PAUSE);
                }
                Io::ChangeOfState | Io::Strobe => {}
            }
            slave.counter = slave.counter.wrapping_add(self.below(2) as u8);
            self.slaves[index] = slave;
        }
        if self.cycle.is_multiple_of(4) {
            self.send(Identifier::bit_strobe_command(MASTER), &[0xFF; 8], MASTER_PAUSE);
            for slave in self.slaves.clone() {
                if slave.io == Io::Strobe {
                    let data = [slave.counter; 8];
                    self.send(Identifier::bit_strobe_response(slave.mac), &data[..slave.produced], REACTION);
                }
            }
        }
        let chosen = self.below(self.slaves.len());
        let slave = self.slaves[chosen];
        match self.below(256) {
            0..128 => self.read_attribute(slave),
            128..168 => self.read_product_name(slave),
            168..170 => {
                self.duplicate_mac_check(slave);
                self.pause(Duration::from_secs(1));
                self.duplicate_mac_check(slave);
                self.pause(Duration::from_secs(1));
                self.allocate(slave);
            }
            _ => {}
        }
        self.pause(Duration::from_millis(2));
    }

    fn duplicate_mac_check(&mut self, slave: Slave) {
        let [a, b, c, d] = slave.serial.to_le_bytes();
        // Port 0, request; vendor 0x1234.
        self.send(Identifier::duplicate_mac_check(slave.mac), &[0x00, 0x34, 0x12, a, b, c, d], REACTION);
    }

    /// Allocation through the unconnected port, then the expected packet rates.
    fn allocate(&mut self, slave: Slave) {
        let (choice, instance) = match slave.io {
            Io::Poll => (0x03, 2),
            Io::Strobe => (0x05, 3),
            Io::ChangeOfState => (0x11, 4),
        };
        let master = MASTER_MAC;
        let request = [master, 0x4B, 0x03, 0x01, choice, master];
        self.send(Identifier::group2_unconnected_request(slave.mac), &request, MASTER_PAUSE);
        self.send(Identifier::explicit_response(slave.mac), &[master, 0xCB, 0x00], REACTION);
        for instance in [1, instance] {
            self.exchange(slave, &[0x10, 0x05, instance, 0x09, 0xC4, 0x09], &[0x90, 0xC4, 0x09]);
        }
    }

    fn read_attribute(&mut self, slave: Slave) {
        let [a, b, c, d] = slave.serial.to_le_bytes();
        match self.below(6) {
            0 => self.exchange(slave, &[0x0E, 0x01, 0x01, 0x01], &[0x8E, 0x34, 0x12]),
            1 => self.exchange(slave, &[0x0E, 0x01, 0x01, 0x06], &[0x8E, a, b, c, d]),
            2 => self.exchange(slave, &[0x0E, 0x01, 0x01, 0x05], &[0x8E, 0x01, 0x00]),
            3 => self.exchange(slave, &[0x0E, 0x03, 0x01, 0x01], &[0x8E, slave.mac.into()]),
            4 => self.exchange(slave, &[0x0E, 0x05, 0x01, 0x01], &[0x8E, 0x03]),
            // No such attribute.
            _ => self.exchange(slave, &[0x0E, 0x01, 0x01, 0x63], &[0x94, 0x14, 0xFF]),
        }
    }

    fn exchange(&mut self, slave: Slave, request: &[u8], response: &[u8]) {
        self.send(Identifier::explicit_request(slave.mac), &with_header(request), MASTER_PAUSE);
        self.send(Identifier::explicit_response(slave.mac), &with_header(response), REACTION);
    }

    /// A response of three fragments, each acknowledged by the master.
    fn read_product_name(&mut self, slave: Slave) {
        let fragmented = MASTER_MAC | 0x80;
        let (ask, answer) =
            (Identifier::explicit_request(slave.mac), Identifier::explicit_response(slave.mac));
        self.send(ask, &with_header(&[0x0E, 0x01, 0x01, 0x07]), MASTER_PAUSE);
        let name = *b"\x8E\x0FPressure gauge ";
        for (count, piece) in name.chunks(6).enumerate() {
            let count = count as u8;
            let kind = [0x00, 0x40, 0x80][usize::from(count)];
            self.send(answer, &[&[fragmented, kind | count], piece].concat(), REACTION);
            self.send(ask, &[fragmented, 0xC0 | count, 0x00], MASTER_PAUSE);
        }
    }

    fn send(&mut self, identifier: Identifier, data: &[u8], pause: Duration) {
        self.pause(pause);
        if let Some(frame) = identifier.frame(data) {
            // Intermission is three bits; a controller stamps the end of the frame.
            let bits = frame.bit_len() + 3;
            self.pause(BIT_TIME * bits);
            self.pending.push_back((self.now, frame));
        }
    }

    fn pause(&mut self, span: Duration) {
        let jitter = Duration::from_micros(self.below(20) as u64);
        self.now += span + jitter;
    }

    fn below(&mut self, bound: usize) -> usize {
        below(&mut self.random, bound)
    }
}

impl Iterator for Traffic {
    type Item = (Instant, Frame);

    fn next(&mut self) -> Option<Self::Item> {
        while self.pending.is_empty() {
            self.scan();
        }
        self.pending.pop_front()
    }
}

/// SplitMix64.
fn below(random: &mut u64, bound: usize) -> usize {
    *random = random.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut z = *random;
    z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ z >> 31) % bound as u64) as usize
}

fn with_header(body: &[u8]) -> Vec<u8> {
    [&[MASTER_MAC], body].concat()
}

const MASTER_MAC: u8 = 1;
const MASTER: MacId = MacId::from_low_bits(MASTER_MAC);
const BIT_TIME: Duration = Duration::from_micros(2);
const REACTION: Duration = Duration::from_micros(250);
const MASTER_PAUSE: Duration = Duration::from_micros(60);
