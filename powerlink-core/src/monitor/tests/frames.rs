//! What a frame says by itself.

use super::*;

fn ident() -> IdentResponse {
    // IdentResponse of the reference node in a capture of our own: EPSG DS 301 layout, openPOWERLINK 2.7.2.
    let mut bytes = [0; 158];
    bytes[2] = 0x5D;
    bytes[4] = 0x20;
    (bytes[12], bytes[14]) = (36, 36);
    IdentResponse::parse(&bytes).unwrap()
}

#[test]
fn each_message_has_its_kind_and_words() {
    let mut network = Network::new();
    let seen = network.soa(RequestedService::IDENT_REQUEST, 1, false);
    assert_eq!(
        (seen.kind, &*seen.words),
        (Kind::Soa, "MN -> all  SoA, NMT_PRE_OPERATIONAL_2, IdentRequest for node 1, EA=0 ER=0")
    );
    let seen = network.send(255, 1, Body::IdentResponse(ident()));
    assert_eq!((seen.kind, seen.request, seen.problem), (Kind::AsndIdentResponse, Some(1), None));
    assert_eq!(network.soc(0).kind, Kind::Soc);
    assert_eq!(network.preq(1, &[7]).words, "MN -> 1  PReq, EA=0 RD=1, 1 bytes");
    let seen = network.pres(1, NmtStateCode::PRE_OPERATIONAL_2);
    assert_eq!(
        (&*seen.words, seen.request),
        ("1 -> all  PRes, NMT_PRE_OPERATIONAL_2, EN=0 RD=0, PR=0 RS=0, 2 bytes", Some(4))
    );
    for (message_type, kind) in [
        (MessageType::AMNI, Kind::Amni),
        (MessageType::AINV, Kind::Ainv),
        (MessageType(0x09), Kind::Reserved),
    ] {
        assert_eq!(network.send(255, 240, Body::Other(message_type, &[])).kind, kind);
    }
}

/// A tag of IEEE 802.1Q: priority 6, VLAN 5.
#[test]
fn a_vlan_tag_is_passed_over() {
    let mut network = Network::new();
    let mut bytes = emitted(group::SOC, mac(240), 255, 240, Body::Soc(Soc::default()));
    bytes.splice(12..12, [0x81, 0x00, 0xC0, 0x05]);
    assert_eq!(network.bytes((&*bytes).into()).problem, None);
    let reading = network.monitor.observe(Instant::ZERO, 2, (&*bytes).into());
    assert_eq!((reading.kind, reading.envelope.and_then(|envelope| envelope.vlan)), (Kind::Soc, Some(5)));
    assert_eq!(reading.payload()[0], 0x01);
}

#[test]
fn other_protocols_are_no_problem() {
    let mut network = Network::new();
    let mut arp = [0; 60];
    (arp[12], arp[13]) = (0x08, 0x06);
    let seen = network.bytes((&arp[..]).into());
    assert_eq!(
        (seen.kind, &*seen.words, seen.problem),
        (Kind::Foreign, "00-00-00-00-00-00 -> 00-00-00-00-00-00  ARP, 46 bytes", None)
    );
}

/// Vector 68 of the protocol: a PReq that ends within its Size.
#[test]
fn a_frame_that_ends_too_early_is_invalid() {
    let mut network = Network::new();
    let bytes = [2, 0, 0, 0, 0, 1, 2, 0, 0, 0, 0, 0xF0, 0x88, 0xAB, 0x03, 0x01, 0xF0, 0, 1, 0, 0, 0, 1];
    let seen = network.bytes((&bytes[..]).into());
    assert_eq!((seen.kind, seen.problem.map(|problem| problem.code())), (Kind::Invalid, Some("malformed")));
    // Cut by the capture, it is none.
    let seen = network.bytes(Captured { bytes: &bytes, length: 60 });
    assert_eq!((seen.problem, seen.note), (None, Some(Note::Cut { kept: 23 })));
    for len in 0..14 {
        assert_eq!(network.bytes((&bytes[..len]).into()).kind, Kind::Invalid);
    }
}

/// Which a managing node drops, and resets the node.
#[test]
fn responses_of_another_length_than_the_managing_node_takes() {
    let mut network = Network::new();
    network.soa(RequestedService::STATUS_REQUEST, 1, false);
    let mut bytes = emitted(group::ASND, mac(1), 255, 1, Body::IdentResponse(ident()));
    bytes[17] = 0x02;
    let seen = network.bytes((&bytes[..60]).into());
    assert_eq!(seen.kind, Kind::AsndStatusResponse);
    assert_eq!(seen.problem, Some(Problem::StatusResponseShort { length: 60 }));
    // It was an answer all the same.
    assert_eq!(network.soa(RequestedService::IDENT_REQUEST, 1, false).problem, None);
    bytes[17] = 0x01;
    bytes.push(0);
    let seen = network.bytes((&*bytes).into());
    assert_eq!(seen.problem, Some(Problem::IdentResponseLength { length: 177 }));
    network.soa(RequestedService::IDENT_REQUEST, 1, false);
    let seen = network.bytes((&bytes[..100]).into());
    assert_eq!(
        (seen.kind, seen.problem),
        (Kind::AsndIdentResponse, Some(Problem::IdentResponseLength { length: 100 }))
    );
}

#[test]
fn addresses_and_lengths_that_cannot_be() {
    let mut network = Network::new();
    let soc = |to, from| emitted(to, mac(from), 255, from, Body::Soc(Soc::default()));
    let problem = |network: &mut Network, bytes: &[u8]| network.bytes(bytes.into()).problem;
    assert_eq!(problem(&mut network, &soc(group::SOC, 5)), Some(Problem::NotManagingNode));
    assert_eq!(
        problem(&mut network, &soc(group::SOA, 240)),
        Some(Problem::WrongGroup { expected: group::SOC })
    );
    let long = [soc(group::SOC, 240), std::vec![0; 1455]].concat();
    assert_eq!(problem(&mut network, &long), Some(Problem::TooLong { length: 1515 }));
    let other = emitted(group::SOC, mac(241), 255, 240, Body::Soc(Soc::default()));
    assert_eq!(problem(&mut network, &other), Some(Problem::TwoSources { before: mac(240) }));
}
