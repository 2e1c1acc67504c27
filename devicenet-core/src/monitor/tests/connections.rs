//! Allocation, states, owners.

use super::*;

#[test]
fn a_poll_connection_from_allocation_to_release() {
    let mut bus = Bus::with_slave(10, 0x03);
    assert_eq!(bus.state(10, Predefined::Explicit), ConnectionState::Established);
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::Configuring);
    let heard = bus.group2(10, 5, &[1]);
    assert_eq!(heard.note, Some(Note::NoConnection(ConnectionState::Configuring)), "the slave ignores it");
    bus.establish(10, 2, 100);
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::Established);
    let node = bus.node(10);
    assert_eq!((node.master, node.choice.map(|choice| choice.bits())), (Some(mac(1)), Some(0x03)));
    assert_eq!(node.roles, Roles::SLAVE);
    assert_eq!(bus.node(1).roles, Roles::MASTER);

    bus.group2(10, 4, &[0x01, 0x4C, 3, 1, 0x02]);
    bus.group2(10, 3, &[0x01, 0xCC]);
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::NonExistent);
    assert_eq!(bus.node(10).choice.map(|choice| choice.bits()), Some(0x01));
    bus.group2(10, 6, &[0x01, 0x4C, 3, 1, 0x01]);
    bus.group2(10, 3, &[0x01, 0xCC]);
    assert_eq!((bus.node(10).master, bus.node(10).choice), (None, None));
    let states: Vec<_> = bus.connection(10, Predefined::Poll).states().collect();
    let expected = [ConnectionState::NonExistent, ConnectionState::Configuring, ConnectionState::Established];
    assert_eq!(states, expected);
}

#[test]
fn io_does_not_stay_configuring_without_the_explicit_connection() {
    let mut bus = Bus::with_slave(10, 0x07);
    bus.establish(10, 3, 0);
    bus.wait(10_010).group2(11, 5, &[]);
    let record = bus.connection(10, Predefined::Poll);
    assert_eq!((record.state, record.assumed), (ConnectionState::NonExistent, true));
    let node = bus.node(10);
    assert_eq!((node.master, node.choice.map(|choice| choice.bits())), (Some(mac(1)), Some(0x04)));
    let heard = bus.group2(10, 5, &[]);
    assert_eq!(heard.note, Some(Note::NoConnection(ConnectionState::NonExistent)));
    // It was released: the same.
    let mut bus = Bus::with_slave(10, 0x03);
    bus.group2(10, 6, &[0x01, 0x4C, 3, 1, 0x01]);
    bus.group2(10, 3, &[0x01, 0xCC]);
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::NonExistent);
    assert_eq!(bus.node(10).master, None);
}

#[test]
fn the_ownership_lapses_with_the_last_connection_and_comes_back_with_it() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.establish(10, 2, 1000);
    bus.group2(10, 5, &[1]);
    bus.wait(4_010).group2(11, 5, &[]);
    let node = bus.node(10);
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::TimedOut);
    assert_eq!((node.master, node.choice.map(|choice| choice.bits())), (Some(mac(1)), Some(0x01)));
    bus.wait(6_000).group2(11, 5, &[]);
    let node = bus.node(10);
    assert_eq!((node.master, node.choice), (None, None));
    assert_eq!(bus.connection(10, Predefined::Poll).client, None);
    assert_eq!(bus.group2(10, 5, &[1]).src, None);
    // It answers: frames are missing in the recording.
    bus.group1(15, 10, &[2]);
    assert_eq!(bus.group2(10, 5, &[1]).src, Some(1));
    let node = bus.node(10);
    assert_eq!((node.master, node.choice.map(|choice| choice.bits())), (Some(mac(1)), Some(0x02)));
}

/// Timed out, it can be read until somebody allocates.
#[test]
fn an_allocation_after_the_ownership_has_lapsed_deletes_what_has_timed_out() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.establish(10, 2, 100);
    bus.group2(10, 5, &[1]);
    bus.wait(20_000).group2(10, 6, &[0x02, 0x4B, 3, 1, 0x01, 2]);
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::TimedOut);
    bus.group2(10, 3, &[0x02, 0xCB, 0]);
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::NonExistent);
    let node = bus.node(10);
    assert_eq!((node.master, node.choice.map(|choice| choice.bits())), (Some(mac(2)), Some(0x01)));
}

