//! Values longer than a frame, and the limit of asynchronous frames (0x1F98/8).

use std::vec::Vec;

use super::bench::*;
use crate::nmt::NmtState;
use crate::wire::{
    AbortCode, Body, Con, Frame, NmtCommandId, RequestedService, Sdo, SdoCommand, SdoCommandId, Segmentation,
};

/// A node in `PreOperational1` with a limit that counts.
fn limited(mtu: u16) -> Bench {
    let mut bench = Bench::in_state(NmtState::PreOperational1, config());
    assert_eq!(bench.writes(0x1F98, 8, &mtu.to_le_bytes()), Ok(()));
    assert_eq!(ident_mtu(&mut bench), 300, "not before the next ResetConfiguration");
    bench.command(NmtCommandId::RESET_CONFIGURATION);
    let mut bench = bench.reconnected(NmtState::PreOperational1);
    assert_eq!(ident_mtu(&mut bench), mtu);
    bench.forget();
    bench
}

fn ident_mtu(bench: &mut Bench) -> u16 {
    bench.asks(RequestedService::IDENT_REQUEST);
    u16::from_le_bytes([bench.last[28], bench.last[29]])
}

/// Reads 0x2000 in all its frames, and acknowledges where the node asks for it. Returns the lengths of the frames and the value.
fn read(bench: &mut Bench) -> (Vec<usize>, Vec<u8>) {
    let (mut lengths, mut value) = (Vec::new(), Vec::new());
    bench.sends_command(SdoCommand::request(0, SdoCommandId::READ_BY_INDEX, &[0x00, 0x20, 0, 0]));
    loop {
        let frame = bench.last.clone();
        let Ok(Frame { body: Body::Sdo(Sdo { sequence, command: Some(answer) }), .. }) = Frame::parse(&frame)
        else {
            panic!("no answer: {frame:02X?}")
        };
        lengths.push(frame.len());
        value.extend(answer.data);
        if matches!(answer.segmentation, Segmentation::Expedited | Segmentation::Complete) {
            return (lengths, value);
        }
        if sequence.send.connection == Con::Request {
            bench.sdo(&std::format!("{:02x} {:02x}", sequence.send.number << 2 | 2, 0x06));
        }
        bench.asks(RequestedService::UNSPECIFIED_INVITE);
    }
}

/// Whatever the limit, the value is whole, every frame but the last has as many bytes as the limit allows, and none has more.
#[test]
fn long_values_come_in_frames_within_the_limit() {
    for mtu in [300, 301, 999, 1499, 1500] {
        for len in [0, 1, 30, 284, 285, 1484, 1485, 2048] {
            let mut bench = limited(mtu);
            let expected: Vec<u8> = (0..len).map(|at: u16| at.to_le_bytes()[0]).collect();
            bench.node.objects_mut().long.clone_from(&expected);
            let (lengths, value) = read(&mut bench);
            assert_eq!(value, expected, "{len} bytes, limit {mtu}");
            let (last, whole) = lengths.split_last().unwrap();
            let most = 14 + usize::from(mtu);
            assert!(whole.iter().all(|&length| length == most), "{lengths:?}, limit {mtu}");
            assert!((60..=most).contains(last), "{lengths:?}, limit {mtu}");
            // 16 bytes of headers in a frame, and the size of all data in the first of several.
            let room = usize::from(mtu) - 16;
            let frames = if value.len() <= room { 1 } else { (value.len() + 4).div_ceil(room) };
            assert_eq!(lengths.len(), frames, "{len} bytes, limit {mtu}");
        }
    }
}

#[test]
fn the_limit_has_limits() {
    let mut bench = Bench::in_state(NmtState::PreOperational1, config());
    for (mtu, expected) in [
        (0, Err(AbortCode::VALUE_TOO_LOW)),
        (299, Err(AbortCode::VALUE_TOO_LOW)),
        (300, Ok(())),
        (1500, Ok(())),
        (1501, Err(AbortCode::VALUE_TOO_HIGH)),
        (u16::MAX, Err(AbortCode::VALUE_TOO_HIGH)),
    ] {
        assert_eq!(bench.writes(0x1F98, 8, &mtu.to_le_bytes()), expected, "{mtu}");
    }
    assert_eq!(bench.reads(0x1F98, 8), Ok(1500_u16.to_le_bytes().to_vec()));
}
