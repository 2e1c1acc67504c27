//! I/O: pairing, sizes, fragments.

use super::*;

#[test]
fn a_poll_is_answered_or_missed() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.establish(10, 2, 1000);
    let command = bus.group2(10, 5, &[3]);
    assert_eq!((command.text.as_str(), command.problem), ("poll 10 <- 1  03", None));
    let heard = bus.group1(15, 10, &[1, 2]);
    assert_eq!((heard.text.as_str(), heard.answers()), ("poll 10 -> 1  01 02", Some(command.n)));
    let missed = bus.group2(10, 5, &[3]).n;
    assert_eq!(bus.group2(10, 5, &[3]).problem, Some(Problem::Flaw(Flaw::PollUnanswered { n: missed })));
    bus.group1(15, 10, &[1, 2]);
    assert_eq!(bus.group1(15, 10, &[1, 2]).problem, Some(Problem::Flaw(Flaw::UnexpectedIoResponse)));
}

#[test]
fn polls_of_an_unknown_connection_are_not_missed_before_it_answers() {
    let mut bus = Bus::new();
    assert_eq!(bus.group2(10, 5, &[]).problem, None);
    assert_eq!(bus.group2(10, 5, &[]).problem, None);
    let heard = bus.group1(15, 10, &[]);
    assert!(heard.assumed && heard.problem.is_none());
    let record = bus.connection(10, Predefined::Poll);
    assert_eq!((record.state, record.assumed), (ConnectionState::Established, true));
    bus.group2(10, 5, &[]);
    assert!(bus.group2(10, 5, &[]).problem.is_some());
}

#[test]
fn the_first_response_of_a_recording_has_lost_its_command() {
    let mut bus = Bus::new();
    let heard = bus.group1(15, 10, &[1]);
    assert_eq!((heard.problem, heard.assumed), (None, true));
}

#[test]
fn a_length_that_is_not_the_size() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.monitor.set_io_sizes(mac(10), Predefined::Poll, Some(2), Some(3));
    bus.establish(10, 2, 1000);
    assert_eq!(
        bus.group2(10, 5, &[1]).problem,
        Some(Problem::Flaw(Flaw::IoLength { expected: 2, found: 1 }))
    );
    assert_eq!(
        bus.group2(10, 5, &[]).problem,
        None,
        "idle is valid, and a wrong length need not be answered"
    );
    assert_eq!(
        bus.group1(15, 10, &[1, 2, 3, 4]).problem,
        Some(Problem::Flaw(Flaw::IoLength { expected: 3, found: 4 }))
    );
}

/// A slave may ignore it, and then its watchdog runs on; or take it, and then the answer tells.
#[test]
fn a_poll_of_another_length_restarts_the_watchdog_if_it_is_answered() {
    for (is_answered, state) in [(false, ConnectionState::TimedOut), (true, ConnectionState::Established)] {
        let mut bus = Bus::with_slave(10, 0x03);
        bus.monitor.set_io_sizes(mac(10), Predefined::Poll, Some(2), Some(1));
        bus.establish(10, 2, 100);
        bus.group2(10, 5, &[1, 2]);
        bus.group1(15, 10, &[3]);
        let wrong = bus.wait(300).group2(10, 5, &[1]);
        if is_answered {
            let heard = bus.group1(15, 10, &[3]);
            assert_eq!((heard.answers(), heard.problem), (Some(wrong.n), None));
        }
        bus.wait(200).group2(11, 5, &[]);
        assert_eq!(bus.state(10, Predefined::Poll), state);
    }
}

#[test]
fn a_strobe_of_another_length_is_ignored_by_all() {
    let mut bus = Bus::with_slave(5, 0x05);
    bus.establish(5, 3, 100);
    let strobe = bus.group2(1, 0, &[0; 8]);
    bus.wait(300).group2(1, 0, &[0; 7]);
    assert_eq!(bus.group1(14, 5, &[7]).answers(), Some(strobe.n), "which is later than usual");
    bus.group2(1, 0, &[0; 7]);
    assert_eq!(bus.group1(14, 5, &[7]).problem, Some(Problem::Flaw(Flaw::UnexpectedIoResponse)));
    bus.wait(100).group2(11, 5, &[]);
    assert_eq!(bus.state(5, Predefined::BitStrobe), ConnectionState::TimedOut);
}

