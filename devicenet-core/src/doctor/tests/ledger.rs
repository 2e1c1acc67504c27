//! What is kept, what makes room, and what is told.

use std::vec;

use link_core::{BusErrorKind, LinkEvent};

use super::*;

/// A doctor with room for two findings, told of nodes that are error-passive or bus-off.
fn told(events: &[(u8, LinkEvent)]) -> SizedDoctor<2> {
    let mut doctor = SizedDoctor::<2>::new(DoctorConfig::default());
    for (index, &(node, event)) in (0..).zip(events) {
        doctor.link_of(Some(mac(node)), Instant::from_millis(index), None, event);
    }
    doctor
}

fn ids(doctor: &SizedDoctor<2>) -> Vec<u32> {
    doctor.findings().map(|finding| finding.id).collect()
}

#[test]
fn what_is_over_makes_room_and_is_counted() {
    use LinkEvent::{BusOff, ErrorPassive, Up};
    let doctor = told(&[(1, BusOff), (2, BusOff), (2, Up), (3, BusOff)]);
    assert_eq!(ids(&doctor), [1, 3]);
    // Its beginning and its end were never told.
    assert_eq!(doctor.forgotten(), Forgotten { past: 1, present: 0, changes: 2 });
    // Nothing is over: the worse finding stays.
    let doctor = told(&[(1, ErrorPassive), (2, BusOff), (3, BusOff), (4, ErrorPassive)]);
    assert_eq!(ids(&doctor), [2, 3]);
    assert_eq!(doctor.forgotten(), Forgotten { past: 0, present: 2, changes: 1 });
}

/// It was seen a hundred times, and is one finding that there was no room for.
#[test]
fn what_lasts_and_finds_no_room_is_counted_once() {
    use LinkEvent::{BusOff, Up};
    let mut events = vec![(1, BusOff), (2, BusOff)];
    events.extend([(3, BusOff); 100]);
    events.push((4, BusOff));
    assert_eq!(told(&events).forgotten(), Forgotten { past: 0, present: 2, changes: 0 });
    // There is room again.
    events.extend([(1, Up), (3, BusOff)]);
    assert_eq!(ids(&told(&events)), [2, 3]);
}

#[test]
fn changes_are_told_once_and_the_beginning_before_the_end() {
    use LinkEvent::{BusOff, Up};
    let mut doctor = told(&[(1, BusOff), (1, Up), (2, BusOff)]);
    let news: Vec<_> =
        core::iter::from_fn(|| doctor.poll()).map(|news| (news.kind, news.finding.id)).collect();
    assert_eq!(news, [(ChangeKind::Begins, 1), (ChangeKind::Ends, 1), (ChangeKind::Begins, 2)]);
    assert_eq!(doctor.poll(), None);
}

/// So soon it was never away; later it is a finding of its own.
#[test]
fn a_relapse_is_the_same_finding() {
    let mut ward = Ward::new();
    ward.link(LinkEvent::BusOff).wait(5).link(LinkEvent::Up).wait(9_000).link(LinkEvent::BusOff);
    let found = ward.only(Rule::BusOff);
    assert_eq!((found.count, found.until), (2, None));
    ward.wait(5).link(LinkEvent::Up).wait(11_000).link(LinkEvent::BusOff);
    assert_eq!(ward.of(Rule::BusOff).len(), 2);
}

#[test]
fn what_went_before_is_the_first_cause() {
    let mut ward = Ward::with_slave();
    ward.poll().answer();
    ward.check(10, 0, 9).check(10, 0x80, 1);
    for _ in 0..6 {
        ward.poll().wait(99);
    }
    let found = *ward.doctor.findings().last().unwrap();
    assert_eq!((found.rule, found.first_cause), (Rule::NotAnswering, Some(Rule::DuplicateMacId)));
    assert!(found.to_string().ends_with("; first cause: duplicate MAC ID"), "{found}");
}

/// Errors end with the last of them, not when ten seconds have shown that it was the last.
#[test]
fn errors_long_before_a_silence_are_not_its_cause() {
    for (pause, expected) in [(4_000, Some(Rule::ErrorFrames)), (6_000, None), (11_000, None), (14_000, None)]
    {
        let mut ward = Ward::with_slave();
        ward.poll().answer();
        errors(&mut ward);
        for _ in 0..pause / 100 {
            ward.poll().answer().wait(98);
        }
        assert_eq!(cause_of_silence(&mut ward), expected, "{pause} ms after the errors");
    }
}

/// A slave without power leaves its master alone, and frames that nobody acknowledges are errors.
#[test]
fn errors_after_a_silence_are_not_its_cause() {
    // With errors before that were a finding, or were not: one, when the master was switched on.
    for (before, pause) in [(0, 0), (1, 3_600), (10, 7_000), (10, 12_000)] {
        let mut ward = Ward::with_slave();
        ward.poll().answer();
        for _ in 0..before {
            ward.link(LinkEvent::BusError(BusErrorKind::Stuff)).wait(1);
        }
        for _ in 0..pause / 100 {
            ward.poll().answer().wait(98);
        }
        ward.poll().wait(50);
        errors(&mut ward);
        assert_eq!(cause_of_silence(&mut ward), None, "{before} errors, {pause} ms before");
    }
}

/// Ten are a finding.
fn errors(ward: &mut Ward) {
    for _ in 0..10 {
        ward.link(LinkEvent::BusError(BusErrorKind::Stuff)).wait(1);
    }
}

fn cause_of_silence(ward: &mut Ward) -> Option<Rule> {
    for _ in 0..6 {
        ward.poll().wait(99);
    }
    let silence = ward.doctor.findings().find(|finding| finding.rule == Rule::NotAnswering);
    silence.expect("a silence").first_cause
}

/// The time of day and a clock that steps back make no difference, and a tick too many does nothing.
#[test]
fn a_clock_that_steps_back_is_the_last_moment() {
    let mut ward = Ward::with_slave();
    ward.poll().answer();
    let before = ward.doctor.clone();
    ward.doctor.tick(&ward.monitor, Instant::ZERO);
    assert_eq!(*ward.doctor, *before);
    ward.doctor.observe(
        &mut ward.monitor,
        Instant::ZERO,
        99,
        &Identifier::poll_command(mac(10)).frame(&[1]).unwrap(),
    );
    ward.wait(300);
    ward.is_healthy();
}
