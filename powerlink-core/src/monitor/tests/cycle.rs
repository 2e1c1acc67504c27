//! SoCs.

use core::time::Duration;

use super::*;

/// A SoC at a time in ms, with RelativeTime in µs.
fn soc(network: &mut Network, millis: u64, relative: u64) -> (Option<Duration>, Option<Problem>) {
    let soc = Soc { relative_time: relative, ..Soc::default() };
    let bytes = emitted(group::SOC, mac(240), 255, 240, Body::Soc(soc));
    let reading = network.monitor.observe(Instant::from_millis(millis), millis, (&*bytes).into());
    (reading.interval, reading.problem)
}

#[test]
fn intervals_are_measured_and_missing_socs_counted() {
    let mut network = Network::new();
    let ms = Duration::from_millis;
    assert_eq!(soc(&mut network, 100, 0), (None, None));
    assert_eq!(soc(&mut network, 119, 20_000), (Some(ms(19)), None));
    assert_eq!(soc(&mut network, 141, 40_000), (Some(ms(22)), None));
    assert_eq!(soc(&mut network, 200, 100_000), (None, Some(Problem::SocMissing { count: 2 })));
    assert_eq!(soc(&mut network, 219, 120_000), (Some(ms(19)), None));
    let cycle = *network.monitor.cycle();
    assert_eq!((cycle.socs, cycle.missing, cycle.intervals), (5, 2, 3));
    assert_eq!((cycle.min, cycle.mean(), cycle.max), (ms(19), Some(ms(20)), ms(22)));
    assert_eq!((cycle.jitter(), cycle.nominal()), (Some(ms(2)), Some(ms(20))));
}

#[test]
fn without_relative_time_the_intervals_tell() {
    let mut network = Network::new();
    for n in 0..10 {
        assert_eq!(soc(&mut network, n * 10, 0).1, None);
    }
    assert_eq!(soc(&mut network, 104, 0).1, None, "late, but none is missing");
    assert_eq!(soc(&mut network, 124, 0).1, Some(Problem::SocMissing { count: 1 }));
}

/// Neither a managing node that starts again nor one that leaves the cycle loses a SoC.
#[test]
fn a_new_start_is_no_loss() {
    let mut network = Network::new();
    for (millis, relative) in [(0, 0), (10, 10_000), (20, 20_000), (500, 0), (505, 5_000), (510, 10_000)] {
        assert_eq!(soc(&mut network, millis, relative).1, None);
    }
    let soa = Soa {
        state: NmtStateCode::PRE_OPERATIONAL_1,
        flags: Flags::empty(),
        service: RequestedService::NO_SERVICE,
        target: NodeId::NONE,
        version: POWERLINK_V2,
    };
    network.send(255, 240, Body::Soa(soa));
    assert_eq!(soc(&mut network, 900, 400_000), (None, None));
}

/// The SoC after is measured again.
#[test]
fn a_clock_that_is_set_back_measures_no_interval() {
    let mut network = Network::new();
    let ms = Duration::from_millis;
    soc(&mut network, 100, 0);
    assert_eq!(soc(&mut network, 120, 20_000), (Some(ms(20)), None));
    assert_eq!(soc(&mut network, 50, 40_000), (None, None));
    assert_eq!(soc(&mut network, 30, 80_000), (None, Some(Problem::SocMissing { count: 1 })));
    assert_eq!(soc(&mut network, 50, 100_000), (Some(ms(20)), None));
    let cycle = *network.monitor.cycle();
    assert_eq!((cycle.intervals, cycle.min, cycle.jitter()), (2, ms(20), Some(ms(0))));
}
