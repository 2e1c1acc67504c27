//! The doctor: what is wrong with a network, since when, why, and what to check next.
//!
//! A [`Doctor`] looks at a bus through a [`Monitor`](crate::monitor::Monitor): each frame that it
//! [observes](SizedDoctor::observe) is read by the monitor and judged by the rules below. Events of the controller go to
//! [`link`](SizedDoctor::link), and time that passes without a frame to [`tick`](SizedDoctor::tick). What is found is a
//! [`Finding`]; [`poll`](SizedDoctor::poll) tells its changes, [`findings`](SizedDoctor::findings) all there are, past ones
//! included.
//!
//! | Rule | Found when | Over when | Code | Severity |
//! |---|---|---|---|---|
//! | [`NotAnswering`](Rule::NotAnswering) | two or more I/O commands unanswered for EPR x 4 (1 s if it is unknown); no change-of-state message for EPR x 4; a node that was heard answers none of three requests for 2.5 s | it answers, is allocated or released, or not asked for 60 s | 72 | error; warning if neither the allocation nor the rate was seen |
//! | [`NotFound`](Rule::NotFound) | a node never heard answers none of three requests for 2.5 s; 5 s, if nobody expects it | it is heard, or not asked for 60 s | 78 | warning; error if it is expected |
//! | [`SlowAnswers`](Rule::SlowAnswers) | from the first unanswered command to the answer 70 % of EPR x 4 | ten answers in time of each kind of I/O, or quiet | | warning |
//! | [`MasterSilent`](Rule::MasterSilent) | the watchdog of a slave that has answered everything must have expired | its slaves are commanded, allocated or released | | error |
//! | [`DuplicateMacId`](Rule::DuplicateMacId) | a duplicate MAC ID check response; two devices check within 1 s, or one within 1 s of another that has the MAC ID | one checks another MAC ID, or the second has got it | 70 | error |
//! | [`WaitingForRecovery`](Rule::WaitingForRecovery) | a device answers Who | it checks a MAC ID | | error |
//! | [`Fault`](Rule::Fault) | a heartbeat with a fault, or a fault in the status of the Identity object | told otherwise, or the node begins anew | | warning; error if unrecoverable, or told still after 10 s |
//! | [`KeyMismatch`](Rule::KeyMismatch) | the identity differs from that [expected](SizedDoctor::expect); a master lets the slave go three times after it has read the same value of its identity | it does not; it is taken into service, or quiet | 73 | error |
//! | [`SizeMismatch`](Rule::SizeMismatch) | a master lets the slave go three times after it has read the same size of an I/O connection | it is taken into service, or quiet | 77 | error |
//! | [`IdentityChanged`](Rule::IdentityChanged) | another vendor, device type, product or serial number than before | quiet | 73 | warning; info if only the serial number differs, or at MAC ID 63 |
//! | [`AllocationRefused`](Rule::AllocationRefused) | an error response to Allocate; "already allocated" only if it stays so for 5 s | an allocation of the same succeeds, or quiet | 83 | error |
//! | [`TwoMasters`](Rule::TwoMasters) | a request of a master on a slave of another; refused with 0x0C/0x01 | the second one gets the slave, or quiet | 83 | warning |
//! | [`ForeignMacId`](Rule::ForeignMacId) | a node that is neither expected nor learned ([`Intrusion`]) | quiet | | error |
//! | [`UnexpectedAllocation`](Rule::UnexpectedAllocation) | a slave is allocated by another master than the expected or learned one | quiet | | error |
//! | [`IdentifierCollision`](Rule::IdentifierCollision) | three I/O responses of a node within 10 s that nobody has asked for; ten, if it was never asked; change-of-state or cyclic messages in a rhythm that one sender cannot have, three to twelve times within 10 s or EPR x 12 | quiet | | error; warning if the allocation was not seen |
//! | [`BusOff`](Rule::BusOff) | a controller is bus-off; a node tells a bus-off counter above 0 | it takes part again; the counter is 0, or the node begins anew | 91 | error; warning |
//! | [`ErrorPassive`](Rule::ErrorPassive) | a controller is error-passive | it is error-active, with or without warning | | warning |
//! | [`ErrorFrames`](Rule::ErrorFrames) | 10 errors within 10 s; up to 16 form errors of one that tries again at once are one | fewer than 5 | | warning; error from 100 |
//! | [`NotAcknowledged`](Rule::NotAcknowledged) | missing acknowledges for 500 ms, ten at least, without a frame in between; the same duplicate MAC ID check request again and again for 500 ms | another frame | 79 | error |
//! | [`ForeignTraffic`](Rule::ForeignTraffic) | a 29-bit, remote or CAN FD frame, an identifier 0x7C0-0x7EB or 0x7F0-0x7FF | quiet | | warning |
//! | [`BusLoad`](Rule::BusLoad) | more than 70 % of the last second, by the exact bits of the frames, unless nobody acknowledges | below 65 % | | warning |
//! | [`Overrun`](Rule::Overrun) | the controller has lost frames | quiet | 74 | warning |
//! | [`WrongLength`](Rule::WrongLength) | I/O data of another length than the connection size | quiet | 85 | warning |
//! | [`FragmentSequence`](Rule::FragmentSequence) | fragments of I/O out of sequence | quiet | 82 | warning |
//! | [`Restarted`](Rule::Restarted) | a node on line checks its MAC ID anew | quiet | | info; warning the third time |
//! | [`Left`](Rule::Left) | Device Shutdown | it is heard again | | info |
//!
//! *Quiet* means that it has not happened for 60 s. What is there again within 10 s is the same finding. EPR x 4 is the time
//! after which the peer gives up (attributes 9 and 18 of the Connection object). Every number is in [`DoctorConfig`], or in
//! the file of its rule. The codes are those of scanner displays, see [`ScannerStatus`](crate::master::ScannerStatus).
//!
//! ```
//! use core::time::Duration;
//! use devicenet_core::Identifier;
//! use devicenet_core::doctor::{ChangeKind, Doctor, DoctorConfig, Rule};
//! use devicenet_core::monitor::{Monitor, MonitorConfig};
//! use link_core::Instant;
//!
//! let mut monitor = Monitor::new(MonitorConfig::default());
//! let mut doctor = Doctor::new(DoctorConfig::default());
//! let mut show = |millis, n, id, data: &[u8]| {
//!     let frame = Identifier::new(id).and_then(|id| id.frame(data)).unwrap();
//!     doctor.observe(&mut monitor, Instant::from_millis(millis), n, &frame);
//! };
//! show(0, 1, 0x457, &[0x00, 0x34, 0x12, 0x45, 0x23, 0, 0]); // somebody wants MAC ID 10,
//! show(1, 2, 0x457, &[0x80, 0x34, 0x12, 0x99, 0x23, 0, 0]); // which another device has
//! let change = doctor.poll().unwrap();
//! assert_eq!((change.kind, change.finding.rule), (ChangeKind::Begins, Rule::DuplicateMacId));
//! assert_eq!(
//!     change.finding.to_string(),
//!     "duplicate MAC ID 10: vendor 4660, serial 0x00002399 has it, vendor 4660, serial 0x00002345 wants it",
//! );
//! assert_eq!(change.finding.evidence.frames(), [1, 2]);
//! ```