#[test]
fn a_multicast_poll_of_another_length_need_not_be_answered() {
    for is_answered in [false, true] {
        let mut bus = Bus::with_slave(10, 0x09);
        bus.monitor.set_io_sizes(mac(10), Predefined::MulticastPoll, Some(2), Some(1));
        bus.establish(10, 5, 100);
        bus.group2(1, 1, &[1, 2]);
        bus.group1(12, 10, &[3]);
        let wrong = bus.wait(300).group2(1, 1, &[1]);
        assert_eq!(wrong.problem, Some(Problem::Flaw(Flaw::IoLength { expected: 2, found: 1 })));
        if is_answered {
            assert_eq!(bus.group1(12, 10, &[3]).answers(), Some(wrong.n));
        }
        let expected = if is_answered { ConnectionState::Established } else { ConnectionState::TimedOut };
        bus.wait(200).group2(11, 5, &[]);
        assert_eq!(bus.state(10, Predefined::MulticastPoll), expected);
        assert_eq!(bus.group2(1, 1, &[1, 2]).problem, None);
    }
}

/// Without acknowledges nothing restarts the watchdog of instance 4, and it has none.
#[test]
fn changes_without_acknowledges_do_not_time_out() {
    let mut bus = Bus::with_slave(10, 0x51);
    bus.establish(10, 4, 1000);
    bus.group1(13, 10, &[1]);
    bus.wait(60_000).group2(11, 5, &[]);
    assert_eq!(bus.state(10, Predefined::CosCyclic), ConnectionState::Established);
    assert_eq!(bus.node(10).master, Some(mac(1)), "its owner could be dead");
}

