//! The identifiers that a node of each role must receive.
//!
//! A filter may let through more than is needed, never less; every machine looks at the identifier again.

use link_core::{Filter, FilterSet, frame::standard_id};

use super::{Identifier, MacId};

/// Every node, checking or on line: the duplicate MAC ID check of its own MAC ID, `0x407 + 8n`.
#[must_use]
pub fn duplicate_mac_check(node: MacId) -> FilterSet {
    FilterSet::of([exact(Identifier::duplicate_mac_check(node))])
}

/// The duplicate MAC ID checks of every node: a master learns from them that a slave comes up.
#[must_use]
pub fn duplicate_mac_checks() -> Filter {
    Filter::standard(Identifier::duplicate_mac_check(MacId::MIN).into(), 0x607)
}

/// A faulted node that takes part in the offline connection set: 0x7ED.
#[must_use]
pub fn communication_faulted() -> FilterSet {
    FilterSet::of([exact(Identifier::COMMUNICATION_FAULTED_REQUEST)])
}

/// A Group 2 Only server: the check, the unconnected port, explicit requests, poll commands and COS acknowledges
/// (`0x402 + 8n`, `0x404 + 8n` to `0x407 + 8n`); and while they are allocated, the bit-strobe command of its master and
/// the multicast poll command of its group.
#[must_use]
pub fn group2_only_server(
    node: MacId,
    strobe_master: Option<MacId>,
    multicast_group: Option<MacId>,
) -> FilterSet {
    // Message IDs 4 to 7 of one MAC ID differ in the low two bits only.
    let requests = Filter::standard(Identifier::explicit_request(node).into(), 0x7FC);
    let mut filters = FilterSet::of([requests, exact(Identifier::change_of_state_acknowledge(node))]);
    if let Some(master) = strobe_master {
        filters.add(exact(Identifier::bit_strobe_command(master)));
    }
    if let Some(group) = multicast_group {
        filters.add(exact(Identifier::multicast_poll_command(group)));
    }
    filters
}

/// A UCMM-capable Group 2 server: as [`group2_only_server`], and the UCMM requests of all sources (their destination is
/// in data byte 0). The identifiers of connections that are opened dynamically are to be added.
#[must_use]
pub fn group2_server(node: MacId, strobe_master: Option<MacId>, multicast_group: Option<MacId>) -> FilterSet {
    let mut filters = group2_only_server(node, strobe_master, multicast_group);
    filters.add(ucmm_requests());
    filters
}

/// UCMM requests of every source: 0x780-0x7BF.
#[must_use]
pub fn ucmm_requests() -> Filter {
    Filter::standard(Identifier::unconnected_request(MacId::MIN).into(), ALL_SOURCES)
}

/// A master: its own check, UCMM responses and heartbeats of all nodes (0x740-0x77F), and of each slave the explicit
/// responses (`0x403 + 8s`, and `0x600 + s` to `0x700 + s` on connections that the UCMM opened) and all I/O
/// (`0x300 + s`, `0x340 + s`, `0x380 + s`, `0x3C0 + s`); and the poll commands to it (`0x405 + 8s`), which only another
/// master that takes it for its own would send. More than three slaves are not told apart from other slaves.
#[must_use]
pub fn master(node: MacId, slaves: impl IntoIterator<Item = MacId>) -> FilterSet {
    let mut filters = duplicate_mac_check(node);
    filters.add(Filter::standard(Identifier::unconnected_response(MacId::MIN).into(), ALL_SOURCES));
    let common = filters.clone();
    for (position, slave) in slaves.into_iter().enumerate() {
        if position >= SLAVES_TOLD_APART {
            let mut widened = common;
            widened.add(Filter::standard(Identifier::multicast_poll_response(MacId::MIN).into(), 0x700));
            widened.add(Filter::standard(Identifier::explicit_response(MacId::MIN).into(), 0x607));
            widened.add(Filter::standard(Identifier::poll_command(MacId::MIN).into(), 0x607));
            widened.add(Filter::standard(standard_id(GROUP_3), GROUP_3));
            return widened;
        }
        filters.add(Filter::standard(Identifier::multicast_poll_response(slave).into(), 0x73F));
        // Message IDs 3 and 5, and with them 1 and 7.
        filters.add(Filter::standard(Identifier::explicit_response(slave).into(), 0x7F9));
        // Any Message ID of Group 3.
        filters.add(Filter::standard(standard_id(GROUP_3 | u16::from(slave.number())), GROUP_3 | 0x3F));
    }
    filters
}

