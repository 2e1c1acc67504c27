//! The referee of one node: it sees what the node hears and what it wants to say, reads the bytes by itself, and shares nothing
//! with the machines.
//!
//! | Rule | |
//! |---|---|
//! | bit rate | a device sends at a rate at which it has heard two frames in a row; a manager at its own |
//! | on line | two Hello requests with the address, a second after each, and nobody objected |
//! | address | one that it was given, or none after another had it; whoever has heard that another has it says no more with it |
//! | without a connection | everything but Get_Attribute_Single is answered 94 08 FF |
//! | answers | only to who has asked |
//! | data | on connections that somebody asked for; those that consume have what the plan says was heard last, or nothing |
//! | managers | give planned addresses to devices that said Hello without one, and ask for planned connections |

use core::time::Duration;

use devicenex_core::message::DeviceIdentity;
use link_core::{BitRate, BusErrorKind, Frame, Instant, LinkEvent, Mode};

#[derive(Clone)]
pub(super) struct Observed {
    device: DeviceIdentity,
    /// Of a manager the rate that it sets.
    sets: Option<BitRate>,
    mode: Option<Mode>,
    /// Frames in a row at the rate at which it listens.
    heard: u8,
    address: u8,
    /// Addresses that it was given.
    given: Vec<u8>,
    /// Another has its address.
    is_contested: bool,
    /// When two Hello requests were on the bus, a second apart.
    hellos: [Option<Instant>; 2],
    /// Requests: class, who, which transaction, which service.
    asked: Vec<(u32, u8, u8, u8)>,
    /// Connections that somebody asked for.
    wanted: Vec<u16>,
    /// The last data of the producer that the plan has.
    data: Vec<u8>,
    /// Devices that said Hello without an address.
    homeless: Vec<[u8; 9]>,
}

impl Observed {
    pub(super) fn device(device: DeviceIdentity, address: u8) -> Self {
        Self {
            device,
            sets: None,
            mode: None,
            heard: 0,
            address,
            given: Vec::new(),
            is_contested: false,
            hellos: [None; 2],
            asked: Vec::new(),
            wanted: Vec::new(),
            data: Vec::new(),
            homeless: Vec::new(),
        }
    }

    pub(super) fn manager(device: DeviceIdentity, address: u8, rate: BitRate) -> Self {
        Self { sets: Some(rate), ..Self::device(device, address) }
    }

    /// A wait that ends at this very moment is over.
    fn is_online(&self, now: Instant) -> bool {
        let over = self.hellos[1].is_some_and(|at| now.saturating_since(at) >= SECOND);
        over && !self.is_contested
    }

    /// Before this moment.
    fn was_online(&self, now: Instant) -> bool {
        self.is_online(now.saturating_sub(Duration::from_nanos(1)))
    }

    /// It begins anew with an address.
    fn begin(&mut self, address: u8) {
        self.address = address;
        self.is_contested = false;
        self.hellos = [None; 2];
        self.given.clear();
        self.asked.clear();
        self.wanted.clear();
    }

    pub(super) fn link(&mut self, event: LinkEvent) {
        match event {
            LinkEvent::ModeSet(mode) => {
                if mode.listen_only {
                    self.heard = 0;
                    self.hellos = [None; 2];
                } else if let Some(rate) = self.sets {
                    assert_eq!(mode.bit_rate, rate, "another rate than that of the manager");
                } else {
                    assert!(self.heard >= 2, "{mode:?} was not confirmed");
                    assert_eq!(
                        self.mode.map(|mode| mode.bit_rate),
                        Some(mode.bit_rate),
                        "not the rate heard"
                    );
                }
                self.mode = Some(mode);
            }
            LinkEvent::BusError(kind) if kind != BusErrorKind::Ack => self.heard = 0,
            LinkEvent::BusOff | LinkEvent::Down => {
                self.mode = None;
                let given = core::mem::take(&mut self.given);
                self.begin(if self.is_contested { NONE } else { self.address });
                // It may have taken it already.
                self.given = given;
            }
            _ => {}
        }
    }

