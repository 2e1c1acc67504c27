//! Load, errors, foreign traffic, and the controller that listens.

use link_core::{BitRate, BusErrorKind, ExtendedId};

use super::*;

/// One-byte frames of 55 to 65 bits, so many in a hundred milliseconds, for three seconds at 125 kbit/s.
fn load(frames: u64) -> Ward {
    let mut ward = Ward::with(DoctorConfig { bit_rate: Some(BitRate::K125), ..DoctorConfig::default() });
    for tenth in 0..30_u64 {
        for frame in 0..frames {
            let at = Instant::from_micros(tenth * 100_000 + frame * 100_000 / frames);
            let frame = Identifier::change_of_state(mac(10)).frame(&[0x55]).unwrap();
            ward.doctor.observe(&mut ward.monitor, at, tenth * 1_000 + frame.raw_id() as u64, &frame);
        }
    }
    ward
}

#[test]
fn a_bus_that_is_nearly_full() {
    // 12 500 bits fit into a tenth of a second; one frame has 58 with the intermission.
    let bits = Identifier::change_of_state(mac(10)).frame(&[0x55]).unwrap().bit_len() + 3;
    let at_limit = 8_750 / u64::from(bits);
    load(at_limit - 3).is_healthy();
    let found = load(at_limit + 3).only(Rule::BusLoad);
    assert!(found.to_string().starts_with("bus load up to 70.9"), "{found}");
    assert!(!found.evidence.frames().is_empty(), "a frame of the time when it was so");
    // More than there is room for: that is not its bit rate.
    load(400).is_healthy();
}

#[test]
fn a_bit_rate_that_turns_out_to_be_another_one() {
    let mut ward = load(160);
    assert!(!ward.only(Rule::BusLoad).is_over());
    ward.doctor.set_bit_rate(None);
    assert!(ward.only(Rule::BusLoad).is_over());
    for _ in 0..2_000 {
        ward.poll().wait(1);
    }
    assert!(ward.only(Rule::BusLoad).is_over(), "it is not judged any more");
}

#[test]
fn errors_now_and_then_are_normal_and_many_are_not() {
    let mut ward = Ward::new();
    for _ in 0..20 {
        ward.link(LinkEvent::BusError(BusErrorKind::Stuff)).wait(2_000);
    }
    ward.is_healthy();
    for _ in 0..20 {
        ward.link(LinkEvent::BusError(BusErrorKind::Stuff)).wait(100);
    }
    assert_eq!(ward.only(Rule::ErrorFrames).severity, Severity::Warning);
    for _ in 0..100 {
        ward.link(LinkEvent::BusError(BusErrorKind::Form));
    }
    let found = ward.only(Rule::ErrorFrames);
    assert_eq!(found.severity, Severity::Error);
    assert_eq!(
        found.to_string(),
        "frames are destroyed: up to 109 errors in 10 s: 85 form errors, 24 stuff errors"
    );
    let Facts::Errors { kinds, .. } = found.facts else { panic!("{found:?}") };
    assert_eq!(kinds.iter().collect::<Vec<_>>(), [(BusErrorKind::Form, 85), (BusErrorKind::Stuff, 24)]);
    ward.wait(12_000);
    assert!(ward.only(Rule::ErrorFrames).is_over());
}

#[test]
fn nobody_acknowledges() {
    let mut ward = Ward::new();
    let alone = |ward: &mut Ward| {
        for _ in 0..49 {
            ward.link(LinkEvent::BusError(BusErrorKind::Ack)).wait(10);
        }
    };
    // Switched on first.
    alone(&mut ward);
    ward.check(10, 0, 1);
    alone(&mut ward);
    ward.is_healthy();
    ward.wait(10).link(LinkEvent::BusError(BusErrorKind::Ack));
    assert_eq!(ward.only(Rule::NotAcknowledged).scanner_status().map(|status| status.0), Some(79));
    ward.check(10, 0, 1);
    assert!(ward.only(Rule::NotAcknowledged).is_over());
}

/// An error-passive sender that nobody acknowledges is heard by who listens, and fills the bus without being busy.
#[test]
fn a_check_without_an_acknowledge_is_heard_again_and_again() {
    let config = DoctorConfig { bit_rate: Some(link_core::BitRate::K125), ..DoctorConfig::default() };
    let mut ward = Ward::with(config);
    for _ in 0..500 {
        ward.check(10, 0, 1);
    }
    ward.is_healthy();
    for _ in 0..2_000 {
        ward.check(10, 0, 1);
    }
    assert_eq!(ward.only(Rule::NotAcknowledged).since, Instant::from_millis(2));
    ward.check(11, 0, 2);
    assert!(ward.only(Rule::NotAcknowledged).is_over());
}

