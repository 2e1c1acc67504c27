//! I/O: silence, slowness, masters that are gone, lengths and fragments.

use super::*;
use crate::doctor::finding::Exchange;

#[test]
fn a_slave_that_answers_is_healthy() {
    let mut ward = Ward::with_slave();
    for _ in 0..100 {
        ward.poll().answer().wait(98);
    }
    ward.is_healthy();
}

#[test]
fn a_slave_that_leaves_polls_unanswered_for_four_times_the_packet_rate_has_stopped() {
    let mut ward = Ward::with_slave();
    ward.poll().answer();
    let first = ward.now + 1;
    for _ in 0..4 {
        ward.poll().wait(99);
    }
    ward.is_healthy();
    ward.wait(10);
    let found = ward.only(Rule::NotAnswering);
    assert_eq!(found.since, Instant::from_millis(first));
    assert_eq!(found.node, Some(mac(10)));
    assert_eq!(found.scanner_status().map(|status| status.0), Some(72));
    assert_eq!(found.to_string(), "node 10 has not answered its polls for more than 400 ms");
    assert!(found.advice().to_string().contains("drop cable of node 10"));
    // The first command without an answer, and the last.
    assert_eq!(found.evidence.frames(), [7, 10]);
    ward.poll().answer();
    assert!(ward.only(Rule::NotAnswering).is_over());
}

#[test]
fn an_answer_just_in_time_is_slow_and_no_silence() {
    for (wait, expected) in [(276, &[][..]), (277, &[Rule::SlowAnswers]), (396, &[Rule::SlowAnswers])] {
        let mut ward = Ward::with_slave();
        ward.poll().answer().poll().wait(1).poll().wait(wait).answer();
        assert_eq!(ward.rules(), expected, "{wait}");
    }
    // After all of it, the peer has given up.
    let mut ward = Ward::with_slave();
    ward.poll().answer().poll().wait(1).poll().wait(399).answer();
    assert!(ward.only(Rule::NotAnswering).is_over());
}

#[test]
fn slow_answers_are_over_after_ten_in_time() {
    let mut ward = Ward::with_slave();
    ward.poll().wait(300).answer();
    let found = ward.only(Rule::SlowAnswers);
    assert_eq!(
        found.to_string(),
        "node 10 answers slowly: up to 301 ms of the 400 ms after which its peer gives up"
    );
    for _ in 0..9 {
        ward.poll().answer();
    }
    assert!(!ward.only(Rule::SlowAnswers).is_over());
    ward.poll().answer();
    assert!(ward.only(Rule::SlowAnswers).is_over());
}

/// Its bit-strobe is prompt and its poll slow: a finding, and not one that comes and goes.
#[test]
fn slow_answers_are_over_when_all_io_is_in_time() {
    let mut ward = Ward::with_slave_of(DoctorConfig::default(), 0x07);
    ward.group2(10, 4, &[1, 0x10, 5, 3, 9, 100, 0]).group2(10, 3, &[1, 0x90, 100, 0]);
    ward.poll().wait(300).answer();
    let strobe = |ward: &mut Ward| _ = ward.group2(1, 0, &[0; 8]).group1(0xE, 10, &[1]);
    for _ in 0..20 {
        strobe(&mut ward);
    }
    assert!(!ward.only(Rule::SlowAnswers).is_over());
    for _ in 0..10 {
        ward.poll().answer();
    }
    assert!(ward.only(Rule::SlowAnswers).is_over());
}

/// Attribute 18 makes the peers wait for eight times the expected packet rate; a rate of 0 makes them wait for ever.
#[test]
fn the_time_out_multiplier_and_a_rate_of_zero() {
    let mut ward = Ward::with_slave();
    ward.group2(10, 4, &[1, 0x10, 5, 2, 18, 1]).group2(10, 3, &[1, 0x90]);
    ward.poll().wait(300).answer();
    ward.poll().wait(1).poll().wait(790);
    ward.is_healthy();
    ward.wait(20);
    let found = ward.only(Rule::NotAnswering);
    assert_eq!(found.to_string(), "node 10 has not answered its polls for more than 800 ms");
    ward.answer().poll().wait(600).answer();
    assert_eq!(
        ward.of(Rule::SlowAnswers).last().map(|(.., words)| words.as_str()),
        Some("node 10 answers slowly: up to 601 ms of the 800 ms after which its peer gives up")
    );

    let mut ward = Ward::with_slave();
    ward.group2(10, 4, &[1, 0x10, 5, 2, 9, 0, 0]).group2(10, 3, &[1, 0x90, 0, 0]);
    ward.poll().wait(5_000).answer().wait(60_000);
    ward.is_healthy();
    // Two commands without an answer are judged as if the rate was not known.
    ward.poll().poll().wait(1_010);
    let found = ward.only(Rule::NotAnswering);
    assert_eq!(found.to_string(), "node 10 has not answered its polls for more than 1000 ms");
}

