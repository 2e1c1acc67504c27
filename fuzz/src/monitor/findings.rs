//! A doctor beside the decoder: its findings stay within bounds, come and go in order, and name frames that there were.

use std::collections::{BTreeMap, HashMap};

use core::time::Duration;

use devicenet_core::MacId;
use devicenet_core::doctor::{
    ChangeKind, Doctor, DoctorConfig, ExpectedNode, Finding, Intrusion, SizedDoctor,
};
use devicenet_core::monitor::{Monitor, Reading};
use link_core::{BitRate, BusErrorKind, Frame, Instant, LinkEvent};

/// A doctor, one with room for two findings, and what the first has told.
pub(super) struct Practice {
    doctor: Box<Doctor>,
    small: Box<SizedDoctor<2>>,
    told: BTreeMap<u32, Vec<ChangeKind>>,
}

impl Practice {
    pub(super) fn new(options: u8) -> Self {
        let mut config = DoctorConfig::default();
        config.bit_rate = Some(BitRate::K125);
        config.intrusion = match options >> 2 & 3 {
            0 | 1 => Intrusion::Allowed,
            2 => Intrusion::Expected,
            _ => Intrusion::Learned(Duration::from_secs(1)),
        };
        let (mut doctor, mut small) = (Box::new(Doctor::new(config)), Box::new(SizedDoctor::new(config)));
        for mac in [MacId::MIN, MacId::MAX] {
            let expected = ExpectedNode { master: Some(MacId::MIN), ..ExpectedNode::default() };
            doctor.expect(mac, expected);
            small.expect(mac, expected);
        }
        Self { doctor, small, told: BTreeMap::new() }
    }

    /// The frame, read and judged; a remote frame is an error of the bus as well.
    pub(super) fn observe<'m>(
        &mut self,
        monitor: &'m mut Monitor,
        at: Instant,
        n: u64,
        frame: &Frame,
    ) -> Reading<'m> {
        self.small.tick(monitor, at);
        if frame.is_remote() {
            let kind = if frame.dlc() == 0 { BusErrorKind::Ack } else { BusErrorKind::Form };
            for event in [LinkEvent::BusError(kind), LinkEvent::ErrorPassive] {
                self.doctor.link(at, Some(n), event);
                self.small.link(at, Some(n), event);
            }
        }
        let reading = self.doctor.observe(monitor, at, n, frame);
        self.listen();
        reading
    }

    /// What was told is what there is.
    pub(super) fn finish(&mut self, monitor: &Monitor, begin: Instant, frames: &HashMap<u64, Duration>) {
        let end = begin + frames.values().max().copied().unwrap_or_default();
        self.doctor.tick(monitor, end);
        let before = self.doctor.clone();
        self.doctor.tick(monitor, begin);
        assert_eq!(before, self.doctor, "a tick too late changes nothing");
        self.listen();
        let ids: Vec<u32> = self.doctor.findings().map(|finding| finding.id).collect();
        assert!(ids.is_sorted_by(|one, next| one < next), "the oldest first, and each once: {ids:?}");
        for finding in self.doctor.findings() {
            check(finding, end, frames);
            let told = self.told.get(&finding.id).map(Vec::as_slice).unwrap_or_default();
            assert_eq!(told.first(), Some(&ChangeKind::Begins), "{finding}");
            assert_eq!(told.last() == Some(&ChangeKind::Ends), finding.is_over(), "{finding}");
        }
        assert!(self.small.findings().count() <= 2);
        let forgotten = self.small.forgotten();
        assert!(self.small.findings().count() == 2 || forgotten.past + forgotten.present == 0);
    }

    /// The time of day makes no difference.
    pub(super) fn finds_the_same(&self, other: &Self) {
        let words = |practice: &Self| -> Vec<_> {
            practice
                .doctor
                .findings()
                .map(|found| (found.to_string(), found.evidence, found.is_over()))
                .collect()
        };
        assert_eq!(words(self), words(other));
    }

    fn listen(&mut self) {
        while let Some(change) = self.doctor.poll() {
            let told = self.told.entry(change.finding.id).or_default();
            assert_ne!(
                told.last(),
                Some(&change.kind).filter(|kind| **kind != ChangeKind::Escalates),
                "{change}"
            );
            told.push(change.kind);
        }
        assert_eq!(self.doctor.poll(), None);
    }
}

fn check(finding: &Finding, end: Instant, frames: &HashMap<u64, Duration>) {
    assert!(finding.since <= finding.last && finding.last <= end, "{finding:?}");
    assert!(finding.until.is_none_or(|until| finding.last <= until && until <= end), "{finding:?}");
    assert!(finding.count > 0, "{finding:?}");
    let evidence = finding.evidence.frames();
    assert!(evidence.iter().all(|n| frames.contains_key(n)), "{finding:?} names a frame that there was not");
    for text in [finding.to_string(), finding.advice().to_string()] {
        assert!(
            !text.is_empty() && !text.contains(char::is_control) && !text.contains(['{', '}']),
            "{text:?}"
        );
    }
    let json = serde_json::to_value(finding).expect("a finding always serialises");
    assert_eq!(json["rule"], finding.rule.code());
    assert_eq!(json["text"], finding.to_string());
}
