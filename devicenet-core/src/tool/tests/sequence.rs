//! The sequence of a recovery, and what other tools and the bus do to it.

use link_core::{BusErrorKind, Input, LinkEvent, TxOutcome};

use super::super::*;
use super::bus::*;
use crate::message::{DelayOffset, NodeSelection};

#[test]
fn unanswered_twice_the_set_is_owned() {
    let mut bus = Bus::online();
    let who = |tool: &mut OfflineTool, now| tool.who(now, DelayOffset::SERIAL);
    assert_eq!(bus.command(who), Err(CommandError::NotOwner));
    bus.command(|tool, now| tool.claim(now)).unwrap();
    bus.sends("7EF: 05 4B 34 12 45 23 00 00");
    bus.wait(999);
    assert_eq!(bus.in_flight, None);
    bus.wait(1);
    bus.sends("7EF: 05 4B 34 12 45 23 00 00");
    bus.wait(999);
    assert_eq!(bus.tool.state(), ToolState::Claiming);
    bus.wait(1);
    bus.tells(&[
        "Idle -> Claiming: claimed",
        "Claiming -> Claiming: wait over",
        "Claiming -> Owner: nobody owns it",
    ]);
}

/// Any ownership response will do: the bytes of the examples, or none at all.
#[test]
fn an_answer_means_that_another_owns_it() {
    for response in ["7EE: 01 CB 06 00 08 07 06 05", "7EE:"] {
        let mut bus = Bus::online();
        bus.command(|tool, now| tool.claim(now)).unwrap();
        bus.sends("7EF: 05 4B 34 12 45 23 00 00");
        bus.hears(response);
        bus.tells(&["Idle -> Claiming: claimed", "Claiming -> Idle: owned by another tool"]);
        bus.wait(10_000);
        assert_eq!(bus.in_flight, None);
    }
}

#[test]
fn the_owner_defends_the_set() {
    let mut bus = Bus::owner();
    bus.hears("7EF: 01 4B 06 00 08 07 06 05");
    bus.sends("7EE: 05 CB 34 12 45 23 00 00");
    bus.hears("7EF: 01 4B");
    assert_eq!(bus.in_flight, None);
    assert_eq!((bus.tool.counters().defended, bus.tool.counters().ignored), (1, 1));
    // Somebody else thinks that he is the owner.
    bus.hears("7EE: 01 CB 06 00 08 07 06 05");
    assert_eq!(bus.tool.state(), ToolState::Idle);
}

#[test]
fn of_two_that_claim_at_once_the_first_on_the_bus_wins() {
    let mut bus = Bus::online();
    bus.command(|tool, now| tool.claim(now)).unwrap();
    // The other was faster: its request comes while ours waits for the bus.
    bus.hears("7EF: 01 4B 06 00 08 07 06 05");
    bus.sends("7EF: 05 4B 34 12 45 23 00 00");
    assert_eq!(bus.in_flight, None, "no defence");
    bus.hears("7EE: 01 CB 06 00 08 07 06 05");
    assert_eq!(bus.tool.state(), ToolState::Idle);

    bus.command(|tool, now| tool.claim(now)).unwrap();
    bus.sends("7EF: 05 4B 34 12 45 23 00 00");
    bus.hears("7EF: 01 4B 06 00 08 07 06 05");
    bus.sends("7EE: 05 CB 34 12 45 23 00 00");
    bus.wait(1000);
    bus.sends("7EF: 05 4B 34 12 45 23 00 00");
    bus.wait(1000);
    assert_eq!(bus.tool.state(), ToolState::Owner);
}

/// Two frames with one identifier and other data destroy each other until both controllers are off the bus.
#[test]
fn a_collision_is_backed_off_from() {
    let mut bus = Bus::online();
    bus.command(|tool, now| tool.claim(now)).unwrap();
    bus.input(Input::Link(LinkEvent::BusError(BusErrorKind::Bit)));
    assert_eq!(bus.withdrawals, 1);
    let (token, _) = bus.in_flight.take().unwrap();
    bus.input(Input::TxDone(token, TxOutcome::Withdrawn));
    assert_eq!(bus.in_flight, None);
    // 10 ms, and ten times its MAC ID.
    bus.wait(59);
    assert_eq!(bus.in_flight, None);
    bus.wait(1);
    bus.sends("7EF: 05 4B 34 12 45 23 00 00");
    assert_eq!(bus.tool.counters().collisions, 1);
    // A missing acknowledge is no collision.
    let mut alone = Bus::online();
    alone.command(|tool, now| tool.claim(now)).unwrap();
    alone.input(Input::Link(LinkEvent::BusError(BusErrorKind::Ack)));
    assert_eq!(alone.withdrawals, 0);
}