/// Nothing tells its rate: a second, and two commands at least.
#[test]
fn a_recording_that_starts_in_the_middle() {
    let mut ward = Ward::new();
    ward.poll().answer().poll().wait(2_000);
    ward.is_healthy();
    ward.poll().wait(10);
    let found = ward.only(Rule::NotAnswering);
    assert_eq!((found.since, found.severity), (Instant::from_millis(3), Severity::Warning));
    // The master gives it up, and asks in vain: no assumption any more.
    for _ in 0..4 {
        ward.group2(10, 6, &[1, 0x4B, 3, 1, 1, 1]).wait(1_000);
    }
    assert_eq!(ward.only(Rule::NotAnswering).severity, Severity::Error);
}

/// Frames without data to a slave that produces by itself can be those of a master that does so as well, without acknowledges.
#[test]
fn what_was_never_answered_need_not_be_a_poll() {
    let mut ward = Ward::new();
    for _ in 0..10 {
        ward.group2(10, 5, &[]).group1(0xD, 10, &[7]).wait(500);
    }
    ward.is_healthy();
}

/// Whoever begins to listen does not know the connection sizes, and can come in the middle of a message.
#[test]
fn fragments_that_are_heard_from_the_middle_have_one_sender() {
    let poll: [&[u8]; 3] = [&[0; 8], &[0x41, 0, 0, 0, 0, 0, 0, 0], &[0x82, 0, 0, 0, 0, 0]];
    let frames = || [5_u8, 0xF].into_iter().flat_map(|message| poll.map(|data| (message, data)));
    for from in 0..frames().count() {
        let mut ward = Ward::new();
        for (message, data) in std::iter::repeat_with(frames).take(40).flatten().skip(from) {
            match message {
                5 => ward.group2(10, 5, data),
                _ => ward.group1(message, 10, data),
            };
        }
        ward.is_healthy();
    }
    // A message of 64 fragments, of which the poll was not heard.
    let mut ward = Ward::new();
    for count in 20..63 {
        ward.group1(0xF, 10, &[0x40 | count, 0, 0, 0, 0, 0, 0, 0]);
    }
    ward.group1(0xF, 10, &[0xBF, 0]).is_healthy();
}

/// A fragment of a command that comes twice can be one that an error has destroyed for somebody; one error excuses no more than that.
#[test]
fn an_error_excuses_a_fragment_that_is_repeated_right_after_it() {
    const FIRST: &[u8] = &[0, 1, 2, 3, 4, 5, 6, 7];
    const MIDDLE: &[u8] = &[0x41, 1, 2, 3, 4, 5, 6, 7];
    const LAST: &[u8] = &[0x82, 1];
    let mut ward = Ward::with_slave();
    // It consumes 15 bytes.
    ward.group2(10, 4, &[1, 0x0E, 5, 2, 8]).group2(10, 3, &[1, 0x8E, 15, 0]);
    let command = |ward: &mut Ward| {
        ward.group2(10, 5, FIRST).group2(10, 5, MIDDLE).group2(10, 5, LAST).answer();
    };
    command(&mut ward);
    ward.group2(10, 5, FIRST).group2(10, 5, MIDDLE).link(LinkEvent::BusError(link_core::BusErrorKind::Crc));
    ward.group2(10, 5, MIDDLE).group2(10, 5, LAST).answer();
    ward.is_healthy();
    command(&mut ward);
    ward.group2(10, 5, FIRST).group2(10, 5, MIDDLE).wait(5).group2(10, 5, MIDDLE);
    assert_eq!(ward.only(Rule::FragmentSequence).facts, Facts::Fragments { after: 1, found: 1 });
}

/// It is one all the same, but its allocation was not seen.
#[test]
fn a_second_sender_on_a_bus_that_already_runs() {
    let mut ward = Ward::new();
    ward.poll().answer().wait(1_000);
    for _ in 0..3 {
        ward.poll().answer().group1(0xF, 10, &[3]);
    }
    assert_eq!(ward.only(Rule::IdentifierCollision).severity, Severity::Warning);
}

#[test]
fn a_bit_strobe_without_an_answer() {
    let mut ward = Ward::with_slave_of(DoctorConfig::default(), 0x05);
    for _ in 0..10 {
        ward.group2(1, 0, &[0; 8]).group1(0xE, 10, &[1]).wait(98);
    }
    ward.is_healthy();
    for _ in 0..5 {
        ward.group2(1, 0, &[0; 8]).wait(99);
    }
    let found = ward.only(Rule::NotAnswering);
    assert_eq!(found.to_string(), "node 10 has not answered its bit-strobes for more than 400 ms");
}

