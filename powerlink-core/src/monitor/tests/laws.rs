//! What holds for any bytes.

use proptest::prelude::*;

use super::*;

/// A POWERLINK frame of a network of few nodes with anything in it, or anything at all.
fn frame() -> impl Strategy<Value = Vec<u8>> {
    let nodes = prop_oneof![Just(1_u8), Just(2), Just(240), Just(255), any::<u8>()];
    let kinds = prop_oneof![Just(1_u8), Just(3), Just(4), Just(5), Just(6), any::<u8>()];
    let body = proptest::collection::vec(prop_oneof![0..8_u8, any::<u8>()], 0..200);
    let powerlink = (kinds, nodes.clone(), nodes, body).prop_map(|(kind, to, from, body)| {
        let header =
            [&[0x01, 0x11, 0x1E, 0, 0, 3, 2, 0, 0, 0, 0, from, 0x88, 0xAB, kind, to, from][..], &body];
        header.concat()
    });
    prop_oneof![8 => powerlink, 1 => proptest::collection::vec(any::<u8>(), 0..64)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Any frames in any order are read: each has words, and the numbers of what is known add up.
    #[test]
    fn anything_is_read(frames in proptest::collection::vec((frame(), 0..3_u64, any::<u8>()), 0..100)) {
        let mut monitor = Box::new(SizedMonitor::<2, 64>::new());
        let (mut at, mut heard) = (0, 0);
        for (n, (bytes, millis, beyond)) in (1..).zip(&frames) {
            at += millis;
            let captured = Captured { bytes, length: bytes.len() + usize::from(beyond & 1) };
            let reading = monitor.observe(Instant::from_millis(at), n, captured);
            prop_assert!(!reading.to_string().is_empty());
            prop_assert!(reading.request.is_none_or(|request| request.n < n));
            let has_length = matches!(reading.kind, Kind::AsndIdentResponse | Kind::AsndStatusResponse);
            let is_unread = reading.body.is_none() && reading.kind != Kind::Foreign;
            prop_assert_eq!(is_unread && !has_length && reading.note.is_none(), reading.problem.is_some_and(|problem| problem.code() == "malformed"));
            prop_assert!(reading.kind != Kind::Invalid || reading.body.is_none());
            heard += u64::from(reading.src.is_some() && reading.kind != Kind::Invalid);
        }
        prop_assert_eq!(monitor.nodes().map(|node| node.frames).sum::<u64>(), heard);
        for node in monitor.nodes() {
            prop_assert!(node.pres_late <= node.pres_missing && node.pres_missing <= node.polls);
            prop_assert_eq!(node.state, node.history.last().map(|change| change.state));
        }
    }
}