#[test]
fn every_slave_answers_a_strobe() {
    let mut bus = Bus::new();
    for slave in [5, 9] {
        bus.group2(slave, 6, &[0x01, 0x4B, 3, 1, 0x05, 1]);
        bus.group2(slave, 3, &[0x01, 0xCB, 0]);
        bus.establish(slave, 3, 1000);
    }
    let strobe = bus.group2(1, 0, &[0x20, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(strobe.text, "bit-strobe * <- 1  20 00 00 00 00 00 00 00");
    let heard = bus.group1(14, 5, &[7]);
    assert_eq!((heard.text.as_str(), heard.answers()), ("bit-strobe 5 -> 1  07", Some(strobe.n)));
    assert_eq!(bus.group1(14, 9, &[8]).answers(), Some(strobe.n));
    assert_eq!(bus.group2(1, 0, &[]).problem, None);
    bus.group1(14, 9, &[8]);
    let heard = bus.group2(1, 0, &[]);
    assert_eq!(heard.problem, Some(Problem::StrobeUnanswered { mac: mac(5), count: 1 }));
    assert_eq!(bus.group2(1, 0, &[1]).problem, Some(Problem::Flaw(Flaw::Length { expected: 8, found: 1 })));
    assert_eq!(bus.group2(2, 0, &[]).problem, None, "slaves of another master do not answer");
}

#[test]
fn a_multicast_poll_is_answered_by_its_group() {
    let mut bus = Bus::with_slave(10, 0x09);
    bus.establish(10, 5, 1000);
    let command = bus.group2(1, 1, &[1, 2]);
    assert_eq!((command.kind, command.src), (Kind::MulticastPollCommand, Some(1)));
    let heard = bus.group1(12, 10, &[3]);
    assert_eq!((heard.kind, heard.answers()), (Kind::MulticastPollResponse, Some(command.n)));
}

#[test]
fn change_of_state_is_acknowledged() {
    let mut bus = Bus::with_slave(10, 0x11);
    bus.establish(10, 4, 1000);
    let data = bus.group1(13, 10, &[1]);
    assert_eq!((data.text.as_str(), data.problem), ("COS/cyclic 10 -> 1  01", None));
    let heard = bus.group2(10, 2, &[]);
    assert_eq!((heard.text.as_str(), heard.answers()), ("COS/cyclic ack 10 <- 1", Some(data.n)));
    let data = bus.group1(13, 10, &[2]);
    assert_eq!(bus.group1(13, 10, &[2]).problem, Some(Problem::Flaw(Flaw::Unacknowledged { n: data.n })));
    // Without the poll bit, instance 2 is the master's direction.
    let data = bus.group2(10, 5, &[4]);
    assert_eq!(
        (data.kind, data.text.as_str()),
        (Kind::CosCyclic, "COS/cyclic 10 <- 1  04 (connection configuring)")
    );
    bus.establish(10, 2, 1000);
    let data = bus.group2(10, 5, &[4]);
    let heard = bus.group1(15, 10, &[]);
    assert_eq!((heard.kind, heard.answers()), (Kind::CosCyclicAck, Some(data.n)));
}

#[test]
fn suppressed_acknowledges_are_not_missed() {
    let mut bus = Bus::with_slave(10, 0x51);
    bus.establish(10, 4, 1000);
    bus.establish(10, 2, 1000);
    for _ in 0..3 {
        assert_eq!(bus.wait(1000).group1(13, 10, &[1]).problem, None);
        assert_eq!(bus.group2(10, 5, &[]).problem, None);
    }
    assert_eq!(bus.state(10, Predefined::CosCyclic), ConnectionState::Established);
}

#[test]
fn fragments_of_a_known_size_are_put_together() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.monitor.set_io_sizes(mac(10), Predefined::Poll, Some(10), None);
    bus.establish(10, 2, 1000);
    assert_eq!(
        bus.group2(10, 5, &[0x00, 1, 2, 3, 4, 5, 6, 7]).text,
        "poll 10 <- 1  first fragment 0  01 02 03 04 05 06 07"
    );
    let heard = bus.group2(10, 5, &[0x81, 8, 9, 10]);
    assert_eq!(heard.message.as_deref(), Some(&[1, 2, 3, 4, 5, 6, 7, 8, 9, 10][..]));
    assert_eq!(bus.group1(15, 10, &[]).answers(), Some(heard.n), "the last fragment is the command");
    assert_eq!(
        bus.group2(10, 5, &[0x82, 1]).problem,
        Some(Problem::Flaw(Flaw::NoFirstFragment { found: 2 }))
    );
    assert_eq!(bus.group2(10, 5, &[]).message.as_deref(), Some(&[][..]), "idle has no fragmentation byte");
    assert_eq!(bus.group2(10, 5, &[0xC0]).problem.map(|problem| problem.code()), Some("reserved_value"));
}

#[test]
fn fragments_of_an_unknown_size_are_guessed_from_the_second_on() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.establish(10, 2, 1000);
    let heard = bus.group2(10, 5, &[0x00, 1, 2, 3, 4, 5, 6, 7]);
    assert_eq!((heard.message, heard.assumed), (None, false));
    let heard = bus.group2(10, 5, &[0x81, 8]);
    assert_eq!((heard.problem, heard.assumed), (None, true));
    assert_eq!(heard.message.as_deref(), Some(&[1, 2, 3, 4, 5, 6, 7, 8][..]));
    assert_eq!(bus.group1(15, 10, &[]).answers(), Some(heard.n));
    let heard = bus.group2(10, 5, &[0x00, 1, 2, 3, 4, 5, 6, 7]);
    assert!(heard.text.contains("first fragment 0"), "{}", heard.text);
    // Data that contradict: it was a guess, and is given up without a problem.
    let heard = bus.group2(10, 5, &[0x55, 1]);
    assert_eq!((heard.problem, heard.message), (None, None));
    assert_eq!(heard.text, "poll 10 <- 1  55 01 (assumed)");
}

#[test]
fn the_guess_can_be_switched_off() {
    let config = MonitorConfig { fragmentation: FragmentationGuess::Off };
    let mut bus = Bus { monitor: Box::new(Monitor::new(config)), now: 0, n: 0 };
    bus.group2(10, 5, &[0x00, 1, 2, 3, 4, 5, 6, 7]);
    assert_eq!(bus.group2(10, 5, &[0x81, 8]).message, None);
}