    pub(super) fn hears(&mut self, now: Instant, frame: &Frame) {
        let Some(mode) = self.mode else { return };
        if mode.listen_only {
            self.heard = self.heard.saturating_add(1);
            return;
        }
        let (id, data) = (frame.raw_id(), frame.data());
        if !frame.is_extended() || frame.is_remote() {
            return;
        }
        let (class, to, low) = (id >> 24, (id >> 17 & 0x7F) as u8, id as u16);
        match class {
            0x1F if data.len() == 8 => self.hears_hello(now, id, data),
            0x1E => {
                let stands_by = self.address == NONE && self.was_online(now);
                if let (true, NONE, Some((requested @ 0..NONE, _))) = (stands_by, to, data.split_last())
                    && whole(low, data) == identity(&self.device)
                {
                    self.given.push(*requested);
                }
            }
            0x1D | 0x1C | 0x10..=0x17 if to == self.address && id >> 16 & 1 == 0 => {
                self.hears_request(now, class, low, data);
            }
            0x00 if id == PRODUCER => self.data = data.to_vec(),
            _ => {}
        }
    }

    fn hears_hello(&mut self, now: Instant, id: u32, data: &[u8]) {
        let (address, is_response) = ((id >> 17 & 0x7F) as u8, id >> 16 & 1 == 1);
        let other = whole(id as u16, data);
        if address == NONE && !is_response {
            self.homeless.push(other);
        }
        if address != self.address || address == NONE || other == identity(&self.device) {
            return;
        }
        // Of two that join the lower identity keeps the address.
        self.is_contested |=
            is_response || !self.was_online(now) && order(&other) < order(&identity(&self.device));
    }

    fn hears_request(&mut self, now: Instant, class: u32, low: u16, data: &[u8]) {
        let source = (low >> 9) as u8;
        if source == NONE || source == self.address || !self.was_online(now) {
            return;
        }
        let is_fragment = low & 0x100 != 0;
        let service = if is_fragment { 0 } else { data.first().copied().unwrap_or(0) };
        self.asked.push((kind(class), source, low as u8, service));
        match (class, data) {
            (0x1D, [0x4B, _, a, b, ..]) => self.wanted.push(u16::from_le_bytes([*a, *b])),
            (0x1D, [0x4B, _]) => self.wanted.push(DYNAMIC),
            // Link object, attribute 1.
            (0x10..=0x17, [0x10, 3, 1, 1, address] | [0x10, 3, 0, 1, 1, address]) => {
                self.given.push(*address)
            }
            (0x10..=0x17, [0x10, 3, 1, 0, 1, address] | [0x10, 3, 0, 1, 0, 1, address]) => {
                self.given.push(*address);
            }
            _ => {}
        }
    }

    /// It wants to send a frame.
    pub(super) fn sends(&mut self, now: Instant, frame: &Frame) {
        let mode = self.mode.unwrap_or_else(|| panic!("{frame}: off the bus"));
        assert!(!mode.listen_only, "{frame}: its bit rate is not confirmed");
        assert!(frame.is_extended(), "{frame}: nobody asked for an 11-bit identifier");
        let (id, data) = (frame.raw_id(), frame.data());
        let (class, to, low) = (id >> 24, (id >> 17 & 0x7F) as u8, id as u16);
        if class == 0x1F && !frame.is_remote() {
            return self.says_hello(now, frame, to, id >> 16 & 1 == 1);
        }
        assert!(self.is_online(now) && self.address != NONE, "{frame}: not on line");
        let is_manager = self.sets.is_some();
        match class {
            0x1F => assert!(is_manager, "{frame}: a device asks who is there"),
            0x1E => {
                assert!(is_manager, "{frame}: a device gives addresses away");
                self.gives(frame, whole(low, data), data[7]);
            }
            0x1D | 0x1C | 0x10..=0x17 => {
                assert_eq!((low >> 9) as u8, self.address, "{frame}: another's address");
                if id >> 16 & 1 == 1 {
                    self.answers(frame, class, to, low);
                } else {
                    assert!(is_manager, "{frame}: a device asks");
                    asks(frame, class, to, data);
                }
            }
            0x00..=0x0F => {
                assert_eq!(to, self.address, "{frame}: another's address");
                let connection = if low >= 128 { DYNAMIC } else { low };
                assert!(self.wanted.contains(&connection), "{frame}: nobody asked for that connection");
            }
            _ => panic!("{frame}: a reserved identifier"),
        }
    }

    fn says_hello(&mut self, now: Instant, frame: &Frame, address: u8, is_response: bool) {
        assert_eq!(whole(frame.raw_id() as u16, frame.data()), identity(&self.device), "{frame}: not itself");
        if is_response {
            assert!(
                self.is_online(now) && address == self.address && address != NONE,
                "{frame}: not on line"
            );
            return;
        }
        let gives_way = address == NONE && self.is_contested;
        if gives_way || self.given.contains(&address) {
            return self.begin(address);
        }
        assert_eq!(address, self.address, "{frame}: nobody gave it that address");
        assert!(!self.is_contested, "{frame}: another has that address");
        assert!(address == NONE || !self.is_online(now), "{frame}: it is on line");
    }

