//! Nodes without a protocol, and the wall clock.

use std::time::Duration;

use link_core::{BitRate, Frame, Instant, LinkEvent};
use transport_mock::nodes::{Babbler, External, ExternalEvent, Listener, Replay, TooManyFrames};
use transport_mock::realtime::{Realtime, WallClock};
use transport_mock::{BusConfig, Change, Ignore, Network, NodeConfig, Record};

use crate::harness::{Probe, data};

fn network() -> Network<()> {
    let mut network = Network::new(BusConfig { strict: true, ..BusConfig::new(BitRate::K500, 1) });
    network.add_silent(NodeConfig::named("acknowledges"), Probe::default());
    network
}

#[test]
fn a_replay_keeps_the_gaps_of_the_recording() {
    let mut network = network();
    let recorded: Vec<(Instant, Frame)> = [5_000, 5_001, 5_010, 6_000]
        .into_iter()
        .enumerate()
        .map(|(n, at)| (Instant::from_millis(at), data(0x100, &[n as u8])))
        .collect();
    let on = Instant::from_millis(20);
    let replay = network.add_silent(
        NodeConfig { power_up: Some(on), ..NodeConfig::named("replay") },
        Replay::new(recorded.clone()),
    );
    let listener = network.add_silent(Listener::config("listener"), Listener::new(8));
    network.run_until(Instant::from_millis(2_000), &mut Ignore);
    let heard: Vec<(Instant, Frame)> =
        network.machine::<Listener>(listener).unwrap().frames().copied().collect();
    assert_eq!(
        heard.iter().map(|(_, frame)| *frame).collect::<Vec<_>>(),
        recorded.iter().map(|(_, frame)| *frame).collect::<Vec<_>>()
    );
    for ((at, frame), (was, _)) in heard.iter().zip(&recorded).skip(1) {
        let expected = on + was.saturating_since(recorded[0].0);
        let late = at.saturating_since(expected).as_nanos() as u64;
        assert_eq!(late, u64::from(frame.bit_len()) * 2_000, "it ends when its bits are sent");
    }
    assert!(network.machine::<Replay<std::vec::IntoIter<(Instant, Frame)>>>(replay).unwrap().is_done());
}

/// It has a deadline in its past, at which nobody may call it.
#[test]
fn the_clock_of_a_node_without_power_can_be_set() {
    let mut network = network();
    let babbler = Babbler::new(data(0x100, &[]), Duration::from_millis(1));
    let babbler = network.add_silent(NodeConfig::named("babbler"), babbler);
    network.schedule(Instant::from_micros(5_500), Change::PowerOff(babbler));
    network.schedule(Instant::from_micros(5_600), Change::SetClock(babbler, 100));
    let mut requests = 0;
    network.run_until(Instant::from_millis(20), &mut |record: &Record<'_, ()>| {
        requests += usize::from(matches!(record, Record::Request { .. }));
    });
    assert_eq!(requests, 5, "none after power was lost");
}

#[test]
fn a_babbler_with_priority_keeps_everybody_else_silent() {
    let mut network = network();
    network.add_silent(NodeConfig::named("babbler"), Babbler::new(data(0, &[0; 8]), Duration::ZERO));
    let victim = network.add_silent(NodeConfig::named("victim"), External::default());
    network.run_until(Instant::from_millis(1), &mut Ignore);
    network.command(victim, |victim: &mut External, _| victim.inject(data(0x100, &[])).unwrap());
    network.run_until(Instant::from_millis(100), &mut Ignore);
    let mut events = Vec::new();
    network.command(victim, |victim: &mut External, _| events.extend(std::iter::from_fn(|| victim.take())));
    assert!(events.iter().all(|(_, event)| !matches!(event, ExternalEvent::Done(..))));
    assert!(events.len() > 300, "it hears the babbler");
}

#[test]
fn what_waits_at_an_external_node_is_bounded() {
    let mut network = network();
    let outside = network.add_silent(NodeConfig::named("outside"), External::default());
    network.run_until(Instant::from_millis(1), &mut Ignore);
    let inject = |network: &mut Network<()>| {
        network.command(outside, |outside: &mut External, _| outside.inject(data(0x100, &[]))).unwrap()
    };
    for _ in 0..External::CAPACITY {
        inject(&mut network).unwrap();
    }
    assert_eq!(inject(&mut network), Err(TooManyFrames));
    network.run_until(Instant::from_millis(1_000), &mut Ignore);
    assert_eq!(inject(&mut network), Err(TooManyFrames), "sent, but nobody took the answers");
    let mut answers = 0;
    network.command(outside, |outside: &mut External, _| {
        answers = std::iter::from_fn(|| outside.take())
            .filter(|(_, event)| matches!(event, ExternalEvent::Done(..)))
            .count();
    });
    assert_eq!((answers, inject(&mut network)), (External::CAPACITY, Ok(())));
}

