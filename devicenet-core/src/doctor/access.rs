//! Presence: nodes that are never heard, duplicate MAC IDs, restarts, faults, and devices that wait for recovery.

use core::time::Duration;

use cip_core::code::{AttributeId, ClassId, ServiceCode};
use link_core::Instant;

use super::Clinic;
use super::finding::Facts;
use super::ledger::Sign;
use super::patient::{Asked, Check, Seen, Unasked};
use super::rule::{Rule, Severity};
use crate::id::MacId;
use crate::message::{DeviceIdentity, DeviceState, HeartbeatFlags};
use crate::monitor::{AccessState, Detail, Kind, Note, Reading};

impl<const N: usize> Clinic<'_, N> {
    /// Any frame of a node, and any request to one.
    pub(super) fn presence(&mut self, reading: &Reading<'_>) {
        let seen = Seen { n: reading.n, at: reading.at };
        if let (
            Kind::ExplicitRequest | Kind::UnconnectedRequest | Kind::Group2UnconnectedRequest,
            Some(node),
        ) = (reading.kind, reading.dst)
        {
            let by = reading.src;
            let asked =
                self.patient(node).asked.get_or_insert(Asked { first: seen, last: seen, by, count: 0 });
            (asked.last, asked.by) = (seen, by);
            asked.count = asked.count.saturating_add(1);
        }
        let Some(source) = reading.src else { return };
        if matches!(reading.kind, Kind::OfflineFaultResponse | Kind::OfflineOwnershipRequest) {
            return;
        }
        let patient = self.patient(source);
        patient.asked = None;
        patient.was_heard = true;
        self.end_requests(source, seen.at);
        if reading.kind != Kind::Shutdown {
            self.ledger.end(Rule::Left, Some(source), seen.at);
        }
    }

    /// Duplicate MAC ID checks, the offline connection set, heartbeats and farewells.
    pub(super) fn access(&mut self, reading: &Reading<'_>) {
        let seen = Seen { n: reading.n, at: reading.at };
        let device = device_of(reading);
        match (reading.kind, reading.src) {
            (Kind::DupMacRequest, Some(mac)) => {
                self.restarts(reading, mac, seen);
                if let Some(device) = device {
                    self.checks(mac, device, seen);
                }
            }
            (Kind::DupMacResponse, Some(mac)) => self.defends(mac, device, seen),
            (Kind::OfflineFaultResponse, node) => {
                if let (Some(device), Detail::WhoAnswer) = (device, reading.fields.detail) {
                    let facts = Facts::Device(device);
                    self.event(Rule::WaitingForRecovery, Severity::Error, node, facts, seen);
                }
            }
            (Kind::Heartbeat, Some(mac)) => self.heartbeat(reading, mac, seen),
            (Kind::Shutdown, Some(mac)) => {
                let patient = self.patient(mac);
                patient.begin_anew();
                (patient.holder, patient.owner) = (None, None);
                let code = match reading.fields.detail {
                    Detail::Shutdown { code } => code,
                    _ => 0,
                };
                self.event(Rule::Left, Severity::Info, Some(mac), Facts::ShutdownCode(code), seen);
            }
            (Kind::ExplicitResponse | Kind::Fragment, Some(mac)) => self.told(reading, mac, seen),
            _ => {}
        }
    }

    /// It is there after all, or nobody asks for it any more.
    fn end_requests(&mut self, mac: MacId, at: Instant) {
        for rule in [Rule::NotFound, Rule::NotAnswering] {
            self.ledger.end_where(rule, at, |finding| {
                finding.node == Some(mac) && matches!(finding.facts, Facts::Requests { .. })
            });
        }
    }

    fn restarts(&mut self, reading: &Reading<'_>, mac: MacId, seen: Seen) {
        let before = self.patient(mac).check;
        self.patient(mac).begin_anew();
        // Whoever checks belongs to nobody, unless it is another one.
        if reading.problem.is_none() && reading.note != Some(Note::RestartedOrAnother) {
            self.patient(mac).owner = self.records.owner(mac);
        }
        // What it has told of itself is no longer true, and it tells it anew.
        for rule in [Rule::Fault, Rule::BusOff] {
            self.ledger.end(rule, Some(mac), seen.at);
        }
        // One that nobody acknowledges sends each of its two checks many times.
        let begins = before.is_none_or(|before| seen.at.saturating_since(before.seen.at) > BEGINS_ANEW);
        if reading.note == Some(Note::Restarted) && begins {
            let before = self.ledger.open(Rule::Restarted, Some(mac)).map_or(0, |finding| finding.count);
            let severity = if before >= OFTEN { Severity::Warning } else { Severity::Info };
            self.event(Rule::Restarted, severity, Some(mac), Facts::None, seen);
        }
    }

    fn checks(&mut self, mac: MacId, device: DeviceIdentity, seen: Seen) {
        self.ledger.end_where(
            Rule::WaitingForRecovery,
            seen.at,
            |finding| matches!(finding.facts, Facts::Device(waiting) if waiting == device),
        );
        // One of the two has gone elsewhere.
        self.ledger.end_where(Rule::DuplicateMacId, seen.at, |finding| {
            finding.node != Some(mac) && is_rival(finding.facts, device)
        });
        for (other, patient) in MacId::all().zip(self.patients.iter_mut()) {
            if other != mac && patient.holder == Some(device) {
                patient.holder = None;
            }
        }
        let before = self.patient(mac).check.replace(Check { seen, device });
        let Some(before) = before.filter(|before| before.device != device) else { return };
        if seen.at.saturating_since(before.seen.at) > BOTH_CHECK {
            return;
        }
        let held = self.ledger.open(Rule::DuplicateMacId, Some(mac)).copied();
        // One that is still there would have objected to the first of the two.
        let is_there = |holder: DeviceIdentity| {
            holder == device
                || holder == before.device
                || held.is_some_and(|held| is_rival(held.facts, holder) && held.last >= before.seen.at)
        };
        let facts = match self.patient(mac).holder.filter(|&holder| is_there(holder)) {
            Some(holder) if holder == device => {
                Facts::Rivals { holder: Some(holder), rival: Some(before.device) }
            }
            Some(holder) => Facts::Rivals { holder: Some(holder), rival: Some(device) },
            // They have met before.
            None if held
                .is_some_and(|held| is_rival(held.facts, before.device) && is_rival(held.facts, device)) =>
            {
                return;
            }
            // Neither was on line yet: the one that hears the other goes off line without a word.
            None => Facts::Contenders { first: before.device, second: device },
        };
        self.duplicate(mac, facts, Some(before.seen), seen);
    }

    fn defends(&mut self, mac: MacId, holder: Option<DeviceIdentity>, seen: Seen) {
        let check = self.patient(mac).check;
        // An answer to a question that was not heard says nothing of one that was.
        let check = check.filter(|check| seen.at.saturating_since(check.seen.at) <= BOTH_CHECK);
        let rival = check.map(|check| check.device).filter(|&device| Some(device) != holder);
        let request = check.map(|check| check.seen);
        if holder.is_some() {
            self.patient(mac).holder = holder;
        }
        self.duplicate(mac, Facts::Rivals { holder, rival }, request, seen);
    }

    fn duplicate(&mut self, mac: MacId, facts: Facts, before: Option<Seen>, seen: Seen) {
        self.ledger.see(&Sign {
            rule: Rule::DuplicateMacId,
            severity: Severity::Error,
            node: Some(mac),
            facts,
            since: seen.at,
            at: seen.at,
            frames: [before.map(|before| before.n), Some(seen.n)],
        });
    }

    fn heartbeat(&mut self, reading: &Reading<'_>, mac: MacId, seen: Seen) {
        let Detail::Heartbeat { state, flags, .. } = reading.fields.detail else { return };
        let is_major = [DeviceState::MAJOR_RECOVERABLE_FAULT, DeviceState::MAJOR_UNRECOVERABLE_FAULT]
            .contains(&DeviceState(state));
        let faults = HeartbeatFlags::DEVICE_FAULT | HeartbeatFlags::USER_FAULT | HeartbeatFlags::SYSTEM_FAULT;
        if is_major || flags & faults.bits() != 0 {
            let severity = if state == DeviceState::MAJOR_UNRECOVERABLE_FAULT.0 {
                Severity::Error
            } else {
                Severity::Warning
            };
            self.event(Rule::Fault, severity, Some(mac), Facts::Heartbeat { state, flags }, seen);
        } else {
            self.ledger.end(Rule::Fault, Some(mac), seen.at);
        }
    }

    /// What a node answers about itself.
    fn told(&mut self, reading: &Reading<'_>, mac: MacId, seen: Seen) {
        let message = reading.message.as_ref();
        let fields = message.map_or(&reading.fields, |message| &message.fields);
        if fields.explicit.service != Some(ServiceCode::GET_ATTRIBUTE_SINGLE)
            || fields.explicit.status.is_some()
        {
            return;
        }
        let value = message.map_or(reading.value(), |message| message.value()).unwrap_or_default();
        match (fields.explicit.class, fields.explicit.attribute, value) {
            (Some(ClassId::IDENTITY), Some(STATUS), &[low, high]) => {
                let status = u16::from_le_bytes([low, high]);
                if status & FAULTS == 0 {
                    return self.ledger.end(Rule::Fault, Some(mac), seen.at);
                }
                let severity = if status & UNRECOVERABLE != 0 { Severity::Error } else { Severity::Warning };
                self.event(Rule::Fault, severity, Some(mac), Facts::Status(status), seen);
            }
            (Some(ClassId::DEVICENET), Some(BUS_OFF_COUNTER), &[0]) => {
                self.ledger.end(Rule::BusOff, Some(mac), seen.at);
            }
            (Some(ClassId::DEVICENET), Some(BUS_OFF_COUNTER), &[count]) => {
                let facts = Facts::BusOffCount(count);
                if self.ledger.open(Rule::BusOff, Some(mac)).is_none_or(|held| held.facts != facts) {
                    self.event(Rule::BusOff, Severity::Warning, Some(mac), facts, seen);
                }
            }
            _ => {}
        }
    }

    /// Answers without a question: one can be that of a lost question, several are those of a second sender.
    pub(super) fn unasked(&mut self, mac: MacId, reading: &Reading<'_>) {
        let seen = Seen { n: reading.n, at: reading.at };
        // The question, or the beginning of the message, can be from before the first frame.
        let is_first = seen.at.saturating_since(self.begin) <= BEGUN_BEFORE;
        if is_first && !self.records.is_allocation_told(mac) {
            return;
        }
        let most = if reading.problem.is_some() { MOST_UNASKED } else { MOST_UNASKED_AT_ALL };
        let patient = self.patient(mac);
        if patient.is_late() {
            return;
        }
        let mut unasked = patient
            .unasked
            .filter(|unasked| seen.at.saturating_since(unasked.first.at) <= UNASKED_WITHIN)
            .unwrap_or(Unasked { first: seen, count: 0 });
        unasked.count = unasked.count.saturating_add(1);
        patient.unasked = Some(unasked);
        if unasked.count >= most {
            self.second_sender(mac, reading, unasked.first);
        }
    }

    /// An answer that came twice: one can have been sent again, nearly all are those of a second sender that has the same to say.
    pub(super) fn doubled(&mut self, mac: MacId, reading: &Reading<'_>) {
        let patient = self.patient(mac);
        if patient.is_late() {
            return;
        }
        patient.doubled = patient.doubled.saturating_add(TWICE).min(MOST_TWICE);
        if patient.doubled == MOST_TWICE {
            self.second_sender(mac, reading, Seen { n: reading.n, at: reading.at });
        }
    }

    /// The identifier of a frame, which belongs to a node, has another sender, too; `first` is the first frame that shows it.
    pub(super) fn second_sender(&mut self, mac: MacId, reading: &Reading<'_>, first: Seen) {
        let identifier = u16::try_from(reading.frame.raw_id()).unwrap_or(u16::MAX);
        self.ledger.see(&Sign {
            rule: Rule::IdentifierCollision,
            severity: if self.records.is_allocation_told(mac) { Severity::Error } else { Severity::Warning },
            node: Some(mac),
            facts: Facts::Identifier(identifier),
            since: first.at,
            at: reading.at,
            frames: [Some(first.n), Some(reading.n)],
        });
    }

    /// Who does not answer by now, and which duplicates are over.
    pub(super) fn look_at_presence(&mut self, now: Instant) {
        let quiet = self.config.quiet_after;
        for mac in MacId::all() {
            let patient = self.patient(mac);
            let Some(asked) = patient.asked else { continue };
            if now.saturating_since(asked.last.at) >= quiet {
                patient.asked = None;
                self.end_requests(mac, asked.last.at + quiet);
                continue;
            }
            let is_late = now.saturating_since(asked.first.at) >= NO_ANSWER;
            let is_sought = asked.last.at.saturating_since(asked.first.at) >= SOUGHT;
            let (rule, severity, is_due) = match (patient.was_heard, patient.expected.is_some()) {
                (true, _) => (Rule::NotAnswering, Severity::Error, is_late),
                (false, true) => (Rule::NotFound, Severity::Error, is_late),
                (false, false) => (Rule::NotFound, Severity::Warning, is_sought),
            };
            if asked.count < FEWEST_REQUESTS || !is_due {
                continue;
            }
            let facts = Facts::Requests { by: asked.by, count: asked.count };
            let is_told = self.ledger.open(rule, Some(mac)).is_some_and(|held| {
                // That its I/O stands still tells no less.
                let stands_still = matches!(held.facts, Facts::Silence { .. }) && held.severity >= severity;
                held.facts == facts || stands_still
            });
            if is_told {
                continue;
            }
            self.ledger.see(&Sign {
                rule,
                severity,
                node: Some(mac),
                facts,
                since: asked.first.at,
                at: now,
                frames: [Some(asked.first.n), Some(asked.last.n)],
            });
        }
        self.look_at_rivals(now);
    }

    /// Who has a MAC ID by now.
    fn look_at_holders(&mut self, now: Instant) {
        for mac in MacId::all() {
            if self.patient(mac).check.is_none() || self.records.access(mac, now) != AccessState::OnLine {
                continue;
            }
            let told = self.records.told(mac);
            let Some((vendor, serial)) = told.vendor.zip(told.serial) else { continue };
            let holder = DeviceIdentity { vendor, serial };
            if self.patient(mac).holder.replace(holder) == Some(holder) {
                continue;
            }
            self.ledger.amend(Rule::DuplicateMacId, mac, |facts| match facts {
                Facts::Contenders { first, second } if holder == first || holder == second => {
                    let rival = Some(if holder == first { second } else { first });
                    Facts::Rivals { holder: Some(holder), rival }
                }
                facts => facts,
            });
        }
    }

    /// The rival has begun anew, nobody has objected, and it has got the MAC ID.
    fn look_at_rivals(&mut self, now: Instant) {
        self.look_at_holders(now);
        let (records, patients) = (self.records, &*self.patients);
        self.ledger.end_where(Rule::DuplicateMacId, now, |finding| {
            let (Some(mac), Facts::Rivals { rival: Some(rival), .. }) = (finding.node, finding.facts) else {
                return false;
            };
            let check = patients.get(mac.index()).and_then(|patient| patient.check);
            let is_anew = check.is_some_and(|check| {
                check.device == rival && check.seen.at.saturating_since(finding.last) > BEGINS_ANEW
            });
            is_anew && records.access(mac, now) == AccessState::OnLine
        });
    }
}