    /// A planned address goes to whom it is planned for, if that has none.
    fn gives(&self, frame: &Frame, target: [u8; 9], address: u8) {
        let planned = match (target[6], address) {
            (2, 67) => [0xB1, 0xB2].contains(&target[0]),
            (3, 5) => target[0] == 0x0A,
            (4, 109) => true,
            _ => false,
        };
        assert!(planned, "{frame}: it is not planned");
        assert!(self.homeless.contains(&target), "{frame}: it has an address");
    }

    fn answers(&self, frame: &Frame, class: u32, to: u8, low: u16) {
        // What is said in fragments has its transaction in the data.
        let is_whole = low & 0x100 == 0 && class >= 0x1C;
        let asked = self.asked.iter().filter(|(asked, who, transaction, _)| {
            *asked == kind(class) && *who == to && (!is_whole || *transaction == low as u8)
        });
        let services: Vec<u8> = asked.map(|&(.., service)| service).collect();
        assert!(!services.is_empty(), "{frame}: nobody has asked");
        if class == 0x1C && is_whole && !services.contains(&0x0E) {
            assert_eq!(frame.data(), [0x94, 0x08, 0xFF], "{services:02X?} without a connection");
        }
    }

    /// A frame was on the bus.
    pub(super) fn sent(&mut self, now: Instant, frame: &Frame) {
        let id = frame.raw_id();
        let is_request = frame.is_extended() && !frame.is_remote() && id >> 24 == 0x1F && id >> 16 & 1 == 0;
        if !is_request || (id >> 17 & 0x7F) as u8 != self.address {
            return;
        }
        match &mut self.hellos {
            [first @ None, _] => *first = Some(now),
            [Some(first), second @ None] if now.saturating_since(*first) >= SECOND => *second = Some(now),
            _ => {}
        }
    }

    /// The outputs of connections that consume what the plan says.
    pub(super) fn consumes(&self, outputs: &[[u8; 2]]) {
        for output in outputs {
            assert!(*output == [0; 2] || output[..] == self.data, "{output:02X?} is not {:02X?}", self.data);
        }
    }
}

/// Requests of a manager: a planned connection, or one for explicit messages; and a consumer is told its producer.
fn asks(frame: &Frame, class: u32, to: u8, data: &[u8]) {
    match (class, data) {
        (0x1D, [0x4B, _, instance, 0, ..]) => {
            let planned = matches!((to, instance), (_, 1) | (67, 7) | (5, 13) | (109, 9 | 13));
            assert!(planned, "{frame}: it is not planned");
        }
        (0x10..=0x17, [0x10, 5, _, 5, id @ ..]) => {
            assert_eq!(id, (0x8000_0000 | PRODUCER).to_le_bytes(), "{frame}: not its producer");
        }
        (0x1C, [service, ..]) if frame.raw_id() & 0x100 == 0 => {
            assert_eq!(*service, 0x0E, "{frame}: without a connection");
        }
        _ => {}
    }
}

/// Of all classes of messages on a connection one.
const fn kind(class: u32) -> u32 {
    if class < 0x18 { 0x10 } else { class }
}

/// Serial number, vendor, product and revision, as an identifier and the data of a Hello or ROAM have them.
fn whole(low: u16, data: &[u8]) -> [u8; 9] {
    let mut whole = [0; 9];
    whole[..2].copy_from_slice(&low.to_be_bytes());
    whole[2..].copy_from_slice(&data[..7]);
    whole
}

fn identity(device: &DeviceIdentity) -> [u8; 9] {
    let [s0, s1, s2, s3] = device.serial.to_le_bytes();
    let [p0, p1] = device.product_code.to_le_bytes();
    let [v0, v1] = device.vendor.0.to_le_bytes();
    [s0, s1, s2, s3, v0, v1, p0, p1, device.major_revision]
}

/// Vendor, product, revision, serial number: by which identities are compared.
fn order([s0, s1, s2, s3, v0, v1, p0, p1, revision]: &[u8; 9]) -> (u16, u16, u8, u32) {
    let [vendor, product] = [[*v0, *v1], [*p0, *p1]].map(u16::from_le_bytes);
    (vendor, product, *revision, u32::from_le_bytes([*s0, *s1, *s2, *s3]))
}

const SECOND: Duration = Duration::from_secs(1);
/// No address.
const NONE: u8 = 127;
/// Any connection from 128 on.
const DYNAMIC: u16 = 128;
/// Message ID 0, OA 67, connection 7.
const PRODUCER: u32 = 0x0086_0007;