mod access;
mod bus;
mod config;
mod errors;
mod finding;
mod io;
#[cfg(feature = "serde")]
mod json;
mod ledger;
mod ownership;
mod patient;
mod rhythm;
mod rule;
mod setup;
#[cfg(test)]
mod tests;
mod text;
mod window;

pub use config::{DoctorConfig, ExpectedNode, Intrusion};
pub use errors::ErrorCounts;
pub use finding::{Change, ChangeKind, Evidence, Exchange, Facts, Finding, Foreign, KeyField};
pub use ledger::Forgotten;
pub use rule::{Rule, Severity};
pub use text::Advice;

use link_core::{BitRate, Frame, Instant, LinkEvent};

use bus::{Bus, LOOK_EVERY};
use ledger::{Ledger, Sign};
use patient::{Patient, Seen};

use crate::id::{Identifier, MacId};
use crate::monitor::{Kind, Reading, Records, SizedMonitor};

/// A doctor that keeps 64 findings.
pub type Doctor = SizedDoctor<64>;

/// Health rules over what a monitor reads. `N` is the number of findings that are kept: when they are full, the oldest that
/// is over makes room; what does not fit is [counted](Self::forgotten).
///
/// Work is bounded: a frame is judged by itself, and at most every 10 ms each of the 64 nodes is looked at.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct SizedDoctor<const N: usize> {
    config: DoctorConfig,
    ledger: Ledger<N>,
    patients: [Patient; MacId::COUNT],
    bus: Bus,
    /// The latest moment that was seen.
    now: Instant,
    /// When the first frame was.
    begin: Option<Instant>,
    look_at: Instant,
}

