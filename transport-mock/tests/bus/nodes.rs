//! Nodes without a protocol, and the wall clock.

use std::time::Duration;

use link_core::{BitRate, Frame, Instant, LinkEvent, TxOutcome};
use transport_mock::nodes::{Babbler, External, ExternalEvent, Listener, Replay, TooManyFrames};
use transport_mock::realtime::{Realtime, WallClock};
use transport_mock::record::Outcome;
use transport_mock::{BusConfig, Change, Fault, FaultId, Ignore, Network, NodeConfig, NodeId, Record, Scope};

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

/// Two nodes play one recording together: the second has only its later frames.
#[test]
fn replays_of_one_recording_keep_in_step() {
    let mut network = network();
    let frame = |at, id| (Instant::from_millis(at), data(id, &[]));
    network.add_silent(
        NodeConfig::named("later"),
        Replay::since(Instant::from_millis(100), [frame(105, 0x101)]),
    );
    network.add_silent(
        NodeConfig::named("first"),
        Replay::since(Instant::from_millis(100), [frame(100, 0x100), frame(110, 0x102)]),
    );
    let listener = network.add_silent(Listener::config("listener"), Listener::new(8));
    network.run_until(Instant::from_millis(50), &mut Ignore);
    let heard: Vec<u32> =
        (network.machine::<Listener>(listener).unwrap().frames()).map(|(_, frame)| frame.raw_id()).collect();
    assert_eq!(heard, [0x100, 0x101, 0x102]);
}

/// The network is strict: a request without a link would be a violation.
#[test]
fn a_replay_goes_on_while_its_link_is_down() {
    let mut network = network();
    let recorded = [0, 5, 10, 15, 20].map(|at| (Instant::from_millis(at), data(0x100, &[at as u8])));
    let replay = network.add_silent(NodeConfig::named("replay"), Replay::new(recorded));
    let listener = network.add_silent(Listener::config("listener"), Listener::new(8));
    network.schedule(Instant::from_millis(7), Change::Cut(replay));
    network.schedule(Instant::from_millis(17), Change::Plug(replay));
    network.run_until(Instant::from_millis(50), &mut Ignore);
    let heard: Vec<u8> =
        (network.machine::<Listener>(listener).unwrap().frames()).map(|(_, frame)| frame.data()[0]).collect();
    assert_eq!(heard, [0, 5, 20]);
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
    assert_eq!(requests, 6, "none after power was lost");
}

/// The starts of the frames of a babbler with a frame every millisecond, beside what else is on the bus.
fn starts_of_a_babbler(mut network: Network<()>, until: Instant) -> Vec<u64> {
    let babbler = Babbler::new(data(0x100, &[0; 8]), Duration::from_millis(1));
    let babbler = network.add_silent(NodeConfig::named("babbler"), babbler);
    let mut starts = Vec::new();
    network.run_until(until, &mut |record: &Record<'_, ()>| {
        if let Record::Frame(frame) = record
            && frame.senders.iter().any(|sender| sender.node == babbler)
            && frame.outcome == Outcome::Ok
        {
            starts.push(frame.start.as_nanos() / 1_000);
        }
    });
    starts
}

#[test]
fn the_interval_of_a_babbler_is_from_start_to_start() {
    let starts = starts_of_a_babbler(network(), Instant::from_millis(6));
    // The first waits for eleven recessive bits.
    assert_eq!(starts, [22, 1_000, 2_000, 3_000, 4_000, 5_000]);
}

#[test]
fn a_babbler_that_was_kept_waiting_goes_on_from_there() {
    let mut network = network();
    let id = FaultId(1);
    let dominant = Fault::Babble { pull: Duration::from_secs(1), every: Duration::from_secs(1) };
    network.schedule(Instant::from_micros(1_900), Change::FaultOn(id, dominant));
    network.schedule(Instant::from_micros(3_500), Change::FaultOff(id));
    let starts = starts_of_a_babbler(network, Instant::from_millis(7));
    let free = starts[2];
    assert!((3_500..3_700).contains(&free), "{starts:?}");
    assert_eq!(starts[..2], [22, 1_000]);
    // The frame of 2 ms goes at last, and that of 3 ms follows it. The next comes a millisecond after it was asked for,
    // which is when the frame before it ended: intermission and suspend transmission earlier than it began.
    assert!(starts[3] - free < 300, "{starts:?}");
    assert_eq!(starts[4] - starts[3], 1_000 - 11 * 2, "{starts:?}");
}