/// Data that look like two fragments, but were answered one by one.
#[test]
fn an_answer_between_two_frames_says_that_they_are_messages() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.establish(10, 2, 1000);
    bus.group2(10, 5, &[0x00, 1, 2, 3, 4, 5, 6, 7]);
    bus.group1(15, 10, &[]);
    let command = bus.group2(10, 5, &[0x41, 1, 2, 3, 4, 5, 6, 7]);
    assert_eq!((command.message, command.assumed), (None, false));
    let heard = bus.group1(15, 10, &[]);
    assert_eq!((heard.problem, heard.answers()), (None, Some(command.n)));
}

/// The frame that has established the connection is missing from the recording.
#[test]
fn a_slave_that_answers_is_established() {
    let mut bus = Bus::with_slave(10, 0x03);
    let command = bus.group2(10, 5, &[1]);
    let heard = bus.group1(15, 10, &[2]);
    assert_eq!((heard.problem, heard.answers()), (None, Some(command.n)));
    assert_eq!(heard.note, Some(Note::NoConnection(ConnectionState::Configuring)));
    assert!(heard.assumed);
    let heard = bus.group2(10, 5, &[1]);
    assert_eq!((heard.note, heard.problem), (None, None));
    assert_eq!(bus.group1(15, 10, &[2]).note, None);
}

#[test]
fn a_poll_before_the_packet_rate_is_set_is_not_missed() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.group2(10, 5, &[1]);
    bus.establish(10, 2, 1000);
    assert_eq!(bus.group2(10, 5, &[1]).problem, None);
}

#[test]
fn multicast_groups_are_kept_apart() {
    let mut bus = Bus::new();
    for (slave, group) in [(5, 20_u16), (9, 21)] {
        bus.group2(slave, 6, &[0x01, 0x4B, 3, 1, 0x09, 1]);
        bus.group2(slave, 3, &[0x01, 0xCB, 0]);
        let [low, high] = (0x401 | group << 3).to_le_bytes();
        bus.group2(slave, 4, &[0x01, 0x10, 5, 5, 5, low, high]);
        bus.group2(slave, 3, &[0x01, 0x90]);
        bus.establish(slave, 5, 1000);
    }
    let first = bus.group2(20, 1, &[1]);
    let second = bus.group2(21, 1, &[2]);
    assert_eq!(first.text, "multicast poll * <- 1  01");
    assert_eq!(bus.group1(12, 5, &[3]).answers(), Some(first.n));
    assert_eq!(bus.group1(12, 9, &[4]).answers(), Some(second.n));
    assert_eq!(bus.group2(20, 1, &[1]).problem, None);
    let heard = bus.group2(20, 1, &[1]);
    assert_eq!(heard.problem, Some(Problem::MulticastPollUnanswered { mac: mac(5), count: 1 }));
    assert!(heard.text.ends_with("! no response to the multicast poll before from 5"), "{}", heard.text);
    assert_eq!(bus.group2(21, 1, &[1]).problem, None, "it has answered");
}

/// A group that was set before the recording began.
#[test]
fn the_answers_tell_the_multicast_group() {
    let mut bus = Bus::with_slave(10, 0x09);
    bus.establish(10, 5, 1000);
    let command = bus.group2(20, 1, &[1]);
    assert_eq!(command.src, None);
    assert_eq!(bus.group1(12, 10, &[2]).answers(), Some(command.n));
    let command = bus.group2(20, 1, &[1]);
    assert_eq!((command.src, command.problem), (Some(1), None));
    assert!(bus.group2(20, 1, &[1]).problem.is_some());
}

#[test]
fn fragments_beyond_the_connection_size() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.monitor.set_io_sizes(mac(10), Predefined::Poll, Some(10), None);
    bus.establish(10, 2, 1000);
    bus.group2(10, 5, &[0x00, 1, 2, 3, 4, 5, 6, 7]);
    let heard = bus.group2(10, 5, &[0x81, 8, 9, 10, 11]);
    assert_eq!((heard.problem, heard.message), (Some(Problem::Flaw(Flaw::TooLong { limit: 10 })), None));
    assert!(heard.text.ends_with("! longer than the connection size of 10 bytes"), "{}", heard.text);
}

