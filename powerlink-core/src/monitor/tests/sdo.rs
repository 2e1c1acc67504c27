//! SDO transfers. Numbers of the sequence layer as in EPSG DS 301: opening, then one number for each frame with a command.

use super::*;

fn half(number: u8, connection: Con) -> SequenceHalf {
    SequenceHalf::new(number, connection)
}

/// A frame of an open connection.
fn valid(received: u8, sent: u8, command: Option<SdoCommand<'_>>) -> Body<'_> {
    let sequence = SdoSequence { receive: half(received, Con::Valid), send: half(sent, Con::Valid) };
    Body::Sdo(Sdo { sequence, command })
}

impl Network {
    fn sdo(&mut self, to: u8, from: u8, body: Body<'_>) -> Seen {
        self.soa(RequestedService::UNSPECIFIED_INVITE, from, false);
        self.send(to, from, body)
    }
}

fn response(transaction: u8, command: SdoCommandId, data: &[u8]) -> SdoCommand<'_> {
    SdoCommand { is_response: true, ..SdoCommand::request(transaction, command, data) }
}

const READ: SdoCommandId = SdoCommandId::READ_BY_INDEX;
const WRITE: SdoCommandId = SdoCommandId::WRITE_BY_INDEX;

#[test]
fn a_response_is_that_to_the_request_of_its_transaction() {
    let mut network = Network::new();
    let open = SdoSequence { receive: half(0, Con::None), send: half(0, Con::Initialisation) };
    let opened = network.sdo(1, 240, Body::Sdo(Sdo { sequence: open, command: None }));
    assert_eq!(opened.words, "MN -> 1  SDO, rcon=0/0 scon=1/0, open");
    let write = SdoCommand::request(3, WRITE, &[0x06, 0x10, 0, 0, 0x50, 0xC3, 0, 0]);
    assert_eq!(
        network.sdo(1, 240, valid(0, 1, Some(write))).words,
        "MN -> 1  SDO, rcon=2/0 scon=2/1, WriteByIndex 0x1006/0 NMT_CycleLen_U32, transaction 3, 4 bytes"
    );
    let answer = network.sdo(240, 1, valid(1, 1, Some(response(3, WRITE, &[]))));
    assert_eq!(
        (&*answer.words, answer.request),
        (
            "1 -> MN  SDO, rcon=2/1 scon=2/1, WriteByIndex response 0x1006/0 NMT_CycleLen_U32, transaction 3, ok",
            Some(4)
        )
    );
    assert_eq!(network.sdo(1, 240, valid(1, 1, None)).words, "MN -> 1  SDO, rcon=2/1 scon=2/1, acknowledge");
    network.sdo(1, 240, valid(1, 2, Some(SdoCommand::request(4, READ, &[0xFF, 0x2F, 0, 0]))));
    let abort = SdoCommand { is_abort: true, ..response(4, READ, &[0, 0, 2, 6]) };
    assert_eq!(
        network.sdo(240, 1, valid(2, 2, Some(abort))).words,
        "1 -> MN  SDO, rcon=2/2 scon=2/2, ReadByIndex response 0x2FFF/0, transaction 4, abort 0x06020000: object does not exist"
    );
    // Of another transaction.
    assert_eq!(network.sdo(240, 1, valid(2, 3, Some(response(9, READ, &[1])))).request, None);
}

#[test]
fn numbers_tell_what_is_missing_and_what_comes_again() {
    let mut network = Network::new();
    let read = |transaction| Some(SdoCommand::request(transaction, READ, &[0x18, 0x10, 1, 0]));
    assert_eq!(network.sdo(1, 240, valid(0, 62, read(1))).problem, None, "the first that is seen");
    assert_eq!(network.sdo(1, 240, valid(0, 63, read(2))).problem, None);
    assert_eq!(network.sdo(1, 240, valid(0, 0, read(3))).problem, None);
    let again = network.sdo(1, 240, valid(0, 0, read(3)));
    assert_eq!((again.problem, again.note), (None, Some(Note::Repeated)));
    let gap = network.sdo(1, 240, valid(0, 3, read(4)));
    assert_eq!(gap.problem, Some(Problem::SequenceGap { expected: 1, found: 3 }));
    assert_eq!(network.sdo(1, 240, valid(0, 3, None)).problem, None);
    assert_eq!(
        network.sdo(1, 240, valid(0, 4, None)).problem,
        Some(Problem::SequenceGap { expected: 3, found: 4 })
    );
}