/// The doctor at work: what it knows, and what the monitor knows.
struct Clinic<'a, const N: usize> {
    config: &'a DoctorConfig,
    ledger: &'a mut Ledger<N>,
    patients: &'a mut [Patient; MacId::COUNT],
    records: Records<'a>,
    /// When the first frame was.
    begin: Instant,
    /// When the last error on the bus was.
    last_error: Option<Instant>,
}

impl<const N: usize> SizedDoctor<N> {
    /// A doctor that has seen nothing.
    #[must_use]
    pub const fn new(config: DoctorConfig) -> Self {
        Self {
            config,
            ledger: Ledger::new(),
            patients: [const { Patient::NEW }; MacId::COUNT],
            bus: Bus::new(),
            now: Instant::ZERO,
            begin: None,
            look_at: Instant::ZERO,
        }
    }

    /// The thresholds.
    #[must_use]
    pub const fn config(&self) -> &DoctorConfig {
        &self.config
    }

    /// The bit rate of the bus is another one than was thought; with `None` its load is not judged any more.
    pub fn set_bit_rate(&mut self, bit_rate: Option<BitRate>) {
        self.config.bit_rate = bit_rate;
        self.bus.measure_anew(&mut self.ledger, self.now);
    }

    /// Tells what is known of a node beforehand. A node that is expected belongs to the network.
    pub fn expect(&mut self, mac: MacId, node: ExpectedNode) {
        patient(&mut self.patients, mac).expected = Some(node);
    }