#[test]
fn fragments_of_a_multicast_poll_are_put_together() {
    let mut bus = Bus::with_slave(10, 0x09);
    bus.monitor.set_io_sizes(mac(10), Predefined::MulticastPoll, Some(10), None);
    bus.establish(10, 5, 1000);
    let first = bus.group2(1, 1, &[0x00, 1, 2, 3, 4, 5, 6, 7]);
    assert_eq!(first.text, "multicast poll * <- 1  first fragment 0  01 02 03 04 05 06 07");
    let last = bus.group2(1, 1, &[0x81, 8, 9, 10]);
    assert_eq!(last.message.as_deref(), Some(&[1, 2, 3, 4, 5, 6, 7, 8, 9, 10][..]));
    let heard = bus.group1(12, 10, &[2]);
    assert_eq!((heard.answers(), heard.problem), (Some(last.n), None), "the last fragment is the command");
    bus.group2(1, 1, &[0x00, 1, 2, 3, 4, 5, 6, 7]);
    assert_eq!(
        bus.group2(1, 1, &[0x82, 8]).problem,
        Some(Problem::Flaw(Flaw::OutOfSequence { after: 0, found: 2 }))
    );
    assert_eq!(bus.group2(1, 1, &[]).problem, None, "the one before was answered");
    let heard = bus.group2(1, 1, &[]);
    assert_eq!(heard.problem, Some(Problem::MulticastPollUnanswered { mac: mac(10), count: 1 }));
}

#[test]
fn fragments_of_a_multicast_poll_of_unknown_size_are_guessed() {
    let mut bus = Bus::with_slave(10, 0x09);
    bus.establish(10, 5, 1000);
    bus.group2(1, 1, &[0x00, 1, 2, 3, 4, 5, 6, 7]);
    let heard = bus.group2(1, 1, &[0x41, 1, 2, 3, 4, 5, 6, 7]);
    assert_eq!((heard.problem, heard.message), (None, None), "not two commands, the first unanswered");
    let last = bus.group2(1, 1, &[0x82, 8]);
    assert_eq!((last.problem, last.message.map(|data| data.len()), last.assumed), (None, Some(15), true));
    assert_eq!(bus.group1(12, 10, &[2]).answers(), Some(last.n));
}

/// Data that look like two fragments, but were answered one by one.
#[test]
fn a_multicast_poll_that_was_answered_is_a_message() {
    let mut bus = Bus::with_slave(10, 0x09);
    bus.establish(10, 5, 1000);
    bus.group2(1, 1, &[0x00, 1, 2, 3, 4, 5, 6, 7]);
    bus.group1(12, 10, &[2]);
    let heard = bus.group2(1, 1, &[0x81, 1]);
    assert_eq!((heard.message, heard.assumed), (None, false));
}

/// A slave produces at once when its connection is established, and Group 1 comes before its answer in Group 2.
#[test]
fn the_first_change_of_state_comes_before_the_answer_that_establishes_the_connection() {
    for set in [&[0x01, 0x10, 5, 4, 9, 0xE8, 0x03][..], &[0x01, 0x0D, 5, 4]] {
        let mut bus = Bus::with_slave(10, 0x11);
        bus.group2(10, 4, set);
        let first = bus.group1(13, 10, &[1]);
        assert_eq!((first.text.as_str(), first.note, first.assumed), ("COS/cyclic 10 -> 1  01", None, false));
        assert_eq!(bus.state(10, Predefined::CosCyclic), ConnectionState::Established);
        assert_eq!(bus.group2(10, 3, &[0x01, set[1] | 0x80]).problem, None);
        assert_eq!(bus.group2(10, 2, &[]).answers(), Some(first.n));
        assert_eq!(bus.state(10, Predefined::CosCyclic), ConnectionState::Established);
    }
    // Another request establishes nothing.
    let mut bus = Bus::with_slave(10, 0x11);
    bus.group2(10, 4, &[0x01, 0x10, 5, 2, 9, 0xE8, 0x03]);
    let first = bus.group1(13, 10, &[1]);
    assert_eq!(first.note, Some(Note::NoConnection(ConnectionState::Configuring)));
}
