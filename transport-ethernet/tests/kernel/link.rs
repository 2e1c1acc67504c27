//! Interfaces that go down, lose their cable, are unplugged, and come back.

use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use link_core::ethernet::{LinkEvent, Port as _};
use transport_ethernet::{Error, EthernetPort};

use crate::namespace::ip;
use crate::rig::{Cable, Heard, OPTIONS, frame, heard, port, silent, wait};

const UP: Heard = Heard::Link(LinkEvent::Up);
const DOWN: Heard = Heard::Link(LinkEvent::Down);
const NOT_SENT: Heard = Heard::Link(LinkEvent::NotSent);
const ROUNDS: usize = 50;

#[track_caller]
fn works(from: &mut EthernetPort, to: &mut EthernetPort, payload: &[u8]) {
    from.transmit(&frame(payload)).unwrap();
    assert_eq!(heard(to), Heard::Frame(frame(payload)));
}

/// One end is down, so the other has no cable: both hear of it, behind the frames that came before.
#[test]
#[ignore = "needs a namespace"]
fn both_ends_hear_of_a_cut_cable_and_work_again() {
    let cable = Cable::new("cu0", "cu1");
    let (mut one, mut other) = (port(cable.0, OPTIONS), port(cable.1, OPTIONS));
    for round in 0..3_u8 {
        works(&mut one, &mut other, &[round]);
        one.transmit(&frame(b"before the cut")).unwrap();
        cable.set(1, "down");
        assert_eq!([heard(&mut other), heard(&mut other)], [Heard::Frame(frame(b"before the cut")), DOWN]);
        assert_eq!(heard(&mut one), DOWN);
        one.transmit(&frame(b"lost")).unwrap();
        assert_eq!(heard(&mut one), NOT_SENT);
        other.transmit(&frame(b"lost")).unwrap();
        assert_eq!(heard(&mut other), NOT_SENT);
        silent(&mut one);
        silent(&mut other);
        cable.set(1, "up");
        assert_eq!([heard(&mut other), heard(&mut one)], [UP, UP]);
        works(&mut other, &mut one, &[round]);
    }
}

/// A frame that is sent before anybody has looked at the interface.
#[test]
#[ignore = "needs a namespace"]
fn what_cannot_be_sent_is_told() {
    let cable = Cable::new("se0", "se1");
    let mut one = port(cable.0, OPTIONS);
    cable.set(0, "down");
    one.transmit(&frame(b"lost")).unwrap();
    assert_eq!([heard(&mut one), heard(&mut one)], [NOT_SENT, DOWN]);
}

/// The kernel tells it twice, and in any order: by its news, and by the error of the socket.
#[test]
#[ignore = "needs a namespace"]
fn an_interface_that_goes_down_under_traffic_is_told_once() {
    let cable = Cable::new("on0", "on1");
    let mut one = port(cable.0, OPTIONS);
    let _other = port(cable.1, OPTIONS);
    let (is_up, goes_on) = mpsc::channel();
    let mut told = Vec::new();
    thread::scope(|scope| {
        let cable = &cable;
        let rounds = scope.spawn(move || {
            for _ in 0..ROUNDS {
                cable.set(0, "down");
                cable.set(0, "up");
                goes_on.recv().unwrap();
            }
        });
        while !rounds.is_finished() {
            match wait(&mut one, Duration::from_micros(50)) {
                Heard::Nothing => one.transmit(&frame(b"traffic")).unwrap(),
                NOT_SENT => {}
                heard => {
                    if heard == UP {
                        // Nobody waits any more if there were more of them than rounds.
                        let _ = is_up.send(());
                    }
                    told.push(heard);
                }
            }
        }
    });
    assert_eq!(told, vec![[DOWN, UP]; ROUNDS].concat());
}

#[test]
#[ignore = "needs a namespace"]
fn an_adapter_that_was_unplugged_is_found_by_its_name() {
    let cable = Cable::new("un0", "un1");
    let (mut one, mut other) = (port(cable.0, OPTIONS), port(cable.1, OPTIONS));
    cable.unplug();
    assert_eq!([heard(&mut one), heard(&mut other)], [DOWN, DOWN]);
    cable.plug();
    assert_eq!([heard(&mut one), heard(&mut other)], [UP, UP]);
    works(&mut one, &mut other, b"again");
    works(&mut other, &mut one, b"again");
}

#[test]
#[ignore = "needs a namespace"]
fn an_interface_that_is_down_is_waited_for() {
    let cable = Cable::new("wa0", "wa1");
    cable.set(0, "down");
    let mut one = EthernetPort::open(cable.0, OPTIONS).unwrap();
    assert!(!one.interface().has_link());
    silent(&mut one);
    cable.set(0, "up");
    assert_eq!(heard(&mut one), UP);
    works(&mut one, &mut port(cable.1, OPTIONS), b"up");
}

/// What comes and goes elsewhere is no news.
#[test]
#[ignore = "needs a namespace"]
fn other_interfaces_do_not_matter() {
    let cable = Cable::new("el0", "el1");
    let mut one = port(cable.0, OPTIONS);
    let other = Cable::new("el2", "el3");
    other.set(0, "down");
    drop(other);
    silent(&mut one);
}

#[test]
#[ignore = "needs a namespace"]
fn another_adapter_in_its_place_is_not_taken_for_it() {
    let cable = Cable::new("pl0", "pl1");
    let mut one = port(cable.0, OPTIONS);
    cable.set(0, "down");
    ip(&["link", "set", cable.0, "address", "02:00:00:00:00:99"]);
    cable.set(0, "up");
    let error = loop {
        match one.wait(None) {
            Ok(_) => {}
            Err(error) => break error,
        }
    };
    assert!(matches!(&error, Error::OtherAddress { is, .. } if is.0 == [2, 0, 0, 0, 0, 0x99]), "{error}");
}
