//! The referee names who breaks a rule.

use link_core::{BitRate, LinkCommand, Mode};
use transport_mock::referee;
use transport_mock::{BusConfig, Change, Record, Rule, Violation};

use crate::harness::{Bench, data};

fn rules(bench: &Bench) -> Vec<&'static str> {
    bench.network.violations().iter().map(|violation| violation.rule).collect()
}

fn checked() -> BusConfig {
    BusConfig::new(BitRate::K500, 1)
}

#[test]
fn two_producers_of_one_identifier_are_found_unless_it_is_shared() {
    for (shared, expected) in [(0x101, vec![referee::ONE_PRODUCER]), (0x100, vec![])] {
        let shared: fn(link_core::StandardId) -> bool =
            if shared == 0x100 { |id| id.as_raw() == 0x100 } else { |id| id.as_raw() == 0x101 };
        let mut bench = Bench::with(BusConfig { shared: Some(shared), ..checked() }, 3);
        bench.send(0, data(0x100, &[1]));
        bench.run_bits(100);
        bench.send(1, data(0x100, &[1]));
        bench.run_bits(100);
        assert!(rules(&bench).is_empty(), "the same data are no contradiction");
        bench.send(0, data(0x100, &[2]));
        bench.run_bits(100);
        assert_eq!(rules(&bench), expected);
    }
}

#[test]
fn a_machine_that_sends_when_it_must_not_is_named() {
    let mut bench = Bench::with(checked(), 2);
    let listen = Mode { bit_rate: BitRate::K500, listen_only: true };
    bench.tell(0, |probe| probe.link(LinkCommand::SetMode(listen)));
    bench.run_bits(20);
    bench.send(0, data(0x100, &[]));
    let node = bench.id(1);
    bench.change(Change::Cut(node));
    bench.run_bits(1);
    bench.send(1, data(0x101, &[]));
    assert_eq!(rules(&bench), [referee::LISTEN_ONLY, referee::LINK_DOWN]);
    assert_eq!(bench.network.violations()[0].node, bench.id(0));
}

#[test]
fn too_many_frames_in_flight_are_counted() {
    let mut bench = Bench::with(checked(), 1);
    for n in 0..65 {
        bench.send(0, data(0x100, &[n]));
    }
    assert_eq!(rules(&bench), [referee::IN_FLIGHT]);
}

#[test]
#[should_panic(expected = "seed 1: 0.000024000 node 0: more frames in flight than max_in_flight")]
fn a_strict_bus_panics_with_the_seed() {
    let mut bench = Bench::with(BusConfig { strict: true, ..checked() }, 1);
    for n in 0..65 {
        bench.send(0, data(0x100, &[n]));
    }
}

#[test]
fn a_machine_whose_deadline_never_moves_is_stuck_and_time_goes_on() {
    use link_core::{Action, Deadline, Input, Instant, Machine};
    use std::convert::Infallible;

    #[derive(Clone)]
    struct Stuck;
    impl Machine for Stuck {
        type Event = Infallible;
        fn input(&mut self, _: Instant, _: Input) {}
        fn poll(&mut self, _: Instant) -> Option<Action<Infallible>> {
            None
        }
        fn deadline(&self) -> Option<Deadline> {
            Some(Deadline { at: Instant::ZERO, why: "for ever" })
        }
        fn max_in_flight(&self) -> usize {
            0
        }
    }

    let mut bench = Bench::with(checked(), 1);
    bench.network.add_silent(transport_mock::NodeConfig::named("stuck"), Stuck);
    bench.run_bits(100);
    assert_eq!(rules(&bench)[0], referee::STUCK);
    assert_eq!(bench.network.violations()[0].what, "for ever");
    bench.send(0, data(0x100, &[]));
    bench.run_bits(100);
    assert!(!bench.frames.is_empty());
}

/// A rule of a protocol: identifier 0x100 may not be sent in the first millisecond.
#[test]
fn a_caller_adds_rules() {
    struct NotYet;
    impl Rule<()> for NotYet {
        fn see(&mut self, record: &Record<'_, ()>, report: &mut dyn FnMut(Violation)) {
            if let Record::Frame(frame) = record
                && frame.start < link_core::Instant::from_millis(1)
            {
                let node = frame.senders[0].node;
                report(Violation { node, at: frame.start, rule: "not yet", what: frame.frame.to_string() });
            }
        }
    }
    let mut bench = Bench::with(checked(), 2);
    bench.network.add_rule(NotYet);
    bench.send(0, data(0x100, &[]));
    bench.run_bits(1_000);
    bench.send(0, data(0x100, &[]));
    bench.run_bits(1_000);
    assert_eq!(rules(&bench), ["not yet"]);
    assert!(bench.lines.iter().any(|line| line.contains("not yet: 100 [0]")));
}