/// It was acknowledged to the last: the slave is silent. It was not: the master is.
#[test]
fn change_of_state_that_stops() {
    for (is_acknowledged, expected) in [(true, Rule::NotAnswering), (false, Rule::MasterSilent)] {
        let mut ward = Ward::with_slave_of(DoctorConfig::default(), 0x11);
        for _ in 0..5 {
            ward.group1(0xD, 10, &[1]).group2(10, 2, &[]).wait(97);
        }
        ward.is_healthy();
        ward.group1(0xD, 10, &[2]);
        if is_acknowledged {
            ward.group2(10, 2, &[]);
        }
        ward.wait(290);
        ward.is_healthy();
        ward.wait(130);
        let found = ward.only(expected);
        if let Facts::Silence { exchange, .. } = found.facts {
            assert_eq!(exchange, Exchange::ChangeOfState);
            assert_eq!(found.to_string(), "node 10 has sent no COS/cyclic message for more than 400 ms");
        }
    }
}

#[test]
fn a_master_that_no_longer_polls() {
    let mut ward = Ward::with_slave();
    ward.poll().answer().wait(399);
    ward.is_healthy();
    ward.wait(20);
    let found = ward.only(Rule::MasterSilent);
    assert_eq!((found.node, found.severity), (Some(mac(1)), Severity::Error));
    assert_eq!(found.to_string(), "master 1 no longer serves slave 10");
    // It comes back: the connection is allocated anew.
    ward.allocate(10, 1, 0x03);
    ward.wait(10);
    assert!(ward.only(Rule::MasterSilent).is_over());
}

#[test]
fn a_master_that_releases_its_slave_may_stop() {
    let mut ward = Ward::with_slave();
    ward.poll().answer();
    ward.group2(10, 4, &[1, 0x4C, 3, 1, 3]).group2(10, 3, &[1, 0xCC]).wait(5_000);
    ward.is_healthy();
}

/// The slave is gone, and the master asks for it: that the polls have stopped is no fault of the master.
#[test]
fn a_master_that_gives_up_a_silent_slave_is_not_silent() {
    let mut ward = Ward::with_slave();
    ward.poll().answer();
    for _ in 0..4 {
        ward.poll().wait(90);
    }
    ward.wait(1_000);
    assert_eq!(ward.rules(), [Rule::NotAnswering]);
}

#[test]
fn wrong_lengths_and_missing_fragments() {
    let mut ward = Ward::with_slave();
    ward.group2(10, 4, &[1, 0x0E, 5, 2, 7]).group2(10, 3, &[1, 0x8E, 1, 0]);
    ward.poll().answer();
    ward.is_healthy();
    ward.poll().group1(0xF, 10, &[1, 2]);
    let found = ward.only(Rule::WrongLength);
    assert_eq!(found.to_string(), "node 10 sends 2 bytes of I/O data where the connection has 1");
    assert_eq!(found.scanner_status().map(|status| status.0), Some(85));

    let mut ward = Ward::with_slave();
    ward.group2(10, 4, &[1, 0x0E, 5, 2, 7]).group2(10, 3, &[1, 0x8E, 20, 0]);
    ward.poll().group1(0xF, 10, &[0, 1, 2, 3, 4, 5, 6, 7]).group1(0xF, 10, &[0x82, 1]);
    assert_eq!(
        ward.only(Rule::FragmentSequence).to_string(),
        "node 10 sends fragment 2 of its I/O data after fragment 0"
    );
}

/// The master is there, but its frames are not: nobody acknowledges them. Then the slave is looked for.
#[test]
fn a_master_that_is_alone_is_not_silent() {
    let mut ward = Ward::with_slave();
    ward.poll().answer();
    for _ in 0..200 {
        ward.link(LinkEvent::BusError(link_core::BusErrorKind::Ack)).wait(10);
    }
    ward.group2(10, 6, &[1, 0x4B, 3, 1, 1, 1]).wait(100);
    assert_eq!(ward.rules(), [Rule::NotAcknowledged]);
}

/// Whoever hears nothing cannot judge.
#[test]
fn a_listener_that_is_not_on_the_bus_finds_nobody_silent() {
    for (leaves, expected) in [(LinkEvent::Down, &[][..]), (LinkEvent::BusOff, &[Rule::BusOff])] {
        let mut ward = Ward::with_slave();
        ward.poll().answer().poll().poll().link(leaves).wait(60_000).link(LinkEvent::Up).wait(100);
        ward.poll().answer();
        assert_eq!(ward.rules(), expected);
    }
}
