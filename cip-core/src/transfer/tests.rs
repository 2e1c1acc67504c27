//! Every rule of a transfer, on its own: seven bytes in a frame, six in a fragment, as on DeviceNet.

use core::time::Duration;
use std::vec::Vec;

use super::*;
use link_core::timers::TimerKey;
use link_core::{Instant, Timers};

#[derive(Clone, Copy)]
struct Timer(Wait);

impl From<Wait> for Timer {
    fn from(wait: Wait) -> Self {
        Self(wait)
    }
}

impl TimerKey<2> for Timer {
    const ALL: [Self; 2] = [Self(Wait::Acknowledge), Self(Wait::Reassembly)];
    const WHY: [&'static str; 2] = ["acknowledge", "next fragment"];

    fn index(self) -> usize {
        match self.0 {
            Wait::Acknowledge => 0,
            Wait::Reassembly => 1,
        }
    }
}

const RULES: Rules = Rules { receive_time_out: 2000, reacknowledge_last: true };
const RESPONSE: [u8; 15] = [0x8E, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14];

/// A transfer with its timers; the header is a number.
struct Bench {
    transfer: Transfer<u8, 20, 6, 0>,
    timers: Timers<Timer, 2>,
    rules: Rules,
}

impl Bench {
    fn new() -> Self {
        Self { transfer: Transfer::new(16, 0), timers: Timers::new(), rules: RULES }
    }

    fn hears(&mut self, header: u8, byte: u8, data: &[u8]) -> Result<bool, FragmentRefused> {
        self.transfer.fragment(&mut self.timers, self.rules, header, false, byte.into(), data)
    }

    fn responds(&mut self, header: u8, response: &[u8]) {
        self.transfer.whole(&mut self.timers);
        self.transfer.respond(header, response);
    }

    /// The next frame, in words; peeking says the same.
    fn sends(&mut self) -> Option<(u8, Vec<u8>)> {
        let words = |(header, part): (u8, Part<'_>)| {
            (
                header,
                match part {
                    Part::Acknowledge(byte, status) => std::vec![byte.into(), status.into()],
                    Part::Whole(body) => body.to_vec(),
                    Part::Fragment(fragment) => [&[fragment.byte.into()], fragment.data].concat(),
                },
            )
        };
        let seen = self.transfer.peek().map(words);
        assert_eq!(self.transfer.is_due(), seen.is_some());
        let taken = self.transfer.take().map(words);
        assert_eq!(seen, taken);
        taken
    }

