//! The program of the managing node is held up: what it sends leaves late, and what it hears waits.

use core::time::Duration;
use std::vec::Vec;

use link_core::Instant;
use link_core::ethernet::{Action, Input, MAX_FRAME, Machine};

use super::MAC;
use crate::ethernet::group;
use crate::managing::machine::Timer;
use crate::managing::{Config, ManagingNode, MnEvent, MnState, NodePhase, NodePlan};
use crate::wire::{
    AsyncRequest, Body, Flags, Frame, MessageType, NmtCommandId, NmtStateCode, PdoVersion, Pres,
};
use crate::{MacAddress, NodeId};

/// A managing node on a driver with a clock of its own.
struct Driver {
    mn: ManagingNode<'static, 2>,
    /// When each SoC was handed over, and its RelativeTime.
    socs: Vec<(Instant, u64)>,
    /// Whom each PReq was for.
    polls: Vec<u8>,
    events: Vec<MnEvent>,
}

impl Driver {
    /// In operation, without any node that answers.
    fn operational() -> Self {
        let plan = |number| NodePlan {
            is_mandatory: false,
            pres_timeout: Duration::from_millis(2),
            ..NodePlan::new(NodeId(number))
        };
        let mut mn = ManagingNode::new(Config::new(MAC), &[plan(1), plan(2)]).unwrap();
        mn.start(Instant::ZERO);
        let mut driver = Self { mn, socs: Vec::new(), polls: Vec::new(), events: Vec::new() };
        while driver.mn.state() != MnState::Operational {
            driver.tick(Duration::ZERO);
        }
        driver.until_soc();
        driver.forget();
        driver
    }

    fn forget(&mut self) {
        self.socs.clear();
        self.polls.clear();
        self.events.clear();
    }

    /// The deadline is served so much too late. Returns when.
    fn tick(&mut self, late: Duration) -> Instant {
        let at = self.mn.deadline().unwrap().at + late;
        self.mn.input(at, Input::Tick);
        self.drain(at, at);
        at
    }

    /// Carries out what is to be done by an input of one moment, at a later one.
    fn drain(&mut self, stamp: Instant, now: Instant) {
        let mut buffer = [0; MAX_FRAME];
        while let Some(action) = self.mn.poll(stamp, &mut buffer) {
            match action {
                Action::Transmit(bytes) => {
                    match Frame::parse(bytes).unwrap().body {
                        Body::Soc(soc) => self.socs.push((now, soc.relative_time)),
                        Body::Preq(_) => self.polls.push(bytes[15]),
                        _ => {}
                    }
                    self.mn.sent(now);
                }
                Action::Event(event) => self.events.push(event),
            }
        }
    }

    /// Until something holds, with everything in time. Returns when it did.
    fn until(&mut self, holds: impl Fn(&Self) -> bool) -> Instant {
        loop {
            let at = self.tick(Duration::ZERO);
            if holds(self) {
                return at;
            }
        }
    }

    /// Until the next SoC has been sent, with everything in time.
    fn until_soc(&mut self) {
        let socs = self.socs.len();
        self.until(|driver| driver.socs.len() > socs);
    }

    /// Until the cycle is over, and only the next SoC is waited for.
    fn until_rest(&mut self) {
        while self.mn.deadline().unwrap().why != "start of cycle" {
            self.tick(Duration::ZERO);
        }
    }
}

/// SoCs after one that was due `late` ago: how long after the last one before each is sent, in microseconds, and how RelativeTime
/// goes on.
fn held_up_before_a_soc(late: Duration) -> (Vec<u128>, Vec<u64>, u32, usize) {
    let mut driver = Driver::operational();
    driver.until_soc();
    driver.until_rest();
    driver.tick(late);
    (0..3).for_each(|_| driver.until_soc());
    let gaps = driver.socs.windows(2).map(|pair| pair[1].0.saturating_since(pair[0].0).as_micros());
    let times = driver.socs.windows(2).map(|pair| pair[1].1 - pair[0].1);
    let told = driver.events.iter().filter(|event| **event == MnEvent::CycleExceeded).count();
    (gaps.collect(), times.collect(), driver.mn.counters().cycles_exceeded, told)
}