pub(super) fn device_of(reading: &Reading<'_>) -> Option<DeviceIdentity> {
    Some(DeviceIdentity { vendor: reading.fields.vendor?, serial: reading.fields.serial? })
}

fn is_rival(facts: Facts, device: DeviceIdentity) -> bool {
    match facts {
        Facts::Rivals { holder, rival } => holder == Some(device) || rival == Some(device),
        Facts::Contenders { first, second } => first == device || second == device,
        _ => false,
    }
}

/// Attribute 5 of the Identity object.
const STATUS: AttributeId = AttributeId(5);
/// Bits 8-11: minor and major faults.
const FAULTS: u16 = 0x0F00;
/// Bits 9 and 11.
const UNRECOVERABLE: u16 = 0x0A00;
/// Attribute 4 of the DeviceNet object.
const BUS_OFF_COUNTER: AttributeId = AttributeId(4);
/// The wait after each check: another device that checks meanwhile meets one that is not on line yet.
const BOTH_CHECK: Duration = Duration::from_secs(1);
/// The second check follows the first within this time; one that comes later begins anew.
const BEGINS_ANEW: Duration = Duration::from_millis(1_500);
/// A node that restarts for so many times more than once is in trouble.
const OFTEN: u32 = 2;
const FEWEST_REQUESTS: u16 = 3;
/// A client waits a second for an answer and asks again; after this time it has given up.
const NO_ANSWER: Duration = Duration::from_millis(2_500);
/// A tool that looks who is there asks each MAC ID for four seconds at most; a master goes on.
const SOUGHT: Duration = Duration::from_secs(5);
const MOST_UNASKED: u16 = 3;
/// Of a node of which no command was ever seen.
const MOST_UNASKED_AT_ALL: u16 = 10;
/// An answer that came twice weighs as much as two that did not.
const TWICE: u8 = 2;
const MOST_TWICE: u8 = 8;
/// So long after the first frame there can be answers to what was asked before it.
const BEGUN_BEFORE: Duration = Duration::from_secs(1);
const UNASKED_WITHIN: Duration = Duration::from_secs(10);
