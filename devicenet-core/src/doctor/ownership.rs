//! Whose a node is, and whether it belongs here: identity, allocation, intrusion.

use core::time::Duration;

use cip_core::code::{AdditionalCode, ClassId, GeneralStatus, ServiceCode};
use cip_core::message::AllocationChoice;
use link_core::Instant;

use super::Clinic;
use super::config::{ExpectedNode, Intrusion};
use super::finding::{Facts, KeyField};
use super::ledger::Sign;
use super::patient::{Refused, Seen};
use super::rule::{Rule, Severity};
use crate::id::MacId;
use crate::monitor::{Detail, Kind, Problem, Reading, Told};

impl<const N: usize> Clinic<'_, N> {
    /// The devices behind the MAC IDs.
    pub(super) fn identity(&mut self, reading: &Reading<'_>) {
        let Some(mac) = reading.src else { return };
        let seen = Seen { n: reading.n, at: reading.at };
        self.intrusion(mac, seen);
        let is_told = match reading.kind {
            Kind::DupMacRequest | Kind::DupMacResponse => true,
            _ => {
                let message = reading.message.as_ref();
                let fields = message.map_or(&reading.fields, |message| &message.fields);
                reading.kind != Kind::ExplicitRequest && fields.explicit.class == Some(ClassId::IDENTITY)
            }
        };
        if !is_told {
            return;
        }
        let told = self.records.told(mac);
        let before = self.patient(mac).told;
        if told == before {
            return;
        }
        self.patient(mac).told = merged(before, told);
        let is_disputed = self.ledger.open(Rule::DuplicateMacId, Some(mac)).is_some();
        if let Some((field, expected, found)) = difference(before, told).filter(|_| !is_disputed) {
            // A new device out of the box has MAC ID 63, and a replacement is told by its serial number alone.
            let is_usual = mac == MacId::DEFAULT || field == KeyField::SerialNumber;
            let severity = if is_usual { Severity::Info } else { Severity::Warning };
            let facts = Facts::Identity { field, expected, found };
            self.event(Rule::IdentityChanged, severity, Some(mac), facts, seen);
        }
        if let Some(expected) = self.patient(mac).expected {
            match mismatch(&expected, told) {
                Some((field, expected, found)) => {
                    let facts = Facts::Identity { field, expected, found };
                    self.event(Rule::KeyMismatch, Severity::Error, Some(mac), facts, seen);
                }
                None => self.ledger.end_where(Rule::KeyMismatch, seen.at, |finding| {
                    finding.node == Some(mac) && matches!(finding.facts, Facts::Identity { .. })
                }),
            }
        }
    }

    /// Allocations, granted and refused.
    pub(super) fn ownership(&mut self, reading: &Reading<'_>) {
        let seen = Seen { n: reading.n, at: reading.at };
        match (reading.problem, reading.fields.detail, reading.src) {
            (Some(Problem::NotOwner { owner }), _, other) => {
                let facts = Facts::Masters { owner: Some(owner), other };
                self.event(Rule::TwoMasters, Severity::Warning, reading.dst, facts, seen);
            }
            (Some(Problem::Refused { status, additional }), _, Some(slave))
                if reading.fields.explicit.requested == Some(ServiceCode::ALLOCATE) =>
            {
                let facts =
                    Facts::Refusal { master: reading.dst, choice: reading.fields.choice, status, additional };
                self.refused(slave, facts, seen);
            }
            (_, Detail::Allocated { .. }, Some(slave)) if reading.kind != Kind::UnconnectedRequest => {
                self.allocated(slave, reading.dst, reading.fields.choice, seen);
            }
            _ if is_release(reading) => {
                if let Some(slave) = reading.src {
                    let owner = self.records.owner(slave);
                    let patient = self.patient(slave);
                    patient.begin_anew();
                    (patient.refused, patient.owner) = (None, owner);
                    self.ledger.end(Rule::NotAnswering, Some(slave), seen.at);
                }
            }
            _ => {}
        }
    }

    fn refused(&mut self, slave: MacId, facts: Facts, seen: Seen) {
        let Facts::Refusal { master, status, additional, .. } = facts else { return };
        let is_owned = status == GeneralStatus::OBJECT_STATE_CONFLICT
            && additional == AdditionalCode::ALLOCATION_CONFLICT;
        if is_owned {
            let owner = self.records.owner(slave).or(self.patient(slave).owner);
            let facts = Facts::Masters { owner: owner.filter(|&owner| Some(owner) != master), other: master };
            return self.event(Rule::TwoMasters, Severity::Warning, Some(slave), facts, seen);
        }
        let sign = Sign {
            rule: Rule::AllocationRefused,
            severity: Severity::Error,
            node: Some(slave),
            facts,
            since: seen.at,
            at: seen.at,
            frames: [Some(seen.n), None],
        };
        // What a master left behind before its restart, it releases now, and asks again.
        if status == GeneralStatus::ALREADY_IN_REQUESTED_STATE {
            self.patient(slave).refused.get_or_insert(Refused { seen, sign });
        } else {
            self.ledger.see(&sign);
        }
    }

    fn allocated(
        &mut self,
        slave: MacId,
        master: Option<MacId>,
        granted: Option<AllocationChoice>,
        seen: Seen,
    ) {
        let owner = self.records.owner(slave).or(master);
        let learns = self.is_learning(seen.at);
        let is_watched = self.config.intrusion != Intrusion::Allowed && !learns;
        let patient = self.patient(slave);
        let learned = patient.learned_owner;
        let wanted = patient.expected.map_or(learned, |expected| expected.master);
        patient.begin_anew();
        patient.refused = None;
        patient.owner = owner;
        if learns {
            patient.learned_owner = owner;
        }
        let is_wrong = is_watched && (wanted.is_some() && wanted != owner);
        // A slave can grant the explicit connection, and refuse the I/O that is asked for next, each time anew.
        self.ledger.end_where(Rule::AllocationRefused, seen.at, |finding| {
            let Facts::Refusal { choice, .. } = finding.facts else { return false };
            finding.node == Some(slave)
                && choice.is_none_or(|choice| granted.is_some_and(|granted| granted.contains(choice)))
        });
        self.ledger.end(Rule::NotAnswering, Some(slave), seen.at);
        self.ledger.end_where(Rule::TwoMasters, seen.at, |finding| {
            finding.node == Some(slave)
                && matches!(finding.facts, Facts::Masters { other, .. } if other == owner)
        });
        if is_wrong {
            let facts = Facts::Masters { owner: wanted, other: owner };
            self.event(Rule::UnexpectedAllocation, Severity::Error, Some(slave), facts, seen);
        }
    }

    /// Takes note of the master that commands a slave.
    pub(super) fn is_served(&mut self, slave: MacId, at: Instant) {
        let owner = self.records.owner(slave);
        let learns = self.is_learning(at);
        let patient = self.patient(slave);
        patient.owner = owner.or(patient.owner);
        if learns {
            patient.learned_owner = patient.owner;
        }
    }

    fn intrusion(&mut self, mac: MacId, seen: Seen) {
        if self.config.intrusion == Intrusion::Allowed {
            return;
        }
        let learns = self.is_learning(seen.at);
        let patient = self.patient(mac);
        patient.is_learned |= learns;
        if !patient.is_learned && patient.expected.is_none() {
            self.event(Rule::ForeignMacId, Severity::Error, Some(mac), Facts::None, seen);
        }
    }

    fn is_learning(&self, at: Instant) -> bool {
        match self.config.intrusion {
            Intrusion::Learned(span) => at.saturating_since(self.begin) < span,
            Intrusion::Expected | Intrusion::Allowed => false,
        }
    }

    /// Refusals that were not part of an orderly start.
    pub(super) fn look_at_ownership(&mut self, now: Instant) {
        for mac in MacId::all() {
            let refused = &mut self.patient(mac).refused;
            if let Some(Refused { seen, sign }) = *refused
                && now.saturating_since(seen.at) >= ORDERLY
            {
                *refused = None;
                self.ledger.see(&Sign { at: now, ..sign });
            }
        }
    }
}

