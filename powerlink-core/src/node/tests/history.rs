//! The error history (0x1003) as a client reads it.

use std::vec;
use std::vec::Vec;

use link_core::ethernet::LinkEvent;

use super::bench::*;
use crate::nmt::NmtState;
use crate::wire::{EntryType, ErrorCode, ErrorEntry, Flags, NetTime, NmtCommandId, PdoVersion, Soc};

/// What is read of an entry: kind, code, seconds, nanoseconds, additional information.
fn entry(kind: u16, code: u16, time: (u32, u32), additional: u64) -> Vec<u8> {
    [
        &kind.to_le_bytes()[..],
        &code.to_le_bytes(),
        &time.0.to_le_bytes(),
        &time.1.to_le_bytes(),
        &additional.to_le_bytes(),
    ]
    .concat()
}

fn read(bench: &mut Bench) -> Vec<Vec<u8>> {
    let count = bench.reads(0x1003, 0).unwrap()[0];
    (1..=count).map(|sub| bench.reads(0x1003, sub).unwrap()).collect()
}

/// A row an error: what causes it, and its code. Each is an entry of POWERLINK (profile 2) that says that an event occurred (mode
/// 3), with the time of the last SoC.
#[test]
fn every_error_of_the_node_is_an_entry() {
    type Cause = fn(&mut Bench);
    let rows: [(Cause, u16); 7] = [
        (|bench| bench.preq(Flags::DATA_VALID, &[]), 0x8210),
        (|bench| bench.preq_of_version(PdoVersion(0x10), Flags::DATA_VALID, &[1]), 0x8211),
        (|bench| bench.preq(Flags::DATA_VALID, &[0; 37]), 0x8241),
        (|bench| bench.link(LinkEvent::Down), 0x8165),
        (
            |bench| {
                bench.link(LinkEvent::CrcError);
                bench.link(LinkEvent::CrcError);
            },
            0x8164,
        ),
        (|bench| bench.wait(core::time::Duration::from_millis(3 * CYCLE)), 0x8245),
        (
            |bench| {
                for _ in 0..2 {
                    bench.soa();
                    bench.soc_with(Soc { net_time: TIME, ..Soc::default() });
                }
                bench.soa();
            },
            0x8242,
        ),
    ];
    for (cause, code) in rows {
        let mut bench = Bench::in_state(NmtState::Operational, config());
        bench.soc_with(Soc { net_time: TIME, ..Soc::default() });
        cause(&mut bench);
        if bench.node.state() == NmtState::NotActive {
            bench = bench.reconnected(NmtState::PreOperational1);
        }
        assert_eq!(read(&mut bench), [entry(0x3002, code, (5, 6), 0)], "0x{code:04X}");
    }
}

/// The newest is the first, the oldest goes; 0 clears it; every reset but power-on keeps it.
#[test]
fn order_clearing_and_resets() {
    let own = |number: u16| ErrorEntry {
        kind: EntryType(0x3001),
        code: ErrorCode(number),
        time: NetTime { seconds: 1, nanoseconds: 2 },
        additional: number.into(),
    };
    for command in
        [NmtCommandId::RESET_CONFIGURATION, NmtCommandId::RESET_COMMUNICATION, NmtCommandId::RESET_NODE]
    {
        let mut bench = Bench::in_state(NmtState::PreOperational1, config());
        assert_eq!(read(&mut bench), [[0; 0]; 0]);
        let now = bench.now;
        (1..=10).for_each(|number| bench.node.report_error(now, own(number)).unwrap());
        let expected: Vec<_> =
            (3..=10).rev().map(|number| entry(0x3001, number, (1, 2), number.into())).collect();
        assert_eq!(read(&mut bench), expected);
        bench.command(command);
        let mut bench = bench.reconnected(NmtState::PreOperational1);
        assert_eq!(read(&mut bench), expected, "{command}");
        assert_eq!(bench.writes(0x1003, 0, &[0]), Ok(()));
        assert_eq!(bench.reads(0x1003, 0), Ok(vec![0]));
        assert_eq!(read(&mut bench), [[0; 0]; 0]);
    }
}

const TIME: NetTime = NetTime { seconds: 5, nanoseconds: 6 };