#[test]
fn a_babbler_with_priority_keeps_everybody_else_silent() {
    let mut network = network();
    network.add_silent(NodeConfig::named("babbler"), Babbler::new(data(0, &[0; 8]), Duration::ZERO));
    let victim = network.add_silent(NodeConfig::named("victim"), External::<()>::new());
    network.run_until(Instant::from_millis(1), &mut Ignore);
    network.command(victim, |victim: &mut External, now| victim.inject(now, (), data(0x100, &[])).unwrap());
    network.run_until(Instant::from_millis(100), &mut Ignore);
    let mut events = Vec::new();
    network.command(victim, |victim: &mut External, _| events.extend(std::iter::from_fn(|| victim.take())));
    assert!(events.iter().all(|(_, event)| !matches!(event, ExternalEvent::Done { .. })));
    assert!(events.len() > 300, "it hears the babbler");
}

#[test]
fn what_waits_at_an_external_node_is_bounded() {
    let mut network = network();
    let outside = network.add_silent(NodeConfig::named("outside"), External::<()>::new());
    network.run_until(Instant::from_millis(1), &mut Ignore);
    let inject = |network: &mut Network<()>| {
        network
            .command(outside, |outside: &mut External, now| outside.inject(now, (), data(0x100, &[])))
            .unwrap()
    };
    for _ in 0..External::<()>::CAPACITY {
        inject(&mut network).unwrap();
    }
    assert_eq!(inject(&mut network), Err(TooManyFrames));
    network.run_until(Instant::from_millis(1_000), &mut Ignore);
    assert_eq!(inject(&mut network), Err(TooManyFrames), "sent, but nobody took the answers");
    let mut answers = 0;
    network.command(outside, |outside: &mut External, _| {
        answers = std::iter::from_fn(|| outside.take())
            .filter(|(_, event)| matches!(event, ExternalEvent::Done { .. }))
            .count();
    });
    assert_eq!((answers, inject(&mut network)), (External::<()>::CAPACITY, Ok(())));
}