    /// In how many ms the acknowledge and the next fragment are due.
    fn waits(&self) -> [Option<u128>; 2] {
        Timer::ALL
            .map(|timer| self.timers.at(timer).map(|at| at.saturating_since(self.timers.now()).as_millis()))
    }
}

#[test]
fn a_response_in_one_frame() {
    let mut bench = Bench::new();
    bench.responds(3, &RESPONSE[..7]);
    assert!(!bench.transfer.is_quiet());
    assert_eq!(bench.sends(), Some((3, RESPONSE[..7].to_vec())));
    assert_eq!((bench.sends(), bench.transfer.is_quiet()), (None, false));
    bench.transfer.handed(&mut bench.timers);
    assert_eq!((bench.waits(), bench.transfer.is_quiet()), ([None; 2], true));
}

#[test]
fn a_response_in_fragments() {
    let mut bench = Bench::new();
    bench.responds(3, &RESPONSE);
    assert_eq!(bench.hears(3, 0xC0, &[0]), Err(FragmentRefused::StrayAcknowledge), "not handed out yet");
    for (index, (byte, part)) in
        [(0x00, &RESPONSE[..6]), (0x41, &RESPONSE[6..12]), (0x82, &RESPONSE[12..])].into_iter().enumerate()
    {
        assert_eq!(bench.sends(), Some((3, [&[byte], part].concat())));
        assert_eq!(bench.waits(), [None; 2]);
        bench.transfer.handed(&mut bench.timers);
        assert_eq!(bench.waits(), [Some(1000), None]);
        assert_eq!(bench.hears(3, 0xC5, &[0]), Err(FragmentRefused::StrayAcknowledge));
        assert_eq!(bench.hears(3, 0xC0, &[]), Err(FragmentRefused::NoStatus));
        assert_eq!(bench.hears(3, 0xC0 + u8::try_from(index).unwrap(), &[0]), Ok(false));
        assert_eq!(bench.waits(), [None; 2]);
    }
    assert!(bench.transfer.is_quiet());
    assert_eq!(bench.hears(3, 0xC2, &[0]), Err(FragmentRefused::StrayAcknowledge));
}

#[test]
fn two_tries_for_each_fragment() {
    let mut bench = Bench::new();
    bench.responds(3, &RESPONSE);
    bench.sends();
    bench.transfer.handed(&mut bench.timers);
    assert!(!bench.transfer.not_acknowledged(&mut bench.timers));
    // The acknowledge of the first try may still come.
    let mut late = Bench { transfer: bench.transfer.clone(), timers: bench.timers.clone(), rules: RULES };
    assert_eq!(late.hears(3, 0xC0, &[0]), Ok(false));
    assert_eq!(late.sends().map(|(_, frame)| frame[0]), Some(0x41));
    assert_eq!(bench.sends().map(|(_, frame)| frame[0]), Some(0x00));
    bench.transfer.handed(&mut bench.timers);
    assert!(bench.transfer.not_acknowledged(&mut bench.timers), "given up");
    assert!(bench.transfer.is_quiet());
}

#[test]
fn a_request_in_fragments() {
    let mut bench = Bench::new();
    assert_eq!(bench.hears(7, 0x00, &[1, 2, 3, 4, 5, 6]), Ok(false));
    assert_eq!((bench.waits(), bench.transfer.must_acknowledge()), ([None, Some(2000)], true));
    assert_eq!(bench.sends(), Some((7, std::vec![0xC0, 0])));
    assert_eq!(bench.hears(8, 0x81, &[7]), Ok(true));
    assert_eq!(bench.transfer.request(), [1, 2, 3, 4, 5, 6, 7]);
    // The acknowledge goes first.
    bench.transfer.respond(8, &[0x90]);
    assert_eq!(bench.sends(), Some((8, std::vec![0xC1, 0])));
    assert_eq!(bench.sends(), Some((8, std::vec![0x90])));
    bench.transfer.handed(&mut bench.timers);
    // Its last fragment again, for a second.
    assert_eq!(bench.waits(), [None, Some(1000)]);
    assert_eq!(bench.hears(9, 0x81, &[7]), Ok(false));
    assert_eq!((bench.sends(), bench.sends()), (Some((9, std::vec![0xC1, 0])), None));
    bench.transfer.reassembly_over();
    assert_eq!(bench.hears(9, 0x81, &[7]), Err(FragmentRefused::Order));
}

#[test]
fn the_last_fragment_is_forgotten_at_once_if_the_owner_likes() {
    let mut bench = Bench::new();
    bench.rules.reacknowledge_last = false;
    bench.hears(7, 0x00, &[1, 2, 3, 4, 5, 6]).unwrap();
    assert_eq!(bench.hears(8, 0x81, &[7]), Ok(true));
    assert_eq!(bench.waits(), [None; 2]);
    assert_eq!(bench.hears(9, 0x81, &[7]), Err(FragmentRefused::Order));
}

#[test]
fn a_request_that_goes_wrong() {
    let mut bench = Bench::new();
    assert_eq!(bench.hears(7, 0x41, &[1]), Err(FragmentRefused::Order));
    assert_eq!(bench.hears(7, 0x02, &[1]), Err(FragmentRefused::Order));
    bench.hears(7, 0x00, &[1, 2, 3, 4, 5, 6]).unwrap();
    assert_eq!(bench.hears(7, 0x82, &[1]), Err(FragmentRefused::Order));
    assert_eq!(bench.waits(), [None; 2]);
    bench.sends();
    // 16 bytes is the limit.
    bench.hears(7, 0x00, &[0; 6]).unwrap();
    bench.hears(7, 0x41, &[0; 6]).unwrap();
    assert_eq!(bench.hears(7, 0x42, &[0; 6]), Ok(false));
    assert_eq!((bench.sends(), bench.waits()), (Some((7, std::vec![0xC2, 1])), [None; 2]));
    // The next fragment does not come.
    bench.hears(7, 0x00, &[0; 6]).unwrap();
    bench.timers.advance(Instant::ZERO + Duration::from_secs(2));
    bench.transfer.reassembly_over();
    assert_eq!(bench.hears(7, 0x81, &[0]), Err(FragmentRefused::Order));
}

#[test]
fn what_begins_a_request_ends_the_response_before() {
    for first in [false, true] {
        let mut bench = Bench::new();
        bench.responds(3, &RESPONSE);
        bench.sends();
        bench.transfer.handed(&mut bench.timers);
        if first {
            assert_eq!(bench.hears(4, 0x00, &[1, 2, 3, 4, 5, 6]), Ok(false));
            assert_eq!(bench.sends(), Some((4, std::vec![0xC0, 0])));
        } else {
            bench.transfer.whole(&mut bench.timers);
        }
        assert_eq!((bench.waits()[0], bench.transfer.is_quiet(), bench.sends()), (None, true, None));
    }
}

/// A response in one frame may belong to the request that ended the connection.
#[test]
fn the_end_of_the_connection() {
    let mut bench = Bench::new();
    bench.responds(3, &RESPONSE[..7]);
    bench.transfer.close(&mut bench.timers);
    assert!(bench.transfer.is_due());
    bench.transfer.clear(&mut bench.timers);
    assert!(!bench.transfer.is_due() && bench.transfer.is_quiet());
    bench.responds(3, &RESPONSE);
    bench.sends();
    bench.transfer.handed(&mut bench.timers);
    bench.transfer.close(&mut bench.timers);
    assert_eq!((bench.waits(), bench.transfer.is_quiet()), ([None; 2], true));
    // Frames of it that come back later change nothing.
    bench.transfer.handed(&mut bench.timers);
    assert_eq!((bench.waits(), bench.transfer.is_quiet()), ([None; 2], true));
    bench.hears(7, 0x00, &[1, 2, 3, 4, 5, 6]).unwrap();
    bench.transfer.close(&mut bench.timers);
    assert!(bench.transfer.must_acknowledge());
    bench.transfer.clear(&mut bench.timers);
    assert_eq!((bench.sends(), bench.waits()), (None, [None; 2]));
}

/// What earlier messages left behind in the buffer is no part of a transfer.
#[test]
fn equality_is_that_of_the_message() {
    let (mut one, mut other) = (Bench::new(), Bench::new());
    one.responds(3, &RESPONSE);
    one.responds(3, &[0x90]);
    other.responds(3, &[0x90]);
    assert_eq!(one.transfer, other.transfer);
}