/// Allocated through a connection of UCMM, I/O waits for its packet rate as long as that is open.
#[test]
fn the_connection_of_ucmm_keeps_what_was_allocated_through_it() {
    let mut bus = Bus::new();
    let check = [0x00, 0x34, 0x12, 0x45, 0x23, 0x00, 0x00];
    bus.group2(63, 7, &check);
    bus.wait(999).group2(63, 7, &check);
    bus.group3(6, 0, &[63, 0x4B, 0, 0x34]);
    bus.group3(5, 63, &[0, 0xCB, 0, 0x04, 6, 0]);
    bus.group3(4, 0, &[63, 0x4B, 3, 1, 2, 0]);
    bus.group3(4, 63, &[0, 0xCB, 0]);
    bus.wait(9_000).group2(11, 5, &[]);
    assert_eq!(bus.state(63, Predefined::Poll), ConnectionState::Configuring);
    assert_eq!(bus.node(63).master, Some(mac(0)));
    bus.group3(6, 0, &[63, 0x4C, 6, 0]);
    bus.group3(5, 63, &[0, 0xCC]);
    assert_eq!(bus.state(63, Predefined::Poll), ConnectionState::NonExistent);
    assert_eq!(bus.node(63).master, None);
}

/// Instance 2 is there for both.
#[test]
fn poll_and_change_of_state_share_an_instance() {
    let mut bus = Bus::with_slave(10, 0x11);
    bus.establish(10, 4, 1000);
    bus.establish(10, 2, 1000);
    bus.group2(10, 4, &[0x01, 0x4B, 3, 1, 0x02, 1]);
    bus.group2(10, 3, &[0x01, 0xCB, 0]);
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::Established, "poll joins it");
    bus.group2(10, 4, &[0x01, 0x4C, 3, 1, 0x02]);
    bus.group2(10, 3, &[0x01, 0xCC]);
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::Established, "poll leaves it");
    bus.group2(10, 4, &[0x01, 0x4C, 3, 1, 0x10]);
    bus.group2(10, 3, &[0x01, 0xCC]);
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::NonExistent);
}

#[test]
fn a_second_allocation_adds_to_what_still_exists() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.establish(10, 2, 100);
    bus.group2(10, 5, &[1]);
    bus.wait(20_000).group2(10, 6, &[0x01, 0x4B, 3, 1, 0x05, 1]);
    bus.group2(10, 3, &[0x01, 0xCB, 0]);
    let choice = bus.node(10).choice.map(|choice| choice.bits());
    assert_eq!(choice, Some(0x05), "poll has timed out");
}

#[test]
fn allocation_information_tells_what_was_missed() {
    let mut bus = Bus::new();
    bus.group2(10, 4, &[0x01, 0x0E, 3, 1, 5]);
    bus.group2(10, 3, &[0x01, 0x8E, 0x13, 0x01]);
    let node = bus.node(10);
    assert_eq!((node.master, node.choice.map(|choice| choice.bits())), (Some(mac(1)), Some(0x13)));
    assert!(!bus.group2(10, 5, &[]).assumed);
}

#[test]
fn attributes_that_are_read_describe_the_connection() {
    let mut bus = Bus::with_slave(10, 0x03);
    for (attribute, value) in [
        (1, &[3][..]),
        (7, &[3, 0]),
        (8, &[1, 0]),
        (9, &[75, 0]),
        (12, &[2]),
        (14, &[0x20, 0x04, 0x24, 0x65, 0x30, 0x03]),
        (17, &[10, 0]),
    ] {
        bus.group2(10, 4, &[0x01, 0x0E, 5, 2, attribute]);
        assert_eq!(bus.group2(10, 3, &[&[0x01, 0x8E], value].concat()).problem, None);
    }
    let record = bus.connection(10, Predefined::Poll);
    assert_eq!((record.state, record.assumed), (ConnectionState::Established, false));
    assert_eq!((record.produced_size, record.consumed_size, record.epr), (Some(3), Some(1), Some(75)));
    assert_eq!((record.watchdog_action, record.inhibit), (Some(2), Some(10)));
    assert_eq!(record.produced_path.map(u16::from), Some(101));
}

/// The slave of 1998 that names the identifiers of MAC ID 63 whatever its own.
#[test]
fn a_connection_that_names_another_identifier() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.group2(10, 4, &[0x01, 0x0E, 5, 2, 4]);
    let heard = bus.group2(10, 3, &[0x01, 0x8E, 0xFF, 0x03]);
    assert_eq!(heard.problem, Some(Problem::WrongConnectionId { expected: 0x3CA, found: 0x3FF }));
    bus.group2(10, 4, &[0x01, 0x0E, 5, 1, 5]);
    assert_eq!(bus.group2(10, 3, &[0x01, 0x8E, 0x54, 0x04]).problem, None);
}

