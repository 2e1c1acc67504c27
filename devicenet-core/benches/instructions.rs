#![allow(
    clippy::arithmetic_side_effects,
    clippy::expect_used,
    clippy::panic,
    missing_docs,
    reason = "a benchmark on a host"
)]
//! How many instructions a slave takes from a frame to its answer, counted by callgrind.
//!
//! `scripts/instructions` runs it, and fails when a budget is exceeded. The program calls itself under valgrind, twice for
//! each case with different numbers of repetitions; what it prints is the difference, divided by that of the repetitions.
//!
//! `instructions CASE COUNT` is one such run, for `callgrind_annotate`.

#[path = "../../link-core/benches/callgrind/mod.rs"]
mod callgrind;

use std::process::ExitCode;

use cip_core::code::{DeviceType, VendorId};
use cip_core::identity::{DeviceIdentity, ProductName, Revision};
use cip_core::message::AllocationChoice;
use cip_core::object::Identity;
use devicenet_core::MacId;
use devicenet_core::slave::{Application, Config, Group2OnlyServer, IoKind};
use link_core::frame::standard_id;
use link_core::{Action, Frame, Input, Instant, LinkEvent, Machine, TxOutcome, TxToken};

fn main() -> ExitCode {
    if let Some((name, count)) = callgrind::asked() {
        let case = CASES.iter().find(|case| case.name == name).expect("a case");
        repeat(case, count);
        return ExitCode::SUCCESS;
    }
    println!("| Exchange | Frames out | Frame in to frame out | Budget | With events, TxDone and deadline |");
    println!("|---|---|---|---|---|");
    let mut exceeded = false;
    for case in CASES {
        let frames = case.frames_out();
        let answer = callgrind::collected(case.name, "*frame_in_to_frame_out*") / frames;
        let whole = callgrind::collected(case.name, "*whole_exchange*") / frames;
        exceeded |= case.budget.is_some_and(|budget| answer > budget);
        let budget = case.budget.map_or_else(|| "-".into(), |budget| budget.to_string());
        println!("| {} | {frames} | {answer} | {budget} | {whole} |", case.words);
    }
    ExitCode::from(u8::from(exceeded))
}

/// What a slave is asked.
struct Case {
    name: &'static str,
    words: &'static str,
    /// In turn, each answered by one frame.
    requests: &'static [(u16, &'static [u8])],
    /// Instructions for each frame out.
    budget: Option<u64>,
}

const CASES: &[Case] = &[
    Case {
        name: "poll",
        words: "poll, two bytes in each direction",
        requests: &[(0x5FD, &[0x12, 0x34])],
        budget: Some(150),
    },
    Case {
        name: "get",
        words: "Get_Attribute_Single: vendor ID",
        requests: &[(0x5FC, &[0x04, 0x0E, 0x01, 0x01, 0x01])],
        budget: Some(250),
    },
    Case {
        name: "get-state",
        words: "Get_Attribute_Single: state of the poll connection",
        requests: &[(0x5FC, &[0x04, 0x0E, 0x05, 0x02, 0x01])],
        budget: Some(250),
    },
    Case {
        name: "get-allocation",
        words: "Get_Attribute_Single: allocation information",
        requests: &[(0x5FC, &[0x04, 0x0E, 0x03, 0x01, 0x05])],
        budget: Some(250),
    },
    Case {
        name: "get-refused",
        words: "Get_Attribute_Single: an attribute that is not there",
        requests: &[(0x5FC, &[0x04, 0x0E, 0x03, 0x01, 0x63])],
        budget: None,
    },
    Case {
        name: "set",
        words: "Set_Attribute_Single: expected packet rate of the poll connection",
        requests: &[(0x5FC, &[0x04, 0x10, 0x05, 0x02, 0x09, 0xC8, 0x00])],
        budget: None,
    },
    Case {
        name: "name",
        words: "Get_Attribute_Single: product name, five fragments and their acknowledges",
        requests: &[
            (0x5FC, &[0x04, 0x0E, 0x01, 0x01, 0x07]),
            (0x5FC, &[0x84, 0xC0, 0x00]),
            (0x5FC, &[0x84, 0xC1, 0x00]),
            (0x5FC, &[0x84, 0xC2, 0x00]),
            (0x5FC, &[0x84, 0xC3, 0x00]),
        ],
        budget: None,
    },
];