    /// Reads frame number `n`, which was on the bus at `at`, with the monitor of this bus, and judges it.
    pub fn observe<'m, const M: usize, const B: usize>(
        &mut self,
        monitor: &'m mut SizedMonitor<M, B>,
        at: Instant,
        n: u64,
        frame: &Frame,
    ) -> Reading<'m> {
        // What time alone brings comes before the frame, which may be what puts an end to it.
        self.now = self.now.max(at.preceding());
        self.look(monitor.records());
        let (reading, records) = monitor.observe_with_records(at, n, frame);
        self.examine(&reading, records);
        reading
    }

    /// Time has passed without a frame. Early or twice, it does nothing.
    pub fn tick<const M: usize, const B: usize>(&mut self, monitor: &SizedMonitor<M, B>, now: Instant) {
        self.now = self.now.max(now);
        self.look(monitor.records());
    }

    /// The controller that listens tells something; `n` is its number, if it is an entry of a recording.
    pub fn link(&mut self, at: Instant, n: Option<u64>, event: LinkEvent) {
        self.link_of(None, at, n, event);
    }

    /// The controller of a node tells something, where that can be known.
    pub fn link_of(&mut self, node: Option<MacId>, at: Instant, n: Option<u64>, event: LinkEvent) {
        self.now = self.now.max(at);
        let was_blind = self.bus.is_blind;
        self.bus.link(&self.config, &mut self.ledger, node, self.now, n, event);
        if node.is_none() && matches!(event, LinkEvent::Overrun { .. }) {
            // Their questions may be among what was lost.
            self.patients.iter_mut().for_each(|patient| patient.unasked = None);
        }
        self.sees_again(was_blind);
    }

    /// Frame number `n` was one of CAN FD, which no monitor reads.
    pub fn can_fd(&mut self, at: Instant, n: u64) {
        self.now = self.now.max(at);
        bus::foreign(&mut self.ledger, Foreign::CanFd, Seen { n, at: self.now });
    }

    /// Everything found, past and present, the oldest first.
    pub fn findings(&self) -> impl DoubleEndedIterator<Item = &Finding> {
        self.ledger.findings()
    }

    /// The next change of a finding: poll until there is none.
    pub fn poll(&mut self) -> Option<Change> {
        self.ledger.poll()
    }

    /// What did not fit.
    #[must_use]
    pub const fn forgotten(&self) -> Forgotten {
        self.ledger.forgotten
    }

    fn examine(&mut self, reading: &Reading<'_>, records: Records<'_>) {
        self.now = self.now.max(reading.at);
        let clamped;
        let reading = if reading.at < self.now {
            // Time does not run backwards, not even in a recording.
            clamped = Reading { at: self.now, ..*reading };
            &clamped
        } else {
            reading
        };
        self.begin.get_or_insert(self.now);
        let was_blind = self.bus.is_blind;
        let seen = Seen { n: reading.n, at: self.now };
        self.bus.frame(&self.config, &mut self.ledger, seen, &reading.frame);
        self.sees_again(was_blind);
        let mut clinic = self.clinic(records);
        clinic.presence(reading);
        match Identifier::of_frame(&reading.frame) {
            Some(identifier) if reading.kind.is_io() => clinic.io(reading, identifier),
            _ => clinic.access(reading),
        }
        clinic.ownership(reading);
        clinic.setup(reading);
        clinic.identity(reading);
        let foreign = match reading.kind {
            Kind::Foreign if reading.frame.is_remote() => Some(Foreign::RemoteFrame),
            Kind::Foreign => Some(Foreign::ExtendedIdentifier),
            Kind::Invalid => Some(Foreign::InvalidIdentifier),
            Kind::Reserved => Some(Foreign::ReservedIdentifier),
            _ => None,
        };
        if let Some(foreign) = foreign {
            bus::foreign(&mut self.ledger, foreign, Seen { n: reading.n, at: self.now });
        }
    }

    /// What was said while nothing was heard is not known.
    fn sees_again(&mut self, was_blind: bool) {
        if was_blind && !self.bus.is_blind {
            self.patients.iter_mut().for_each(Patient::wait_anew);
        }
    }

    /// What time brings.
    fn look(&mut self, records: Records<'_>) {
        let now = self.now;
        if now < self.look_at {
            return;
        }
        self.look_at = now + LOOK_EVERY;
        self.bus.pass(&self.config, &mut self.ledger, now);
        self.ledger.age(now, self.config.quiet_after, self.config.stuck_after);
        if self.bus.is_blind {
            return;
        }
        let deaf_until = self.bus.deaf_until(now);
        let mut clinic = self.clinic(records);
        clinic.look_at_io(now);
        clinic.look_at_masters(now, deaf_until);
        clinic.look_at_presence(now);
        clinic.look_at_ownership(now);
    }

    fn clinic<'a>(&'a mut self, records: Records<'a>) -> Clinic<'a, N> {
        let Self { config, ledger, patients, bus, begin, now, .. } = self;
        Clinic { config, ledger, patients, records, begin: begin.unwrap_or(*now), last_error: bus.last_error }
    }
}

impl<const N: usize> Clinic<'_, N> {
    fn patient(&mut self, mac: MacId) -> &mut Patient {
        patient(self.patients, mac)
    }

    /// Something that a single frame shows.
    fn event(&mut self, rule: Rule, severity: Severity, node: Option<MacId>, facts: Facts, seen: Seen) {
        let (since, at, frames) = (seen.at, seen.at, [Some(seen.n), None]);
        self.ledger.see(&Sign { rule, severity, node, facts, since, at, frames });
    }

    /// Something that lasts, and is seen again at every look.
    fn begin_once(&mut self, sign: &Sign) {
        if self.ledger.open(sign.rule, sign.node).is_none() {
            self.ledger.see(sign);
        }
    }
}

impl<const N: usize> Default for SizedDoctor<N> {
    fn default() -> Self {
        Self::new(DoctorConfig::default())
    }
}

fn patient(patients: &mut [Patient; MacId::COUNT], mac: MacId) -> &mut Patient {
    let [zero, others @ ..] = patients;
    mac.index().checked_sub(1).and_then(|index| others.get_mut(index)).unwrap_or(zero)
}