#[test]
fn a_cycle_that_was_missed_is_not_made_up_for() {
    let of = |micros| held_up_before_a_soc(Duration::from_micros(micros));
    // A little late: the grid stays.
    assert_eq!(of(50), (vec_of([20_050, 19_950, 20_000, 20_000]), vec_of([20_000; 4]), 0, 0));
    assert_eq!(of(9_999).0, [29_999, 10_001, 20_000, 20_000]);
    // Too late for its cycle: it is left out, and so are those that were due meanwhile.
    let left_out = |cycles: u32| {
        let gap = 20_000 * u64::from(cycles + 1);
        (vec_of([u128::from(gap), 20_000, 20_000]), vec_of([gap, 20_000, 20_000]), cycles, 1)
    };
    assert_eq!(of(10_000), left_out(1));
    assert_eq!(of(19_845), left_out(1));
    assert_eq!(of(39_845), left_out(2));
    // That of the cycle which it is by then is in time, or a little late.
    let resumed = |first, second, time, cycles| {
        (vec_of([first, second, 20_000, 20_000]), vec_of([time, 20_000, 20_000, 20_000]), cycles, 1)
    };
    assert_eq!(of(20_000), resumed(40_000, 20_000, 40_000, 1));
    assert_eq!(of(45_000), resumed(65_000, 15_000, 60_000, 2));
    assert_eq!(of(74_000), left_out(4));
}

/// The clock of the machine stands at the moment of the last input, that of the driver goes on.
#[test]
fn after_a_soc_that_left_late_the_next_is_half_a_cycle_away_at_least() {
    for (late, gap) in [(9_999, 10_001), (10_001, 29_999), (19_999, 20_001), (45_000, 15_000)] {
        let mut driver = Driver::operational();
        driver.until_rest();
        let at = driver.mn.deadline().unwrap().at;
        driver.mn.input(at, Input::Tick);
        driver.drain(at, at + Duration::from_micros(late));
        driver.until_soc();
        let gaps: Vec<_> =
            driver.socs.windows(2).map(|pair| pair[1].0.saturating_since(pair[0].0).as_micros()).collect();
        assert_eq!(gaps, [gap], "{late}");
        assert_eq!(driver.mn.counters().cycles_exceeded, u32::try_from((late + 10_000) / 20_000).unwrap());
    }
}

/// The cycle is not over when the next should begin: the next but one is on the grid.
#[test]
fn a_cycle_that_takes_too_long_costs_the_next_one() {
    let mut driver = Driver::operational();
    driver.until_soc();
    // The driver does not come to the SoA for 25 ms.
    driver.tick(Duration::from_millis(25));
    driver.until_soc();
    assert_eq!(driver.socs[1].0.saturating_since(driver.socs[0].0), Duration::from_millis(40));
    assert_eq!(driver.socs[1].1 - driver.socs[0].1, 40_000);
    assert!(driver.events.contains(&MnEvent::CycleExceeded));
}

/// The answer of node 1 is looked at 4 ms after it came. The time of node 2 begins when it is asked.
#[test]
fn a_time_out_counts_from_when_the_question_was_sent() {
    let mut driver = Driver::operational();
    driver.until_rest();
    driver.forget();
    for (number, station) in driver.mn.stations.iter_mut().enumerate() {
        station.phase = NodePhase::PreOperational2;
        station.shown = NmtStateCode::PRE_OPERATIONAL_2;
        station.mac = mac(u8::try_from(number).unwrap() + 1);
    }
    let asked = driver.until(|driver| driver.polls == [1]);
    let millis = Duration::from_millis;
    let (came, resumed) = (asked + Duration::from_micros(150), asked + millis(4));
    driver.mn.input(came, Input::Frame(&pres(1)));
    driver.drain(came, resumed);
    assert_eq!(driver.polls, [1, 2]);
    let answered = resumed + millis(2);
    driver.mn.input(answered, Input::Tick);
    driver.drain(answered, answered);
    driver.mn.input(answered, Input::Frame(&pres(2)));
    driver.drain(answered, answered);
    assert_eq!((driver.mn.counters().lost_pres, driver.mn.counters().late_pres), (0, 0));
    // And it ends in time: 2 ms, and both frames on the wire.
    let asked = driver.until(|driver| driver.polls == [1, 2, 1]);
    let lost = driver.until(|driver| driver.events.contains(&MnEvent::PresLost { node: NodeId(1) }));
    assert_eq!(lost.saturating_since(asked), millis(2) + Duration::from_nanos(2 * 6_720));
    assert_eq!(driver.mn.counters().lost_pres, 1);
}

