//! How a master takes a slave into service, and lets it go again because it is not what its scan list says.
//!
//! What a master expects is not on the bus. What it does is: it connects, reads identity and sizes, and releases at the first
//! value that it does not like, again and again.

use core::time::Duration;

use cip_core::code::{AttributeId, ClassId, InstanceId, ServiceCode};
use cip_core::message::AllocationChoice;

use super::Clinic;
use super::finding::{Facts, KeyField};
use super::io::exchange_of;
use super::ledger::Sign;
use super::patient::Seen;
use super::rule::{Rule, Severity};
use crate::id::MacId;
use crate::monitor::{Detail, Fields, Kind, Predefined, Reading};

/// What a client has done with a slave since it has connected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Setup {
    client: Option<MacId>,
    /// Requests that the slave has answered.
    answers: u8,
    /// What the last answer has told, if that is something a scan list knows.
    last: Option<Told>,
}

/// A slave that was let go, and what was read last each time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Rejected {
    told: Told,
    first: Seen,
    last: Seen,
    count: u8,
}

/// A value that a master compares with its scan list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Told {
    Identity { field: KeyField, found: u32 },
    Size { which: Predefined, is_produced: bool, found: u16 },
}

impl Told {
    fn of(fields: &Fields<'_>, value: &[u8]) -> Option<Self> {
        if fields.explicit.service != Some(ServiceCode::GET_ATTRIBUTE_SINGLE) {
            return None;
        }
        let &[low, high] = value else { return None };
        let found = u16::from_le_bytes([low, high]);
        let AttributeId(attribute) = fields.explicit.attribute?;
        if fields.explicit.class == Some(ClassId::CONNECTION) {
            let which = Predefined::from_instance(fields.explicit.instance?)
                .filter(|which| *which != Predefined::Explicit)?;
            let is_produced = match attribute {
                PRODUCED_SIZE => true,
                CONSUMED_SIZE => false,
                _ => return None,
            };
            return Some(Self::Size { which, is_produced, found });
        }
        let is_identity = fields.explicit.class == Some(ClassId::IDENTITY)
            && fields.explicit.instance == Some(InstanceId(1));
        let (field, found) = match attribute {
            1 => (KeyField::Vendor, found),
            2 => (KeyField::DeviceType, found),
            3 => (KeyField::ProductCode, found),
            // The major revision comes first.
            4 => (KeyField::Revision, found.swap_bytes()),
            _ => return None,
        };
        is_identity.then_some(Self::Identity { field, found: found.into() })
    }
}

impl<const N: usize> Clinic<'_, N> {
    /// The answers of a slave to whoever sets it up.
    pub(super) fn setup(&mut self, reading: &Reading<'_>) {
        let (Kind::ExplicitResponse | Kind::UnconnectedResponse, Some(slave)) = (reading.kind, reading.src)
        else {
            return;
        };
        let fields = &reading.fields;
        let seen = Seen { n: reading.n, at: reading.at };
        let is_explicit = fields.choice.is_some_and(|choice| choice.contains(AllocationChoice::EXPLICIT));
        let begins = match fields.detail {
            Detail::Opened { .. } => true,
            Detail::Allocated { .. } => is_explicit,
            _ => false,
        };
        if begins {
            self.patient(slave).setup = Some(Setup { client: reading.dst, answers: 0, last: None });
            return;
        }
        let Some(mut setup) = self.patient(slave).setup.filter(|setup| setup.client == reading.dst) else {
            return;
        };
        let is_release = fields.explicit.service == Some(ServiceCode::RELEASE)
            && fields.explicit.class == Some(ClassId::DEVICENET);
        if is_release || matches!(fields.detail, Detail::Close) {
            self.patient(slave).setup = None;
            return self.let_go(slave, setup, seen);
        }
        if fields.explicit.rate.is_some() {
            if fields.explicit.instance == Some(Predefined::Explicit.instance()) {
                // How long these two wait for each other says nothing of the slave.
                setup.last = None;
                self.patient(slave).setup = Some(setup);
                return;
            }
            // It is taken into service.
            let patient = self.patient(slave);
            (patient.setup, patient.rejected) = (None, None);
            self.ledger.end(Rule::SizeMismatch, Some(slave), seen.at);
            return self.ledger.end_where(Rule::KeyMismatch, seen.at, |finding| {
                finding.node == Some(slave) && matches!(finding.facts, Facts::Rejected { .. })
            });
        }
        setup.answers = setup.answers.saturating_add(1);
        setup.last = Told::of(fields, reading.value().unwrap_or_default());
        self.patient(slave).setup = Some(setup);
    }

    fn let_go(&mut self, slave: MacId, setup: Setup, seen: Seen) {
        // There masters look for a device that could take the place of another.
        if slave == MacId::DEFAULT {
            return;
        }
        // A tool asks for a single value and is gone; a master does not, but for one whose first value is wrong.
        let is_master =
            || MacId::all().any(|mac| setup.client.is_some() && self.records.owner(mac) == setup.client);
        let Some(told) = setup.last.filter(|_| setup.answers > 1 || is_master()) else { return };
        let before = self
            .patient(slave)
            .rejected
            .filter(|before| before.told == told && seen.at.saturating_since(before.last.at) <= TRIES_AGAIN);
        let count = before.map_or(0, |before| before.count).saturating_add(1);
        let first = before.map_or(seen, |before| before.first);
        self.patient(slave).rejected = Some(Rejected { told, first, last: seen, count });
        if count < FEWEST {
            return;
        }
        let master = setup.client;
        let (rule, facts) = match told {
            Told::Identity { field, found } => (Rule::KeyMismatch, Facts::Rejected { master, field, found }),
            Told::Size { which, is_produced, found } => {
                let exchange = exchange_of(which);
                (Rule::SizeMismatch, Facts::RejectedSize { master, exchange, is_produced, found })
            }
        };
        // What is expected is known better.
        let is_told = |facts: Facts| matches!(facts, Facts::Identity { .. });
        if self.ledger.open(rule, Some(slave)).is_some_and(|held| is_told(held.facts)) {
            return;
        }
        self.ledger.see(&Sign {
            rule,
            severity: Severity::Error,
            node: Some(slave),
            facts,
            since: first.at,
            at: seen.at,
            frames: [Some(first.n), Some(seen.n)],
        });
    }
}

const PRODUCED_SIZE: u16 = 7;
const CONSUMED_SIZE: u16 = 8;
/// So often, with the same value: once can be a tool, twice one in two hands.
const FEWEST: u8 = 3;
/// The longest time from one attempt of a master to the next.
const TRIES_AGAIN: Duration = Duration::from_secs(60);
