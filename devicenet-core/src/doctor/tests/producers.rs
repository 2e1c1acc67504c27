//! Change of state and cyclic: how many produce on one identifier.

use super::*;
use link_core::BusErrorKind;

/// Slave 10, which produces by change of state every 100 ms at least, and a second producer.
fn producers(choice: u8, millis: u64, messages: &[(u64, u8)]) -> Ward {
    let mut ward = Ward::with_slave_of(DoctorConfig::default(), choice);
    let begin = ward.now;
    for round in 0..20 {
        for &(at, value) in messages {
            let due = begin + 10 + round * millis + at;
            ward.wait((due - 2).saturating_sub(ward.now)).group1(0xD, 10, &[value]).group2(10, 2, &[]);
        }
    }
    ward
}

#[test]
fn two_producers_on_the_identifier_of_change_of_state() {
    // The same data, other data, and data at a time of its own.
    let of_state: [(u64, &[(u64, u8)]); 3] =
        [(100, &[(0, 7), (30, 7)]), (100, &[(0, 7), (30, 8)]), (300, &[(0, 7), (70, 8), (100, 7), (200, 7)])];
    for (millis, messages) in of_state {
        let ward = producers(0x11, millis, messages);
        let found = ward.only(Rule::IdentifierCollision);
        assert_eq!(found.node, Some(mac(10)));
        assert!(
            found.to_string().starts_with(
                "identifier 0x34A of node 10 carries messages in a rhythm that a single sender does not have: a second sender"
            ),
            "{found}"
        );
    }
}

/// A value that changes as it likes, one that blinks, and one that is told when its time has come.
#[test]
fn a_single_producer_has_a_rhythm_of_its_own() {
    let of_state: [(u64, &[(u64, u8)]); 4] = [
        (100, &[(0, 7)]),
        (100, &[(0, 7), (50, 8)]),
        (170, &[(0, 7), (13, 8), (30, 7), (70, 8)]),
        (230, &[(0, 7), (10, 8), (110, 8), (140, 7)]),
    ];
    for (millis, messages) in of_state {
        producers(0x11, millis, messages).is_healthy();
    }
}

/// A message of two fragments changes in its first, in its second, or, from another sender, not at all.
#[test]
fn a_producer_of_long_messages_is_judged_by_all_of_its_data() {
    // The second of two messages 30 ms after the first, each with an expected packet rate of 100 ms.
    let produce = |data: fn(u8) -> [u8; 2]| {
        let mut ward = Ward::with_slave_of(DoctorConfig::default(), 0x11);
        ward.group2(10, 4, &[1, 0x0E, 5, 4, 7]).group2(10, 3, &[1, 0x8E, 10, 0]);
        for round in 0..40 {
            let [first, last] = data(round);
            ward.group1(0xD, 10, &[0, first, 2, 3, 4, 5, 6, 7]).group1(0xD, 10, &[0x81, 8, 9, last]);
            ward.group2(10, 2, &[]).wait(if round % 2 == 0 { 27 } else { 67 });
        }
        ward
    };
    produce(|round| [round, 0]).is_healthy();
    produce(|round| [0, round]).is_healthy();
    produce(|_| [0, 0]).only(Rule::IdentifierCollision);
}

/// An application that triggers production although nothing has changed, from a timer or whenever it likes.
#[test]
fn an_application_that_triggers_without_a_change_is_one_producer() {
    let triggered = |gaps: &mut dyn FnMut() -> u64| {
        let mut ward = Ward::with_slave_of(DoctorConfig::default(), 0x11);
        for _ in 0..2_000 {
            ward.group1(0xD, 10, &[7]).group2(10, 2, &[]).wait(gaps() - 2);
        }
        ward.is_healthy();
    };
    for period in [5, 10, 20, 25, 33, 40, 49] {
        triggered(&mut || period);
    }
    for most in [30, 45, 60, 90] {
        // xorshift32.
        let mut state = 0x2545_F491_u32;
        triggered(&mut || {
            state ^= state << 13;
            state ^= state >> 17;
            state ^= state << 5;
            3 + u64::from(state) % (most - 3)
        });
    }
}

/// What such an application sends does not hide a second producer of other data.
#[test]
fn a_second_producer_beside_an_application_that_triggers() {
    let ward = producers(0x11, 100, &[(0, 7), (20, 7), (40, 7), (50, 9), (60, 7), (80, 7)]);
    assert_eq!(ward.only(Rule::IdentifierCollision).node, Some(mac(10)));
}

/// Whatever has changed, it sends when its time has come.
#[test]
fn two_producers_on_the_identifier_of_cyclic() {
    producers(0x21, 100, &[(0, 7)]).is_healthy();
    producers(0x21, 100, &[(0, 7), (30, 8)]).only(Rule::IdentifierCollision);
}

/// A cyclic slave, and an error once a round, before its last message. Who sends again what an error has destroyed does so at once and
/// unchanged, and who was held up by errors is earlier the next time; a second producer goes on beside them.
#[test]
fn an_error_explains_a_message_that_is_repeated_at_once_or_late_and_no_other() {
    let one: [(u64, &[(u64, u8)]); 3] =
        [(100, &[(0, 7)]), (100, &[(0, 7), (1, 7)]), (200, &[(0, 7), (160, 7)])];
    let two: [(u64, &[(u64, u8)]); 2] = [(100, &[(0, 7), (30, 8)]), (100, &[(0, 7), (30, 7)])];
    let of_round = one.map(|round| (round, false)).into_iter().chain(two.map(|round| (round, true)));
    for ((millis, messages), is_second) in of_round {
        let mut ward = Ward::with_slave_of(DoctorConfig::default(), 0x21);
        let begin = ward.now + 10;
        for round in 0..20 {
            for (index, &(at, value)) in (1..).zip(messages) {
                ward.wait((begin + round * millis + at - 1).saturating_sub(ward.now));
                if index == messages.len() {
                    ward.link(LinkEvent::BusError(BusErrorKind::Bit));
                }
                ward.group1(0xD, 10, &[value]);
            }
        }
        assert_eq!(!ward.of(Rule::IdentifierCollision).is_empty(), is_second, "{messages:?}");
    }
}

/// Without an acknowledge it is sent again.
#[test]
fn a_message_that_is_sent_again_has_no_second_sender() {
    let mut ward = Ward::with_slave_of(DoctorConfig::default(), 0x11);
    for _ in 0..20 {
        ward.group1(0xD, 10, &[7]).wait(15).group1(0xD, 10, &[7]).group2(10, 2, &[]).wait(82);
    }
    assert_eq!(ward.of(Rule::IdentifierCollision), []);
}