/// The slot of a command begins with its SoA, however long the command takes to leave.
#[test]
fn an_own_frame_that_leaves_late_does_not_lengthen_its_slot() {
    let mut driver = Driver::operational();
    driver.until_rest();
    driver.mn.command_all(NmtCommandId::ENABLE_READY_TO_OPERATE).unwrap();
    driver.until_soc();
    let mut buffer = [0; MAX_FRAME];
    // The SoA, and then the command, 1 ms after it.
    let at = driver.mn.deadline().unwrap().at;
    driver.mn.input(at, Input::Tick);
    assert!(
        matches!(driver.mn.poll(at, &mut buffer), Some(Action::Transmit(bytes)) if bytes[14] == MessageType::SOA.0)
    );
    driver.mn.sent(at);
    let over = driver.mn.timers.at(Timer::Slot);
    assert!(
        matches!(driver.mn.poll(at, &mut buffer), Some(Action::Transmit(bytes)) if bytes[14] == MessageType::ASND.0)
    );
    driver.mn.sent(at + Duration::from_millis(1));
    assert_eq!(driver.mn.timers.at(Timer::Slot), over);
}

/// It is not in the queue of events, and pending nevertheless.
#[test]
fn the_end_of_inputs_is_fetched_at_once() {
    let mut driver = Driver::operational();
    driver.until_rest();
    let now = driver.mn.timers.now();
    for station in &mut driver.mn.stations {
        (station.inputs_valid, station.told_inputs) = (true, true);
    }
    for (index, node) in [(0, 1), (1, 2)] {
        driver.mn.end_inputs(index);
        assert_eq!(driver.mn.deadline().map(|next| next.at), Some(now));
        let event = MnEvent::Inputs { node: NodeId(node), is_valid: false };
        assert_eq!(driver.mn.poll(now, &mut [0; MAX_FRAME]), Some(Action::Event(event)));
    }
    assert_eq!(driver.mn.poll(now, &mut [0; MAX_FRAME]), None);
    assert!(driver.mn.deadline().unwrap().at > now);
}

/// Whether the driver tells the moment of sending or not, where it is the same.
#[test]
fn a_driver_that_is_never_late_changes_nothing() {
    let mut telling = Driver::operational();
    let mut silent = telling.mn.clone();
    for _ in 0..1_000 {
        let at = silent.deadline().unwrap().at;
        assert_eq!(telling.tick(Duration::ZERO), at);
        silent.input(at, Input::Tick);
        while silent.poll(at, &mut [0; MAX_FRAME]).is_some() {}
        assert_eq!(telling.mn, silent);
    }
}

fn pres(number: u8) -> Vec<u8> {
    let pres = Pres {
        state: NmtStateCode::PRE_OPERATIONAL_2,
        flags: Flags::empty(),
        request: AsyncRequest::NONE,
        pdo_version: PdoVersion(0),
        data: &[],
    };
    let (to, from) = (NodeId::BROADCAST, NodeId(number));
    let frame = Frame { destination: group::PRES, source: mac(number), to, from, body: Body::Pres(pres) };
    let bytes = frame.emit(&mut [0; 60]).unwrap().to_vec();
    assert_eq!(bytes[14], MessageType::PRES.0);
    bytes
}

const fn mac(number: u8) -> MacAddress {
    MacAddress([2, 0, 0, 0, 0, number])
}

fn vec_of<T: Clone, const N: usize>(items: [T; N]) -> Vec<T> {
    items.to_vec()
}
