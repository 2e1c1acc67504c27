//! What happens to a machine, by hand.

use super::Seeds;

/// Configuration in two bytes, then operations: 8 0 link up, 6 sent, 0 span tick, 4 length head a check message.
pub(super) fn dn_access() -> Seeds {
    const UP: &[u8] = &[8, 0];
    const SENT: &[u8] = &[6];
    const SECOND: &[u8] = &[0, 0xC1];
    const BUS_OFF: &[u8] = &[8, 4];
    const BACK_OFF: &[u8] = &[0, 0x82];
    const REQUEST: &[u8] = &[4, 7, 0x00];
    const RESPONSE: &[u8] = &[4, 7, 0x80];
    const RESET: &[u8] = &[9, 0, 0];
    let on_line = [UP, SENT, SECOND, SENT, SECOND].concat();
    let with = |config: [u8; 2], rest: &[&[u8]]| [&config[..], &on_line, &rest.concat()].concat();
    [
        ("on-line", with([5, 0], &[])),
        ("alone", [&[5, 0][..], UP, &[8, 9], SECOND, &[8, 9], SENT].concat()),
        ("twins-while-checking", [&[5, 0][..], UP, REQUEST, SENT].concat()),
        ("defended", with([5, 0], &[REQUEST, SENT, REQUEST, REQUEST, SENT])),
        ("segments-joined", with([5, 0], &[RESPONSE])),
        ("bus-off-held", with([5, 0], &[BUS_OFF, UP, RESET, UP, SENT])),
        ("bus-off-restart", with([5, 0x01], &[BUS_OFF, BACK_OFF, UP, SENT, SECOND, SENT, SECOND])),
        ("bus-off-while-checking", [&[5, 0x41][..], UP, BUS_OFF, BACK_OFF, UP, SENT].concat()),
        ("quick-connect", [&[5, 0x02][..], UP, SENT, REQUEST, SENT, SECOND, SENT].concat()),
        ("quick-connect-given-back", [&[5, 0x02][..], UP, SENT, SECOND, &[7], BACK_OFF, SENT].concat()),
        ("given-back", [&[5, 0][..], UP, &[7], BACK_OFF, SENT].concat()),
        ("who", with([5, 0], &[RESPONSE, &[5, 0x30, 0x3F], &[10], SENT, &[5, 0x30, 0x45], &[11, 10]])),
        ("identify", with([5, 0], &[RESPONSE, &[5, 1, 0x3F], SENT, &[5, 2, 0], SENT, &[0, 0xFC]])),
        ("change-mac-id", with([5, 0], &[RESPONSE, &[5, 3, 0x11], SENT, SECOND, SENT, SECOND])),
        ("change-mac-id-switches", with([5, 0x08], &[RESPONSE, &[5, 3, 0x11], SENT])),
        ("power-lost", with([5, 0], &[REQUEST, &[8, 3], &[7], UP, SENT])),
        ("bad-length", with([5, 0x04], &[&[4, 3, 0x80], &[4, 0, 0], &[4, 8, 0x80]])),
        ("late-ticks", with([5, 0], &[REQUEST, &[1, 0xC5], &[2, 0xC3], RESET, SENT, &[1, 0xC5], &[11, 10]])),
    ]
    .map(|(name, bytes)| (name.to_owned(), bytes))
    .to_vec()
}

/// Choices in two bytes, then operations: 9 0 link up, 7 0 sent, 2 the next deadline, 4 an answer of a slave.
pub(super) fn dn_master() -> Seeds {
    const SENT: &[u8] = &[7, 0];
    let on_line: &[u8] = &[9, 0, 7, 0, 2, 7, 0, 2];
    let round = |how: u8| [SENT, &[4, 0, how], SENT, &[4, 1, how], SENT, &[4, 2, how]].concat();
    let bring_up = round(0).repeat(11);
    // Poll frames of two fragments, a strobe response, a change, a poll response.
    let data: &[u8] = &[5, 0, 0, 9, 5, 0, 0x41, 9, 5, 0, 0x82, 9, 5, 5, 0, 1, 5, 10, 0, 3, 5, 1, 0, 4];
    let polls = [&[10, 0, 0x21][..], data, &SENT.repeat(4), &[2], data, &SENT.repeat(6), &[2]].concat();
    let with = |choices: u8, rest: &[&[u8]]| [&[choices, 0][..], on_line, &rest.concat()].concat();
    [
        ("bring-up", with(0, &[&bring_up])),
        ("configuration", with(0x42, &[&bring_up, &round(0).repeat(4)])),
        ("ucmm", with(0x04, &[&bring_up, &round(0).repeat(3)])),
        ("exchange", with(0, &[&bring_up, &polls, &polls])),
        ("without-pause", with(0x30, &[&bring_up, &polls, &polls])),
        ("lost", with(0, &[&bring_up, &polls, &[0, 0xC1, 0, 0xC1], &bring_up])),
        ("wrong-device", with(0, &[&round(0), &round(8).repeat(3)])),
        ("earlier-life", with(0, &[&round(9), &round(0).repeat(3), &round(9), &round(0).repeat(6)])),
        ("of-another-master", with(0, &[&round(10), &[2], &round(10)])),
        ("given-back", with(0, &[&bring_up, &[8, 0, 8, 1, 2, 8, 0, 8, 0, 2, 8, 0]])),
        ("off-line", with(1, &[&bring_up, &polls, &[9, 3, 7, 0, 7, 0, 7, 0, 0, 0x83, 9, 0], on_line])),
        ("removed", with(0, &[&bring_up, &[12, 1, 0], SENT, &[12, 2, 0], SENT, &[2], &round(0)])),
        ("asked", with(0, &[&bring_up, &[11, 0, 3], &round(0), &[11, 0, 30], &round(0).repeat(6)])),
        ("restarts", with(0, &[&bring_up, &[6, 0x41, 0, 0, 0xC1, 6, 0x41, 0, 0, 0xC1, 2, 2]])),
        ("replacement", with(0x08, &[&[0, 0xC1, 7, 0].repeat(20), &round(0).repeat(3)])),
    ]
    .map(|(name, bytes)| (name.to_owned(), bytes))
    .to_vec()
}