#[test]
fn a_faulted_node_is_found_and_given_a_mac_id() {
    let mut bus = Bus::owner();
    bus.command(|tool, now| tool.who(now, DelayOffset::SERIAL)).unwrap();
    bus.sends("7ED: 3F 4B 03");
    let busy = bus.command(|tool, now| tool.who(now, DelayOffset::SERIAL));
    assert_eq!(busy, Err(CommandError::Busy));
    bus.wait(80);
    bus.hears("7EC: 00 06 00 08 07 06 05");
    bus.wait(2920);
    bus.tells(&["found vendor 6, serial 0x05060708", "Who: 1 answer"]);
    bus.command(|tool, now| tool.change_mac_id(now, DEVICE, mac(3))).unwrap();
    bus.sends("7ED: 03 4D 06 00 08 07 06 05");
    bus.wait(1);
    bus.hears("41F: 00 06 00 08 07 06 05");
    bus.wait(1000);
    bus.hears("41F: 00 06 00 08 07 06 05");
    bus.wait(1500);
    let last = bus.events.pop().unwrap();
    assert!(last.ends_with("is on line with MAC ID 3"), "{last}");
}

#[test]
fn a_mac_id_that_is_taken() {
    let mut bus = Bus::owner();
    bus.command(|tool, now| tool.change_mac_id(now, DEVICE, mac(3))).unwrap();
    bus.sends("7ED: 03 4D 06 00 08 07 06 05");
    bus.hears("41F: 00 06 00 08 07 06 05");
    bus.hears("41F: 80 34 12 99 99 00 00");
    let last = bus.events.pop().unwrap();
    assert!(last.ends_with("has not MAC ID 3: another node has it"), "{last}");
    bus.command(|tool, now| tool.change_mac_id(now, DEVICE, mac(4))).unwrap();
    bus.sends("7ED: 04 4D 06 00 08 07 06 05");
    bus.wait(3000);
    let last = bus.events.pop().unwrap();
    assert!(last.ends_with("has not MAC ID 4: it does not react"), "{last}");
}

#[test]
fn identify() {
    let mut bus = Bus::owner();
    bus.command(|tool, now| tool.identify(now, NodeSelection::MacId(mac(63)))).unwrap();
    bus.sends("7ED: 7F 4C");
    bus.hears("7EC: 7F CC");
    bus.hears("7EC: 00 06 00 08 07 06 05");
    bus.wait(1000);
    bus.tells(&["Identify: at least one node answers", "Identify: done"]);
    assert_eq!(bus.tool.counters().ignored, 1, "a Who response that nobody asked for");
    bus.command(|tool, now| tool.identify_device(now, DEVICE)).unwrap();
    bus.sends("7ED: 3F 4C 06 00 08 07 06 05");
    bus.wait(1000);
    bus.tells(&["Identify: no answer"]);
}

#[test]
fn released_the_set_is_not_defended() {
    let mut bus = Bus::owner();
    bus.command(|tool, now| tool.who(now, DelayOffset::SERIAL)).unwrap();
    bus.command(|tool, now| {
        tool.release(now);
    });
    assert_eq!(bus.withdrawals, 1);
    let (token, _) = bus.in_flight.take().unwrap();
    bus.input(Input::TxDone(token, TxOutcome::Withdrawn));
    bus.hears("7EF: 01 4B 06 00 08 07 06 05");
    assert_eq!(bus.in_flight, None);
}

#[test]
fn off_line_the_set_is_lost() {
    let mut bus = Bus::owner();
    bus.hears("42F: 80 34 12 99 99 00 00");
    bus.tells(&["Owner -> Idle: off line"]);
}

/// The other tool is answered, even if the own claim goes on meanwhile.
#[test]
fn a_defence_survives_the_end_of_a_wait() {
    let mut bus = Bus::online();
    bus.command(|tool, now| tool.claim(now)).unwrap();
    bus.sends(CLAIM);
    bus.wait(999);
    bus.hears("7EF: 01 4B 06 00 08 07 06 05");
    bus.wait(1);
    assert_eq!(bus.withdrawals, 0);
    bus.sends("7EE: 05 CB 34 12 45 23 00 00");
    bus.sends(CLAIM);
    bus.wait(999);
    bus.hears("7EF: 01 4B 06 00 08 07 06 05");
    bus.wait(1);
    assert_eq!(bus.tool.state(), ToolState::Owner);
    bus.command(|tool, now| tool.who(now, DelayOffset::SERIAL)).unwrap();
    bus.sends("7EE: 05 CB 34 12 45 23 00 00");
    bus.sends("7ED: 3F 4B 03");
}