#[test]
fn a_dynamic_connection_ends_by_its_close() {
    let mut bus = Bus::new();
    bus.group3(6, 2, &[20, 0x4B, 0, 0x31]);
    bus.group3(5, 20, &[2, 0xCB, 0, 0x02, 7, 0]);
    let record = bus.monitor.connections().next().unwrap();
    assert_eq!((record.server, record.client), (mac(20), Some(mac(2))));
    assert_eq!((record.state, record.epr), (ConnectionState::Established, Some(2500)));
    assert_eq!(record.name.to_string(), "group 3 instance 7");
    bus.group3(6, 2, &[20, 0x4C, 7, 0]);
    bus.group3(5, 20, &[2, 0xCC]);
    assert_eq!(bus.monitor.connections().next().unwrap().state, ConnectionState::NonExistent);
}

/// Two connections of one client at one server, in one group: each frame is on its own, whichever way it goes.
#[test]
fn a_frame_tells_which_dynamic_connection_it_is_on() {
    let mut bus = Bus::new();
    for (message, instance) in [(1, 7), (2, 8)] {
        bus.group3(6, 2, &[20, 0x4B, 0, 0x30 | message]);
        bus.group3(5, 20, &[2, 0xCB, 0, message, instance, 0]);
    }
    for (message, instance) in [(1, 7), (2, 8)] {
        let expected = DynamicConnection {
            server: mac(20),
            client: mac(2),
            instance: Some(instance.into()),
            group: 3,
            state: ConnectionState::Established,
        };
        assert_eq!(bus.group3(message, 2, &[20, 0x0E, 1, 1, 1]).dynamic, Some(expected));
        assert_eq!(bus.group3(message, 20, &[2, 0x8E, 0x34, 0x12]).dynamic, Some(expected));
    }
    assert_eq!(bus.group2(10, 4, &[0x02, 0x0E, 1, 1, 1]).dynamic, None, "of the predefined set");
}

/// I/O that is allocated through a UCMM connection, in its body format.
#[test]
fn an_allocation_through_a_dynamic_connection() {
    let mut bus = Bus::new();
    bus.group3(6, 0, &[63, 0x4B, 2, 0x34]);
    bus.group3(5, 63, &[0, 0xCB, 2, 0x04, 6, 0]);
    let heard = bus.group3(4, 0, &[63, 0x4B, 3, 0, 1, 0, 2, 0]);
    assert_eq!(heard.text, "0 -> 63  Allocate poll, master 0");
    assert_eq!(bus.group3(4, 63, &[0, 0xCB, 2]).text, "63 -> 0  Allocate: body format 16/16");
    assert_eq!(bus.state(63, Predefined::Poll), ConnectionState::Configuring);
    assert_eq!(bus.node(63).master, Some(mac(0)));
}

/// The slave would have refused it otherwise.
#[test]
fn the_allocation_of_another_master_ends_what_was_before() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.establish(10, 2, 0);
    bus.group2(10, 6, &[0x02, 0x4B, 3, 1, 0x01, 2]);
    bus.group2(10, 3, &[0x02, 0xCB, 0]);
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::NonExistent);
    assert_eq!(
        (bus.node(10).master, bus.node(10).choice.map(|choice| choice.bits())),
        (Some(mac(2)), Some(1))
    );
}

/// Attribute 5 of the class is a list of services, not the allocation.
#[test]
fn a_class_attribute_of_the_devicenet_object_is_no_allocation() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.group2(10, 4, &[0x01, 0x0E, 3, 0, 5]);
    bus.group2(10, 3, &[0x01, 0x8E, 0x00, 0x00]);
    assert_eq!(
        (bus.node(10).master, bus.node(10).choice.map(|choice| choice.bits())),
        (Some(mac(1)), Some(3))
    );
}

#[test]
fn delete_of_the_class_ends_every_connection() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.establish(10, 2, 1000);
    bus.group2(10, 4, &[0x01, 0x09, 5, 0]);
    bus.group2(10, 3, &[0x01, 0x89]);
    for which in [Predefined::Explicit, Predefined::Poll] {
        assert_eq!(bus.state(10, which), ConnectionState::NonExistent, "{which}");
    }
}

/// Without the allocation: a slave answers its owner only.
#[test]
fn the_owner_is_who_is_answered() {
    let mut bus = Bus::new();
    assert_eq!(bus.group1(13, 10, &[1]).dst, None);
    bus.group2(10, 4, &[0x01, 0x0E, 1, 1, 1]);
    bus.group2(10, 3, &[0x01, 0x8E, 0x34, 0x12]);
    let heard = bus.group1(13, 10, &[1]);
    assert_eq!((heard.dst, heard.assumed), (Some(1), true));
}