#[test]
fn what_an_external_node_has_no_room_for_is_counted_where_it_is_missing() {
    let mut network = network();
    network.add_silent(NodeConfig::named("babbler"), Babbler::new(data(1, &[]), Duration::from_millis(1)));
    let outside = network.add_silent(NodeConfig::named("outside"), External::<()>::new());
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
    assert_eq!(events.len(), External::<()>::CAPACITY + 2);
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

fn outside(network: &mut Network<()>, machine: External<u8>) -> NodeId {
    let config = NodeConfig { own_power: true, ..NodeConfig::named("outside") };
    let outside = network.add_silent(config, machine);
    network.run_until(Instant::from_millis(1), &mut Ignore);
    outside
}

fn inject(network: &mut Network<()>, node: NodeId, owners: impl IntoIterator<Item = u8>) {
    for owner in owners {
        let frame = data(0x200, &[owner]);
        network
            .command(node, |outside: &mut External<u8>, now| outside.inject(now, owner, frame))
            .unwrap()
            .unwrap();
    }
}

/// What has become of the frames, and what was below them.
fn taken(network: &mut Network<()>, node: NodeId) -> (Vec<(u8, TxOutcome)>, Vec<LinkEvent>) {
    let (mut done, mut link) = (Vec::new(), Vec::new());
    let take = |outside: &mut External<u8>, _| std::iter::from_fn(|| outside.take()).collect::<Vec<_>>();
    for (_, event) in network.command(node, take).unwrap() {
        match event {
            ExternalEvent::Done { owner, frame, outcome } => {
                assert_eq!(frame, data(0x200, &[owner]));
                done.push((owner, outcome));
            }
            ExternalEvent::Link(event @ (LinkEvent::Up | LinkEvent::Down | LinkEvent::BusOff)) => {
                link.push(event);
            }
            ExternalEvent::Link(_) | ExternalEvent::Received(_) => {}
        }
    }
    (done, link)
}

#[test]
fn every_frame_from_outside_comes_back_to_its_owner_once() {
    for (changes, seen) in [
        (
            &[Change::PowerOff as fn(NodeId) -> Change<()>, Change::PowerOn][..],
            [LinkEvent::Down, LinkEvent::Up],
        ),
        (&[Change::PowerCycle], [LinkEvent::Down, LinkEvent::Up]),
        (&[Change::Cut, Change::Plug], [LinkEvent::Down, LinkEvent::Up]),
    ] {
        let mut network = network();
        let node = outside(&mut network, External::new());
        inject(&mut network, node, 0..5);
        // Two are sent, the third is in the middle, two wait.
        network.run_until(Instant::from_micros(1_310), &mut Ignore);
        changes.iter().for_each(|change| network.schedule(network.now(), change(node)));
        network.run_until(Instant::from_millis(3), &mut Ignore);
        inject(&mut network, node, 5..6);
        network.run_until(Instant::from_millis(5), &mut Ignore);
        let (mut done, link) = taken(&mut network, node);
        done.sort_by_key(|(owner, _)| *owner);
        let (sent, dropped) = (TxOutcome::Sent, TxOutcome::Dropped);
        assert_eq!(done, [(0, sent), (1, sent), (2, dropped), (3, dropped), (4, dropped), (5, sent)]);
        assert_eq!(link, [&[LinkEvent::Up], &seen[..]].concat());
    }
}

#[test]
fn without_power_a_frame_from_outside_is_lost_at_once() {
    let mut network = network();
    let node = outside(&mut network, External::new());
    network.schedule(Instant::from_millis(2), Change::PowerOff(node));
    network.run_until(Instant::from_millis(3), &mut Ignore);
    inject(&mut network, node, [7]);
    assert_eq!(
        taken(&mut network, node),
        (vec![(7, TxOutcome::Dropped)], vec![LinkEvent::Up, LinkEvent::Down])
    );
}

/// A node outside that has gone bus-off by its frame, and what it restarts after.
fn bus_off_outside() -> (Network<()>, NodeId, Instant) {
    let mut network = Network::new(BusConfig::new(BitRate::K500, 1));
    network.add_silent(NodeConfig::named("acknowledges"), Probe::default());
    let node = outside(&mut network, External::new().with_restart(Duration::from_millis(100)));
    let fault = Fault::BitFlips { rate: 1.0, scope: Scope::Node(node) };
    network.schedule(network.now(), Change::FaultOn(FaultId(1), fault));
    inject(&mut network, node, 0..3);
    network.run_until(Instant::from_millis(50), &mut Ignore);
    network.apply(Change::FaultOff(FaultId(1)));
    let (done, link) = taken(&mut network, node);
    assert_eq!(done.len(), 3);
    assert!(done.iter().all(|(_, outcome)| *outcome == TxOutcome::Dropped));
    assert_eq!(link, [LinkEvent::Up, LinkEvent::BusOff]);
    let until = network.now() + Duration::from_millis(150);
    (network, node, until)
}

#[test]
fn after_bus_off_a_node_outside_restarts_by_itself() {
    let (mut network, node, until) = bus_off_outside();
    network.run_until(until, &mut Ignore);
    assert_eq!(taken(&mut network, node), (vec![], vec![LinkEvent::Up]));
    inject(&mut network, node, [9]);
    network.run_until(until + Duration::from_millis(1), &mut Ignore);
    assert_eq!(taken(&mut network, node).0, [(9, TxOutcome::Sent)]);
}

#[test]
fn a_restart_after_bus_off_does_not_bring_back_power_or_cable() {
    for away in [Change::PowerOff, Change::Cut] {
        let (mut network, node, until) = bus_off_outside();
        network.apply(away(node));
        network.run_until(until, &mut Ignore);
        assert_eq!(taken(&mut network, node).1, [LinkEvent::Down]);
        assert_eq!(network.error_state(node), None);
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
        let outside = network.add_silent(NodeConfig::named("outside"), External::<()>::new());
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
            network.command(outside, |outside: &mut External, now| {
                outside.inject(now, (), data(0x123, &[9])).unwrap()
            });
        });
        driver.run_for(Duration::from_millis(1), &mut Ignore, |_| true);
        let mut network = driver.into_network();
        let sent = network
            .command(outside, |outside: &mut External, _| {
                std::iter::from_fn(|| outside.take())
                    .find(|(_, event)| matches!(event, ExternalEvent::Done { .. }))
                    .map(|(at, _)| at)
            })
            .flatten();
        assert!(sent.unwrap() > expected);
    }
}