fn is_release(reading: &Reading<'_>) -> bool {
    matches!(reading.kind, Kind::ExplicitResponse | Kind::UnconnectedResponse)
        && reading.fields.explicit.service == Some(ServiceCode::RELEASE)
        && reading.fields.explicit.class == Some(ClassId::DEVICENET)
}

/// What is known now, and what was known before where now nothing is.
fn merged(before: Told, now: Told) -> Told {
    Told {
        vendor: now.vendor.or(before.vendor),
        device_type: now.device_type.or(before.device_type),
        product: now.product.or(before.product),
        revision: now.revision.or(before.revision),
        serial: now.serial.or(before.serial),
    }
}

/// The first part of an identity that is another one than it was; the revision can be updated.
fn difference(before: Told, now: Told) -> Option<(KeyField, u32, u32)> {
    let differs = |field, before: Option<u32>, now: Option<u32>| {
        let (before, now) = (before?, now?);
        (before != now).then_some((field, before, now))
    };
    let wide = |value: Option<u16>| value.map(u32::from);
    differs(KeyField::Vendor, wide(before.vendor.map(|id| id.0)), wide(now.vendor.map(|id| id.0)))
        .or_else(|| {
            let (before, now) = (before.device_type.map(|id| id.0), now.device_type.map(|id| id.0));
            differs(KeyField::DeviceType, wide(before), wide(now))
        })
        .or_else(|| differs(KeyField::ProductCode, wide(before.product), wide(now.product)))
        .or_else(|| differs(KeyField::SerialNumber, before.serial, now.serial))
}

/// The first part of an identity that does not match the key.
fn mismatch(expected: &ExpectedNode, told: Told) -> Option<(KeyField, u32, u32)> {
    let key = &expected.key;
    let wanted = Told {
        vendor: key.vendor,
        device_type: key.device_type,
        product: key.product_code,
        revision: None,
        serial: expected.serial,
    };
    difference(wanted, told).or_else(|| {
        let (revision, (major, minor)) = (key.revision?, told.revision?);
        let is_good = major == revision.major && minor >= revision.minor;
        let number = |major: u8, minor: u8| u32::from(u16::from_be_bytes([major, minor]));
        let wanted = number(revision.major, revision.minor);
        (!is_good).then(|| (KeyField::Revision, wanted, number(major, minor)))
    })
}

/// A master that finds what it left behind has released it by then, and is served.
const ORDERLY: Duration = Duration::from_secs(5);
