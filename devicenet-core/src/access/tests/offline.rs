//! A faulted node in the offline connection set.

use link_core::{LinkEvent, TxOutcome};

use super::super::{AccessEvent, MacIdSource, MaskPredicate, NetworkStatus, StateKind};
use super::bus::*;

/// The request of the ICP DAS I-7242D manual p. 93: byte 2 of the answer is 0x12, so the node waits 18 x 10 ms.
#[test]
fn who_is_answered_after_the_delay_that_a_byte_of_the_answer_sets() {
    let mut bus = Bus::faulted(config());
    bus.hears(0x7ED, &[0x3F, 0x4B, 0x02]);
    bus.wait(179);
    bus.sends_nothing();
    bus.wait(1);
    bus.sends(0x7EC, &REQUEST);
    bus.acknowledges();
    bus.wait(10_000);
    bus.sends_nothing();
    bus.is(StateKind::CommFault);
}

#[test]
fn the_delay_has_a_unit_that_can_be_set_and_may_be_zero() {
    let mut bus = Bus::faulted(config());
    bus.hears(0x7ED, &[0x3F, 0x4B, 0x00]);
    bus.sends(0x7EC, &REQUEST);

    let mut slow = config();
    slow.who_delay_unit = 100;
    let mut bus = Bus::faulted(slow);
    bus.hears(0x7ED, &[0x3F, 0x4B, 0x03]);
    bus.wait(6899);
    bus.sends_nothing();
    bus.wait(1);
    bus.sends(0x7EC, &REQUEST);
}

#[test]
fn another_who_restarts_the_delay() {
    let mut bus = Bus::faulted(config());
    bus.hears(0x7ED, &[0x3F, 0x4B, 0x02]);
    bus.wait(100);
    bus.hears(0x7ED, &[0x3F, 0x4B, 0x02]);
    bus.wait(179);
    bus.sends_nothing();
    bus.wait(1);
    bus.sends(0x7EC, &REQUEST);
    bus.acknowledges();
    bus.sends_nothing();
}

#[test]
fn match_means_one_mac_id_and_a_mask_means_its_subsets() {
    // 37 is 0b100101.
    for (byte, subset, intersects) in [
        (0x3F, true, true),
        (0x25, true, true),
        (0x27, true, true),
        (0x24, false, true),
        (0x1A, false, false),
        (0x40 | 37, true, true),
        (0x40 | 36, false, false),
    ] {
        for (predicate, answers) in [(MaskPredicate::Subset, subset), (MaskPredicate::Intersects, intersects)]
        {
            let mut config = config();
            config.mask_predicate = predicate;
            let mut bus = Bus::faulted(config);
            bus.hears(0x7ED, &[byte, 0x4C]);
            if answers {
                bus.sends(0x7EC, &[byte, 0xCC]);
            }
            bus.sends_nothing();
        }
    }
}

#[test]
fn identify_of_a_device_flashes_red_and_green_for_a_minute() {
    let mut bus = Bus::faulted(config());
    bus.hears(0x7ED, &[0x3F, 0x4C, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00]);
    bus.sends(0x7EC, &[0x3F, 0xCC]);
    bus.acknowledges();
    bus.tells(AccessEvent::Identify { on: true });
    assert_eq!(bus.node.network_status(), NetworkStatus::FlashingRedGreen);
    bus.wait(59_999);
    assert_eq!(bus.node.network_status(), NetworkStatus::FlashingRedGreen);
    bus.wait(1);
    bus.tells(AccessEvent::Identify { on: false });
    assert_eq!(bus.node.network_status(), NetworkStatus::SolidRed);
}

#[test]
fn another_identify_of_a_device_begins_another_minute() {
    let mut bus = Bus::faulted(config());
    for _ in 0..2 {
        bus.hears(0x7ED, &[0x3F, 0x4C, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00]);
        bus.sends(0x7EC, &[0x3F, 0xCC]);
        bus.acknowledges();
        bus.wait(40_000);
    }
    bus.wait(19_999);
    assert_eq!(bus.events, [AccessEvent::Identify { on: true }]);
    bus.wait(1);
    assert_eq!(bus.events, [AccessEvent::Identify { on: true }, AccessEvent::Identify { on: false }]);
}

#[test]
fn the_short_identify_is_answered_and_does_not_flash() {
    let mut bus = Bus::faulted(config());
    bus.hears(0x7ED, &[0x3F, 0x4C]);
    bus.sends(0x7EC, &[0x3F, 0xCC]);
    assert_eq!(bus.node.network_status(), NetworkStatus::SolidRed);
}