#[test]
fn what_an_external_node_has_no_room_for_is_counted_where_it_is_missing() {
    let mut network = network();
    network.add_silent(NodeConfig::named("babbler"), Babbler::new(data(1, &[]), Duration::from_millis(1)));
    let outside = network.add_silent(NodeConfig::named("outside"), External::default());
    let listener = network.add_silent(Listener::config("listener"), Listener::new(1));
    let at = Instant::from_millis(2_000);
    network.schedule(at, Change::Cut(outside));
    network.run_until(at, &mut Ignore);
    let mut events = Vec::new();
    network.command(outside, |outside: &mut External, _| {
        events.extend(std::iter::from_fn(|| outside.take()).map(|(_, event)| event));
    });
    let kept = events.iter().filter(|event| matches!(event, ExternalEvent::Received(_))).count();
    let [.., ExternalEvent::Link(LinkEvent::Overrun { lost }), ExternalEvent::Link(LinkEvent::Down)] =
        events[..]
    else {
        panic!("{:?}", &events[events.len() - 3..]);
    };
    assert_eq!(events.len(), External::CAPACITY + 2);
    let heard = network.machine::<Listener>(listener).unwrap().heard();
    assert_eq!(kept as u64 + u64::from(lost), heard);
}

#[test]
fn a_babbler_goes_on_after_whatever_is_done_to_its_controller() {
    let mut network = Network::<()>::new(BusConfig::new(BitRate::K500, 1));
    let listener = network.add_silent(NodeConfig::named("listener"), Listener::new(1));
    let babbler =
        network.add_silent(NodeConfig::named("babbler"), Babbler::new(data(0, &[0; 8]), Duration::ZERO));
    let heard = |network: &Network<()>| network.machine::<Listener>(listener).unwrap().heard();
    let listen = |on| vec![Change::SetListenOnly(babbler, on)];
    for changes in [
        vec![Change::SetBitRate(babbler, BitRate::K500)],
        [listen(true), listen(false)].into_iter().flatten().collect(),
        vec![Change::Cut(babbler), Change::Plug(babbler)],
        vec![Change::PowerCycle(babbler)],
    ] {
        let mut at = network.now();
        for change in changes {
            // In the middle of a frame.
            at += Duration::from_micros(10_100);
            network.schedule(at, change);
        }
        network.run_until(at + Duration::from_millis(10), &mut Ignore);
        let before = heard(&network);
        network.run_until(network.now() + Duration::from_millis(10), &mut Ignore);
        assert!(heard(&network) > before + 30);
    }
}

/// A clock that jumps to where it is told to sleep to.
struct Jumping(Instant);

impl WallClock for Jumping {
    fn now(&mut self) -> Instant {
        self.0
    }

    fn sleep_until(&mut self, at: Instant) {
        self.0 = self.0.max(at);
    }
}

#[test]
fn virtual_time_follows_the_wall_clock() {
    for speed in [1, 10] {
        let mut network = network();
        network
            .add_silent(NodeConfig::named("babbler"), Babbler::new(data(1, &[]), Duration::from_millis(10)));
        let outside = network.add_silent(NodeConfig::named("outside"), External::default());
        let start = Instant::from_millis(7_000);
        let mut driver = Realtime::new(network, Jumping(start), speed);
        let mut wakeups = 0;
        driver.run_for(Duration::from_millis(100), &mut Ignore, |_| {
            wakeups += 1;
            true
        });
        let expected = Instant::from_millis(100 * u64::from(speed));
        assert_eq!(driver.network().now(), expected);
        assert!(wakeups < 100 * speed, "it sleeps in between: {wakeups} wakeups");

        driver.at_now(&mut Ignore, |network| {
            network.command(outside, |outside: &mut External, _| outside.inject(data(0x123, &[9])).unwrap());
        });
        driver.run_for(Duration::from_millis(1), &mut Ignore, |_| true);
        let mut network = driver.into_network();
        let sent = network
            .command(outside, |outside: &mut External, _| {
                std::iter::from_fn(|| outside.take())
                    .find(|(_, event)| matches!(event, ExternalEvent::Done(..)))
                    .map(|(at, _)| at)
            })
            .flatten();
        assert!(sent.unwrap() > expected);
    }
}