/// Operations: 9 0 link up, 7 0 sent, 2 the next deadline, 10 a command.
pub(super) fn dn_tool() -> Seeds {
    let on_line: &[u8] = &[9, 0, 7, 0, 2, 7, 0, 2];
    let owner: &[u8] = &[10, 0, 7, 0, 2, 7, 0, 2];
    let with = |rest: &[&[u8]]| [on_line, &rest.concat()].concat();
    [
        ("who", with(&[owner, &[10, 3, 7, 0, 5, 0, 5, 3, 2]])),
        ("identify", with(&[owner, &[10, 4, 7, 0, 5, 1, 2, 10, 5, 7, 0, 2]])),
        ("recovered", with(&[owner, &[10, 6, 7, 0, 6, 0, 0, 0, 0xC1, 6, 0, 0, 2]])),
        ("taken", with(&[owner, &[10, 6, 6, 2, 0x80, 8, 0, 10, 3, 7, 0, 2]])),
        ("own-mac-id", with(&[owner, &[10, 0x86]])),
        ("defended", with(&[&[10, 0, 7, 0, 4, 0, 2, 7, 0, 7, 0, 4, 0, 2, 7, 0, 4, 0, 7, 0]])),
        ("owned-by-another", with(&[&[10, 0, 7, 0, 4, 1, 10, 0, 4, 0, 7, 0, 4, 1], owner, &[4, 1]])),
        ("given-back", with(&[&[10, 0, 8, 0, 2, 8, 0, 2, 7, 0, 2, 8, 0, 2, 7, 0, 2]])),
        ("collision", with(&[&[10, 0, 9, 5, 8, 0, 2, 9, 5, 7, 0, 2, 7, 0, 2]])),
        ("released", with(&[owner, &[10, 3, 10, 2, 10, 0, 7, 0, 2, 7, 0, 2, 7, 0, 2]])),
        ("off-line", with(&[owner, &[10, 3, 6, 1, 0x80, 7, 0, 10, 7, 7, 0, 2, 7, 0, 2]])),
    ]
    .map(|(name, bytes)| (name.to_owned(), bytes))
    .to_vec()
}

/// Choices in one byte, then operations: 9 0 link up, 7 0 sent, 2 the next deadline, 4 a Hello, 5 an answer, 6 data, 10 a command.
pub(super) fn nx_manager() -> Seeds {
    const SENT: &[u8] = &[7, 0];
    let on_line: &[u8] = &[9, 0, 7, 0, 2, 7, 0, 2];
    // The producer, two consumers and their answers, each with its own identity.
    let answers: &[u8] = &[5, 1, 0, 5, 0, 8, 5, 2, 12];
    let running = [SENT, answers].concat().repeat(20);
    // Nobody answers; a Mini-who, three Hellos without an address, ROAMs, and Hellos with one.
    let silent = [&SENT.repeat(4)[..], &[2, 2, 2, 2], SENT].concat();
    let hellos: &[u8] = &[4, 0, 0, 4, 1, 0, 4, 2, 0, 4, 3, 0];
    let with_address: &[u8] = &[4, 0, 3, 4, 2, 2, 4, 3, 4];
    let joined = [&[2, 2, 2][..], with_address, &[0, 0xC3], &running].concat();
    let fresh = [&silent[..], hellos, &SENT.repeat(4), with_address, &joined].concat();
    // The producer falls silent: seconds pass, its spare answers, and gets the address.
    let replaced =
        [&SENT.repeat(2)[..], &[0, 0xC1, 7, 0, 0, 0xC1, 7, 0, 7, 0, 4, 1, 0, 7, 0, 4, 1, 3, 0, 0xC3]]
            .concat();
    let with = |choices: u8, rest: &[&[u8]]| [&[choices][..], on_line, &rest.concat()].concat();
    [
        ("a-running-plant", with(0, &[&running])),
        ("a-fresh-plant", with(0, &[&fresh])),
        ("a-spare", with(0, &[&running, &[6, 1, 7], &replaced, &running])),
        ("learning", with(2, &[&silent, &[4, 5, 0, 7, 0, 4, 4, 0x85, 7, 0], &running])),
        ("another-manager", with(0x10, &[&running, &[11, 1, 0, 0xFF, 11, 0xF0, 12, 3, 0, 0xE0], &running])),
        ("a-stranger", with(0, &[&silent, &[4, 5, 0x83, 0, 0xCC], SENT, &[5, 1, 20], &running])),
        (
            "commands",
            with(
                0,
                &[
                    &running,
                    &[10, 0, 1, 10, 1, 1, 10, 6, 0, 7, 0, 5, 0, 0, 10, 8, 3, 7, 0, 5, 3, 0, 7, 0, 5, 3, 0],
                ],
            ),
        ),
        ("off-line-and-back", with(1, &[&running, &[9, 2, 9, 0, 9, 3, 0, 0xC1, 9, 0], SENT, &running])),
    ]
    .map(|(name, bytes)| (name.to_owned(), bytes))
    .into()
}