#[test]
fn transfers_in_several_parts_are_put_together() {
    let mut network = Network::new();
    let part = |segmentation, data| SdoCommand { segmentation, ..SdoCommand::request(1, WRITE, data) };
    let parts = [
        part(Segmentation::Initiate { total: 10 }, &[0x08, 0x20, 1, 0, 0xA0, 0xA1][..]),
        part(Segmentation::Segment, &[0xA2, 0xA3]),
        part(Segmentation::Complete, &[0xA4, 0xA5]),
    ];
    for (number, command) in (1..).zip(parts) {
        let bytes = emitted(group::ASND, mac(240), 1, 240, valid(0, number, Some(command)));
        let reading = network.monitor.observe(Instant::ZERO, number.into(), (&*bytes).into());
        let object = reading.object.unwrap();
        assert_eq!((object.index, object.sub), (0x2008, 1));
        let data = reading.message.map(|message| message.data.to_vec());
        assert_eq!(data, (number == 3).then(|| std::vec![0xA0, 0xA1, 0xA2, 0xA3, 0xA4, 0xA5]));
    }
    // A read: the response is in parts.
    let reply = |segmentation, data| SdoCommand { segmentation, ..response(2, READ, data) };
    network.sdo(1, 240, valid(0, 4, Some(SdoCommand::request(2, READ, &[0x08, 0x10, 0, 0]))));
    network.sdo(240, 1, valid(4, 1, Some(reply(Segmentation::Initiate { total: 3 }, b"ab"))));
    let last = network.sdo(240, 1, valid(4, 2, Some(reply(Segmentation::Complete, b"c"))));
    assert!(last.words.ends_with("last part, 1 byte, completes 3 bytes"), "{}", last.words);
}

/// Part of a transfer of a client to node 1.
fn write_part<const N: usize, const B: usize>(
    monitor: &mut SizedMonitor<N, B>,
    n: u8,
    from: u8,
    segmentation: Segmentation,
    data: &[u8],
) -> (Option<Note>, Option<Vec<u8>>) {
    let command = SdoCommand { segmentation, ..SdoCommand::request(1, SdoCommandId::FILE_WRITE, data) };
    let bytes = emitted(group::ASND, mac(from), 1, from, valid(0, n, Some(command)));
    let reading = monitor.observe(Instant::ZERO, n.into(), (&*bytes).into());
    (reading.note, reading.message.map(|message| message.data.to_vec()))
}

#[test]
fn what_has_no_room_is_noted_and_counted() {
    let mut monitor = SizedMonitor::<1, 2>::new();
    let first = Segmentation::Initiate { total: 3 };
    assert_eq!(write_part(&mut monitor, 1, 240, first, &[1, 2]), (None, None));
    assert_eq!(write_part(&mut monitor, 2, 240, Segmentation::Complete, &[3]), (Some(Note::NotStored), None));
    assert_eq!(monitor.lost(), Lost { connections: 0, transfers: 1 });
}

/// The room of the transfer that was heard least recently is taken for a new one.
#[test]
fn transfers_share_the_room() {
    let mut monitor = SizedMonitor::<2, 8>::new();
    let first = Segmentation::Initiate { total: 2 };
    for (n, from) in [(1, 2), (2, 3), (3, 4)] {
        assert_eq!(write_part(&mut monitor, n, from, first, &[from]), (None, None));
    }
    let mut last = |n, from| write_part(&mut monitor, n, from, Segmentation::Complete, &[0xFF]);
    assert_eq!(last(4, 2), (Some(Note::NotStored), None));
    assert_eq!(last(5, 3), (None, Some(std::vec![3, 0xFF])));
    assert_eq!(last(6, 4), (None, Some(std::vec![4, 0xFF])));
    assert_eq!(monitor.lost(), Lost { connections: 0, transfers: 1 });
}

/// A request of each controlled node to each of two others: the first connections are given up.
#[test]
fn connections_that_are_too_many_are_counted() {
    let mut network = Network::new();
    for server in [240, 253] {
        for client in 1..=239 {
            network.sdo(server, client, valid(0, 1, Some(SdoCommand::request(1, READ, &[0x18, 0x10, 1, 0]))));
        }
    }
    assert_eq!(network.monitor.lost(), Lost { connections: 2 * 239 - 256, transfers: 0 });
    // One that is still known, and one that is not.
    let answer =
        |network: &mut Network, client| network.sdo(client, 253, valid(1, 1, Some(response(1, READ, &[7]))));
    // Each took an invitation before it.
    assert_eq!(answer(&mut network, 239).request, Some(4 * 239));
    assert_eq!(network.sdo(1, 240, valid(1, 1, Some(response(1, READ, &[7])))).request, None);
}