/// The owner of the offline connection set, besides what its role needs: ownership requests (0x7EF) and responses
/// (0x7EE), and the answers of faulted nodes (0x7EC).
#[must_use]
pub fn offline_owner() -> FilterSet {
    FilterSet::of([
        exact(Identifier::COMMUNICATION_FAULTED_RESPONSE),
        exact(Identifier::OFFLINE_OWNERSHIP_RESPONSE),
        exact(Identifier::OFFLINE_OWNERSHIP_REQUEST),
    ])
}

fn exact(id: Identifier) -> Filter {
    Filter::exact(standard_id(id.raw()))
}

/// Three filters a slave, and room for what the master hears as a node.
const SLAVES_TOLD_APART: usize = 3;
/// The two highest bits of Group 3, and of Group 4.
const GROUP_3: u16 = 0x600;
/// Group and Message ID count, the MAC ID does not.
const ALL_SOURCES: u16 = 0x7C0;

#[cfg(test)]
mod tests {
    use super::*;
    use link_core::Frame;

    fn mac(number: u8) -> MacId {
        MacId::new(number).unwrap()
    }

    fn accepted(filters: &FilterSet) -> std::vec::Vec<u16> {
        let passes = |raw: &u16| filters.accepts(&Frame::new(standard_id(*raw), &[]).unwrap());
        (0..=0x7FF).filter(passes).collect()
    }

    #[test]
    fn a_group_2_only_server_hears_what_its_connections_need() {
        assert_eq!(accepted(&group2_only_server(mac(37), None, None)), [0x52A, 0x52C, 0x52D, 0x52E, 0x52F]);
        assert_eq!(
            accepted(&group2_only_server(mac(37), Some(mac(1)), Some(mac(2)))),
            [0x408, 0x411, 0x52A, 0x52C, 0x52D, 0x52E, 0x52F]
        );
    }

    #[test]
    fn a_group_2_server_hears_ucmm_requests_of_everybody() {
        let ids = accepted(&group2_server(mac(37), None, None));
        assert!((0x780..=0x7BF).all(|raw| ids.contains(&raw)));
        assert_eq!(ids.len(), 5 + 64);
    }

    #[test]
    fn a_master_hears_its_slaves() {
        let ids = accepted(&master(mac(0), [mac(37)]));
        let expected = [
            0x325, 0x365, 0x3A5, 0x3E5, 0x407, 0x529, 0x52B, 0x52D, 0x52F, 0x625, 0x665, 0x6A5, 0x6E5, 0x725,
            0x7A5, 0x7E5,
        ];
        assert!(ids.iter().copied().filter(|raw| !(0x740..=0x77F).contains(raw)).eq(expected));
        assert_eq!(ids.len(), expected.len() + 64);
    }

    #[test]
    fn a_master_of_sixty_three_misses_none_and_skips_other_requests() {
        let ids = accepted(&master(mac(0), MacId::all().skip(1)));
        for slave in MacId::all().skip(1) {
            for id in [
                Identifier::multicast_poll_response(slave),
                Identifier::change_of_state(slave),
                Identifier::bit_strobe_response(slave),
                Identifier::poll_response(slave),
                Identifier::explicit_response(slave),
                Identifier::poll_command(slave),
            ] {
                assert!(ids.contains(&id.raw()), "{id}");
            }
        }
        assert!(!ids.contains(&Identifier::explicit_request(mac(5)).raw()));
    }

    #[test]
    fn outside_normal_operation_hardly_anything_is_heard() {
        assert_eq!(accepted(&duplicate_mac_check(mac(63))), [0x5FF]);
        assert_eq!(accepted(&communication_faulted()), [0x7ED]);
        assert_eq!(accepted(&offline_owner()), [0x7EC, 0x7EE, 0x7EF]);
    }
}