/// To one that only listens, sixteen form errors in a row are a sender that nobody acknowledges. More are not.
#[test]
fn a_lone_sender_is_no_disturbance() {
    for (errors, frames_between, expected) in
        [(16, false, &[][..]), (27, false, &[Rule::ErrorFrames]), (16, true, &[Rule::ErrorFrames])]
    {
        let mut ward = Ward::new();
        for _ in 0..errors {
            ward.link(LinkEvent::BusError(BusErrorKind::Form)).wait(1);
            if frames_between {
                ward.poll();
            }
        }
        assert_eq!(ward.rules(), expected, "{errors} {frames_between}");
    }
}

/// Not every controller tells that it was restarted.
#[test]
fn a_controller_that_hears_or_has_another_state_is_not_bus_off() {
    for event in [LinkEvent::ErrorActive, LinkEvent::ErrorWarning, LinkEvent::ErrorPassive] {
        let mut ward = Ward::new();
        ward.link(LinkEvent::BusOff).wait(5).link(event);
        assert!(ward.of(Rule::BusOff)[0].1.is_some(), "{event:?}");
    }
    let mut ward = Ward::with_slave();
    ward.link(LinkEvent::BusOff).wait(5).poll().answer();
    assert!(ward.only(Rule::BusOff).is_over());
    ward.poll().wait(99).poll().wait(99).poll().wait(99).poll().wait(120);
    assert_eq!(ward.rules(), [Rule::BusOff, Rule::NotAnswering], "what is silent now is found");
}

#[test]
fn at_the_warning_limit_a_controller_is_error_active_again() {
    let mut ward = Ward::new();
    ward.link(LinkEvent::ErrorPassive).wait(5).link(LinkEvent::ErrorWarning);
    assert!(ward.only(Rule::ErrorPassive).is_over());
}

#[test]
fn the_controller_leaves_the_bus_and_comes_back() {
    let mut ward = Ward::new();
    ward.link(LinkEvent::ErrorWarning).link(LinkEvent::Counters { tec: 96, rec: 0 });
    ward.is_healthy();
    ward.link(LinkEvent::ErrorPassive);
    assert_eq!(ward.only(Rule::ErrorPassive).to_string(), "the interface is error-passive");
    ward.wait(5).link(LinkEvent::BusOff);
    assert_eq!(ward.rules(), [Rule::ErrorPassive, Rule::BusOff]);
    ward.wait(5).link(LinkEvent::Up);
    assert!(ward.doctor.findings().all(Finding::is_over));
    // The same of a node, where that can be known.
    ward.doctor.link_of(Some(mac(7)), Instant::from_millis(60), None, LinkEvent::BusOff);
    assert_eq!(ward.of(Rule::BusOff)[1].2, "node 7 is bus-off");
}

#[test]
fn frames_that_are_not_devicenets() {
    let mut ward = Ward::new();
    ward.check(10, 0, 1);
    ward.is_healthy();
    let extended = Frame::new(ExtendedId::new(0x18FF_0001).unwrap(), &[]).unwrap();
    ward.frame(&extended).id(0x7F0, &[]).id(0x7C0, &[]);
    ward.doctor.can_fd(Instant::from_millis(ward.now), 99);
    let found = ward.only(Rule::ForeignTraffic);
    assert_eq!((found.count, found.evidence.frames()), (4, &[2, 3, 4, 99][..]));
    assert_eq!(
        found.to_string(),
        "frames that are not DeviceNet's, the last with the format of CAN FD, 4 times"
    );
}

#[test]
fn frames_that_were_lost() {
    let mut ward = Ward::new();
    ward.link(LinkEvent::Overrun { lost: 1 });
    assert_eq!(ward.only(Rule::Overrun).to_string(), "1 frame was lost before it was seen");
    ward.link(LinkEvent::Overrun { lost: 2 }).link(LinkEvent::Overrun { lost: 4 });
    assert_eq!(ward.only(Rule::Overrun).to_string(), "7 frames were lost before they were seen, 3 times");
}