#[test]
fn questions_that_come_faster_than_answers_go_out_are_answered_once() {
    let mut bus = Bus::faulted(config());
    bus.hears(0x7ED, &[0x3F, 0x4C]);
    bus.sends(0x7EC, &[0x3F, 0xCC]);
    for _ in 0..100 {
        bus.hears(0x7ED, &[0x65, 0x4C]);
        bus.hears(0x7ED, &[0x3F, 0x4B, 0x00]);
    }
    bus.sends_nothing();
    bus.acknowledges();
    bus.sends(0x7EC, &[0x65, 0xCC]);
    bus.acknowledges();
    bus.sends(0x7EC, &REQUEST);
    bus.acknowledges();
    bus.sends_nothing();
}

/// The unanswered request of the faulted node is withdrawn, and not yet given back: the answer has to wait.
#[test]
fn an_answer_waits_for_the_withdrawn_request() {
    let mut bus = Bus::power_up(config());
    bus.sends(CHECK, &REQUEST);
    bus.hears(CHECK, &TWIN_REQUEST);
    bus.withdraws();
    bus.hears(0x7ED, &[0x3F, 0x4C]);
    bus.sends_nothing();
    bus.done(TxOutcome::Withdrawn);
    bus.sends(0x7EC, &[0x3F, 0xCC]);
}

#[test]
fn a_new_mac_id_withdraws_an_answer_and_ends_the_flashing() {
    let mut bus = Bus::faulted(config());
    bus.hears(0x7ED, &[0x3F, 0x4C, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00]);
    bus.sends(0x7EC, &[0x3F, 0xCC]);
    bus.hears(0x7ED, &[0x05, 0x4D, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00]);
    bus.withdraws();
    bus.sends_nothing();
    bus.done(TxOutcome::Sent);
    bus.sends(0x42F, &REQUEST);
    bus.tells(AccessEvent::Identify { on: false });
    assert_eq!(bus.node.network_status(), NetworkStatus::Off);
}

#[test]
fn a_mac_id_from_switches_stays_and_the_node_starts_anew() {
    let mut switches = config();
    switches.mac_id_source = MacIdSource::Switches;
    let mut bus = Bus::faulted(switches);
    bus.hears(0x7ED, &[0x05, 0x4D, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00]);
    bus.tells(AccessEvent::MacIdLocked { requested: mac(5) });
    bus.sends(CHECK, &REQUEST);
}

#[test]
fn another_device_is_not_meant() {
    let mut bus = Bus::faulted(config());
    for other in [[0x35, 0x12, 0x45, 0x23, 0x00, 0x00], [0x34, 0x12, 0x45, 0x23, 0x00, 0x01]] {
        for head in [[0x05, 0x4D], [0x3F, 0x4C]] {
            let data = [&head[..], &other[..]].concat();
            bus.hears(0x7ED, &data);
        }
    }
    bus.is(StateKind::CommFault);
    bus.sends_nothing();
    assert_eq!(bus.node.counters().bad_frames, 0);
}

#[test]
fn malformed_messages_are_counted_and_told_and_change_nothing() {
    let malformed: [&[u8]; 9] = [
        &[],
        &[0x3F],
        &[0xBF, 0x4B, 0x00],
        &[0x3F, 0x4B],
        &[0x3F, 0x4B, 0x07],
        &[0x3F, 0x4C, 0x34],
        &[0x45, 0x4D, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00],
        &[0x05, 0x4D, 0x34, 0x12, 0x45, 0x23, 0x00],
        &[0x3F, 0xCC],
    ];
    let mut bus = Bus::faulted(config());
    for data in malformed {
        bus.hears(0x7ED, data);
    }
    bus.is(StateKind::CommFault);
    bus.wait(10_000);
    bus.sends_nothing();
    assert_eq!(bus.node.counters().bad_frames, 9);
    assert_eq!(bus.events.len(), 9);
}

#[test]
fn the_offline_connection_set_is_heard_only_while_faulted() {
    for make in [Bus::power_up, Bus::waiting, Bus::online] {
        let mut bus = make(config());
        let before = bus.node.state();
        bus.hears(0x7ED, &[0x05, 0x4D, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00]);
        assert_eq!(bus.node.state(), before);
        assert_eq!(bus.node.mac_id(), mac(37));
    }
}

#[test]
fn network_power_lost_ends_an_answer_that_is_delayed() {
    let mut bus = Bus::faulted(config());
    bus.hears(0x7ED, &[0x3F, 0x4B, 0x03]);
    bus.link(LinkEvent::Down);
    bus.wait(10_000);
    bus.sends_nothing();
}