impl Case {
    fn frames_out(&self) -> u64 {
        u64::try_from(self.requests.len()).expect("few")
    }
}

fn repeat(case: &Case, count: u64) {
    let requests: Vec<Frame> = case
        .requests
        .iter()
        .map(|&(id, data)| Frame::new(standard_id(id), data).expect("at most eight bytes"))
        .collect();
    let (mut slave, mut now) = established();
    for _ in 0..count {
        now = now.saturating_add(core::time::Duration::from_millis(10));
        for request in &requests {
            whole_exchange(&mut slave, now, request);
        }
        // The last acknowledge of a fragmented response.
        if requests.len() > 1 {
            let last = Frame::new(standard_id(0x5FC), &[0x84, 0xC4, 0x00]).expect("three bytes");
            deliver(&mut slave, now, Input::Frame(last));
        }
    }
}

/// From a frame to the answer of the slave.
#[inline(never)]
fn frame_in_to_frame_out(slave: &mut Server, now: Instant, request: &Frame) -> TxToken {
    slave.input(now, Input::Frame(*request));
    loop {
        match slave.poll(now) {
            Some(Action::Transmit(token, ref frame)) => {
                std::hint::black_box(frame);
                return token;
            }
            Some(_) => {}
            None => panic!("no answer to {request}"),
        }
    }
}

/// The same, with what a driver does after that.
#[inline(never)]
fn whole_exchange(slave: &mut Server, now: Instant, request: &Frame) {
    let token = frame_in_to_frame_out(slave, now, request);
    while slave.poll(now).is_some() {}
    slave.input(now, Input::TxDone(token, TxOutcome::Sent));
    while slave.poll(now).is_some() {}
    std::hint::black_box(slave.deadline());
}

/// A slave on line, with a poll connection that is established.
fn established() -> (Server, Instant) {
    let device = DeviceIdentity {
        vendor: VendorId(0x1234),
        device_type: DeviceType::GENERAL_PURPOSE_DISCRETE_IO,
        product_code: 42,
        revision: Revision::new(1, 1).expect("a revision"),
        serial: 0x1122_3344,
        name: ProductName::new("Example Block of 16 Points").expect("a product name"),
    };
    let config = Config::new(&device, MacId::DEFAULT);
    let block = Block { device, inputs: [0x34, 0x12], outputs: [0; 2] };
    let mut slave = Server::new(config, block).expect("a valid slave");
    let mut now = Instant::ZERO;
    deliver(&mut slave, now, Input::Link(LinkEvent::Up));
    while !slave.access().is_online() {
        now = slave.deadline().expect("a wait").at;
        deliver(&mut slave, now, Input::Tick);
    }
    for (id, data) in [
        // Allocate: explicit and poll.
        (0x5FE, &[0x04, 0x4B, 0x03, 0x01, 0x03, 0x04][..]),
        // Expected packet rate of poll: 200 ms; of the explicit connection: none.
        (0x5FC, &[0x04, 0x10, 0x05, 0x02, 0x09, 0xC8, 0x00]),
        (0x5FC, &[0x04, 0x10, 0x05, 0x01, 0x09, 0x00, 0x00]),
        (0x5FD, &[0x12, 0x34]),
    ] {
        deliver(&mut slave, now, Input::Frame(Frame::new(standard_id(id), data).expect("a frame")));
    }
    (slave, now)
}

/// An input, and everything that follows, on a bus where all frames are sent at once.
fn deliver(slave: &mut Server, now: Instant, input: Input) {
    let mut inputs = vec![input];
    while let Some(input) = inputs.pop() {
        for action in slave.handle(now, input) {
            if let Action::Transmit(token, _) = action {
                inputs.push(Input::TxDone(token, TxOutcome::Sent));
            }
        }
    }
}

type Server = Group2OnlyServer<Block>;

#[derive(Clone, PartialEq, Eq, Hash, Debug)]
struct Block {
    device: DeviceIdentity,
    inputs: [u8; 2],
    outputs: [u8; 2],
}

impl Application for Block {
    const IO: AllocationChoice = AllocationChoice::POLL;
    type Long = ();

    fn identity(&self) -> Identity<'_> {
        Identity::new(&self.device)
    }

    fn produced(&self, _: IoKind) -> &[u8] {
        &self.inputs
    }

    fn consumed(&mut self, _: IoKind) -> &mut [u8] {
        &mut self.outputs
    }
}
