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
    assert_eq!(network.preq(1, &[7]).words, "MN -> 1  PReq, EA=0 RD=1, 1 byte");
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
    assert_eq!(
        (seen.kind, seen.problem, seen.note),
        (Kind::Preq, None, Some(Note::Cut { kept: 23, length: 60 }))
    );
    assert_eq!(seen.words, "MN -> 1  PReq (cut: the capture has 23 of its 60 bytes)");
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
    // Its CRC, as some analysers have it.
    bytes.extend([1, 2, 3, 4]);
    assert_eq!(network.bytes((&*bytes).into()).problem, None);
    network.soa(RequestedService::IDENT_REQUEST, 1, false);
    let seen = network.bytes((&bytes[..100]).into());
    assert_eq!(
        (seen.kind, seen.problem),
        (Kind::AsndIdentResponse, Some(Problem::IdentResponseShort { length: 100 }))
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
    let long = [soc(group::SOC, 240), std::vec![0; 1459]].concat();
    assert_eq!(problem(&mut network, &long[..1518]), None, "with its CRC");
    assert_eq!(problem(&mut network, &long), Some(Problem::TooLong { length: 1519 }));
    let other = emitted(group::SOC, mac(241), 255, 240, Body::Soc(Soc::default()));
    assert_eq!(problem(&mut network, &other), Some(Problem::TwoSources { before: mac(240) }));
}

/// `tcpdump -s 60` of nodes with 100 bytes of process data: who was polled, who answered, and who is in which state is still seen.
#[test]
fn what_a_capture_has_cut_is_still_followed() {
    let mut network = Network::new();
    let poll = Preq { flags: Flags::DATA_VALID, pdo_version: PdoVersion(0), data: &[0; 100] };
    let preq = emitted(mac(1), mac(240), 1, 240, Body::Preq(poll));
    let answer = Pres {
        state: NmtStateCode::OPERATIONAL,
        flags: Flags::DATA_VALID,
        request: AsyncRequest::NONE,
        pdo_version: PdoVersion(0),
        data: &[0; 100],
    };
    let pres = emitted(group::PRES, mac(1), 255, 1, Body::Pres(answer));
    let cut = |bytes: &[u8]| {
        let mut kept = bytes.to_vec();
        kept.truncate(60);
        (kept, bytes.len())
    };
    let mut show = |(kept, length): (Vec<u8>, usize)| network.bytes(Captured { bytes: &kept, length });
    show(cut(&preq));
    let seen = show(cut(&pres));
    assert_eq!((seen.kind, seen.request, seen.problem), (Kind::Pres, Some(1), None));
    show(cut(&preq));
    let soc = emitted(group::SOC, mac(240), 255, 240, Body::Soc(Soc::default()));
    assert_eq!(show(cut(&soc)).problem, Some(Problem::PresMissing { node: NodeId(1) }));
    let node = network.monitor.node(NodeId(1)).unwrap();
    assert_eq!((node.polls, node.pres_missing, node.state), (2, 1, Some(NmtStateCode::OPERATIONAL)));
}

/// The numbers of what was not captured are not known: nothing is missing.
#[test]
fn cut_sdo_frames_leave_no_gap() {
    let mut network = Network::new();
    let half = |number| SequenceHalf { number, connection: Con::Valid };
    let frame = |number| {
        let sequence = SdoSequence { receive: half(0), send: half(number) };
        let command = SdoCommand {
            transaction: number,
            is_response: false,
            is_abort: false,
            segmentation: Segmentation::Expedited,
            command: SdoCommandId::WRITE_BY_INDEX,
            data: &[0; 100],
        };
        emitted(group::ASND, mac(240), 1, 240, Body::Sdo(Sdo { sequence, command: Some(command) }))
    };
    assert_eq!(network.bytes((&*frame(1)).into()).problem, None);
    let long = frame(2);
    let seen = network.bytes(Captured { bytes: &long[..60], length: long.len() });
    assert_eq!((seen.kind, seen.note), (Kind::AsndSdo, Some(Note::Cut { kept: 60, length: long.len() })));
    assert_eq!(network.bytes((&*frame(3)).into()).problem, None);
}
