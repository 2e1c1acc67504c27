//! Every rule: what makes it speak, what nearly does, and what ends it.

mod access;
mod bus;
mod io;
mod ledger;
mod ownership;
mod producers;

use std::boxed::Box;
use std::string::{String, ToString};
use std::vec::Vec;

use core::time::Duration;

use link_core::{Frame, Instant, LinkEvent};

use super::*;
use crate::id::{Identifier, MacId};
use crate::monitor::{Monitor, MonitorConfig};

/// What happens on a bus.
type Deed = fn(&mut Ward);

/// A bus that a doctor listens to.
struct Ward {
    monitor: Box<Monitor>,
    doctor: Box<Doctor>,
    /// Milliseconds.
    now: u64,
    n: u64,
}

impl Ward {
    fn new() -> Self {
        Self::with(DoctorConfig::default())
    }

    fn with(config: DoctorConfig) -> Self {
        let monitor = Box::new(Monitor::new(MonitorConfig::default()));
        Self { monitor, doctor: Box::new(Doctor::new(config)), now: 0, n: 0 }
    }

    /// Slave 10 of master 1, polled, with an expected packet rate of 100 ms.
    fn with_slave() -> Self {
        Self::with_slave_of(DoctorConfig::default(), 0x03)
    }

    /// The same with another choice; the I/O connection beside the explicit one is the one that is established.
    fn with_slave_of(config: DoctorConfig, choice: u8) -> Self {
        let mut ward = Self::with(config);
        ward.allocate(10, 1, choice);
        let instance = match choice {
            0x05 => 3,
            0x11 | 0x21 => 4,
            _ => 2,
        };
        ward.group2(10, 4, &[1, 0x10, 5, instance, 9, 100, 0]);
        ward.group2(10, 3, &[1, 0x90, 100, 0]);
        ward
    }

    fn allocate(&mut self, slave: u8, master: u8, choice: u8) {
        self.group2(slave, 6, &[master, 0x4B, 3, 1, choice, master]);
        self.group2(slave, 3, &[master, 0xCB, 0]);
    }

    /// A frame a millisecond after the last.
    #[track_caller]
    fn frame(&mut self, frame: &Frame) -> &mut Self {
        self.wait(1);
        self.n += 1;
        self.doctor.observe(&mut self.monitor, Instant::from_millis(self.now), self.n, frame);
        self
    }

    #[track_caller]
    fn id(&mut self, id: u16, data: &[u8]) -> &mut Self {
        self.frame(&Identifier::new(id).unwrap().frame(data).unwrap())
    }

    #[track_caller]
    fn group1(&mut self, message: u8, source: u8, data: &[u8]) -> &mut Self {
        self.id(Identifier::group1(message, mac(source)).unwrap().raw(), data)
    }

    #[track_caller]
    fn group2(&mut self, node: u8, message: u8, data: &[u8]) -> &mut Self {
        self.id(Identifier::group2(mac(node), message).unwrap().raw(), data)
    }

    /// A duplicate MAC ID check of a device.
    fn check(&mut self, node: u8, first: u8, serial: u8) -> &mut Self {
        self.group2(node, 7, &[first, 0x34, 0x12, serial, 0, 0, 0])
    }

    fn poll(&mut self) -> &mut Self {
        self.group2(10, 5, &[1])
    }

    fn answer(&mut self) -> &mut Self {
        self.group1(0xF, 10, &[2])
    }

    fn link(&mut self, event: LinkEvent) -> &mut Self {
        self.doctor.link(Instant::from_millis(self.now), None, event);
        self
    }

    /// Time passes, a tick every 10 ms.
    fn wait(&mut self, millis: u64) -> &mut Self {
        let until = self.now + millis;
        while self.now < until {
            self.now = (self.now + 10).min(until);
            self.doctor.tick(&self.monitor, Instant::from_millis(self.now));
        }
        self
    }

    /// The findings of a rule: since when in milliseconds, until when, and in words.
    fn of(&self, rule: Rule) -> Vec<(u64, Option<u64>, String)> {
        let millis = |at: Instant| at.as_nanos() / 1_000_000;
        let found = self.doctor.findings().filter(|finding| finding.rule == rule);
        found.map(|found| (millis(found.since), found.until.map(millis), found.to_string())).collect()
    }

    /// The rules that have a finding, in the order in which they were found.
    fn rules(&self) -> Vec<Rule> {
        self.doctor.findings().map(|finding| finding.rule).collect()
    }

    #[track_caller]
    fn only(&self, rule: Rule) -> Finding {
        assert_eq!(self.rules(), [rule]);
        *self.doctor.findings().next().unwrap()
    }

    #[track_caller]
    fn is_healthy(&self) {
        assert_eq!(
            self.rules(),
            [],
            "{:?}",
            self.doctor.findings().map(ToString::to_string).collect::<Vec<_>>()
        );
    }
}

fn mac(number: u8) -> MacId {
    MacId::new(number).unwrap()
}

/// The table of the module names every rule, and a rule's name, words and advice are there and differ.
#[test]
fn rules_have_names_and_advice() {
    let mut codes: Vec<&str> = Rule::ALL.iter().map(|rule| rule.code()).collect();
    assert!(codes.iter().all(|code| code.bytes().all(|byte| byte == b'_' || byte.is_ascii_lowercase())));
    codes.sort_unstable();
    codes.dedup();
    assert_eq!(codes.len(), Rule::ALL.len());
    for &rule in Rule::ALL {
        assert_eq!(rule.bit().count_ones(), 1, "{rule}");
        let advice = rule.advice().to_string();
        assert!(!rule.words().is_empty() && advice.len() > 20 && !advice.contains(['{', '}']), "{advice}");
    }
}

/// A growth is a decision.
#[test]
#[cfg(target_pointer_width = "64")]
fn the_size_of_a_doctor_is_known() {
    assert_eq!(core::mem::size_of::<Doctor>(), 65_632);
}