/// A question that was never asked has no answer: the set is not owned without two requests on the bus.
#[test]
fn a_request_that_is_given_back_is_sent_again() {
    let mut bus = Bus::online();
    bus.command(|tool, now| tool.claim(now)).unwrap();
    for _ in 0..3 {
        bus.gives_back(CLAIM, TxOutcome::Dropped);
        bus.wait(99);
        assert_eq!(bus.in_flight, None, "no storm");
        bus.wait(1);
    }
    bus.sends(CLAIM);
    assert_eq!(bus.tool.counters().not_sent, 3);
    bus.wait(1000);
    bus.sends(CLAIM);
    bus.wait(1000);
    assert_eq!(bus.tool.state(), ToolState::Owner);
}

/// The collision was another's, and the message was on the bus before it could be withdrawn.
#[test]
fn a_message_that_was_sent_after_all_is_not_repeated() {
    for late in [0, 100] {
        let mut bus = Bus::owner();
        bus.command(|tool, now| tool.who(now, DelayOffset::SERIAL)).unwrap();
        bus.input(Input::Link(LinkEvent::BusError(BusErrorKind::Bit)));
        bus.wait(late);
        bus.sends("7ED: 3F 4B 03");
        bus.hears("7EC: 00 06 00 08 07 06 05");
        bus.wait(3000);
        assert_eq!(bus.in_flight, None);
        bus.tells(&[
            "another node sends with the same identifier",
            "found vendor 6, serial 0x05060708",
            "Who: 1 answer",
        ]);
    }
}

/// Somebody uses the MAC ID, as the check of a third device shows before the request is on the bus: it is taken back.
#[test]
fn a_message_without_purpose_is_withdrawn() {
    let mut bus = Bus::owner();
    bus.command(|tool, now| tool.change_mac_id(now, DEVICE, mac(3))).unwrap();
    bus.hears("41F: 80 34 12 99 99 00 00");
    assert_eq!(bus.withdrawals, 1);
    bus.gives_back("7ED: 03 4D 06 00 08 07 06 05", TxOutcome::Withdrawn);
    bus.wait(60_000);
    assert_eq!(bus.in_flight, None);
}

#[test]
fn the_own_mac_id_is_not_given_away() {
    let mut bus = Bus::owner();
    let refused = bus.command(|tool, now| tool.change_mac_id(now, DEVICE, mac(5)));
    assert_eq!(refused, Err(CommandError::OwnMacId(mac(5))));
}

/// It is another pause after each collision.
#[test]
fn the_pauses_after_collisions_differ() {
    let mut bus = Bus::online();
    bus.command(|tool, now| tool.claim(now)).unwrap();
    for pause in [60, 160, 260] {
        bus.input(Input::Link(LinkEvent::BusError(BusErrorKind::Bit)));
        let (token, _) = bus.in_flight.take().unwrap();
        bus.input(Input::TxDone(token, TxOutcome::Withdrawn));
        bus.wait(pause - 1);
        assert_eq!(bus.in_flight, None);
        bus.wait(1);
    }
    bus.sends(CLAIM);
}

/// A tool that is faulted itself hears what repairs it, and follows.
#[test]
fn a_tool_can_be_repaired_or_reset() {
    let mut bus = Bus::owner();
    bus.hears("42F: 80 34 12 99 99 00 00");
    assert!(bus.tool.filter().accepts(&frame("7ED: 3F 4B 03")));
    bus.hears("7ED: 06 4D 34 12 45 23 00 00");
    for _ in 0..2 {
        bus.sends("437: 00 34 12 45 23 00 00");
        bus.wait(1000);
    }
    assert!(bus.tool.access().is_online());
    bus.command(|tool, now| tool.claim(now)).unwrap();
    bus.sends("7EF: 06 4B 34 12 45 23 00 00");
    bus.command(|tool, now| tool.set_mac_id(now, mac(7))).unwrap();
    assert_eq!(bus.tool.state(), ToolState::Idle);
    bus.sends("43F: 00 34 12 45 23 00 00");
    bus.command(|tool, now| tool.reset(now));
    bus.sends("43F: 00 34 12 45 23 00 00");
}

const CLAIM: &str = "7EF: 05 4B 34 12 45 23 00 00";

/// A change shows here first. Half of it is network access.
#[test]
#[cfg(target_pointer_width = "64")]
fn the_size_of_the_machine() {
    assert_eq!(size_of::<OfflineTool>(), 464);
}
