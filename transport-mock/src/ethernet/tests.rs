//! A machine that counts, and one that talks.

use std::time::Duration;

use link_core::ethernet::{Action, Input, LinkEvent, Machine};
use link_core::{Deadline, Instant};

use super::*;

/// Sends a number every millisecond if it is a talker, and takes note of what it hears.
#[derive(Clone, Debug, Default)]
struct Node {
    next: Option<Instant>,
    number: u8,
    has_frame: bool,
    heard: Vec<(u64, u8)>,
    links: Vec<LinkEvent>,
}

impl Machine for Node {
    type Event = ();

    fn input(&mut self, now: Instant, input: Input<'_>) {
        match input {
            Input::Frame(bytes) => self.heard.push((now.as_nanos(), bytes[0])),
            Input::Link(event) => self.links.push(event),
            Input::Tick => {}
        }
        if let Some(next) = self.next.filter(|next| *next <= now) {
            self.next = Some(next + Duration::from_millis(1));
            self.number += 1;
            self.has_frame = true;
        }
    }

    fn poll<'b>(&mut self, _: Instant, buffer: &'b mut [u8]) -> Option<Action<'b, ()>> {
        if !std::mem::take(&mut self.has_frame) {
            return None;
        }
        buffer[0] = self.number;
        Some(Action::Transmit(&buffer[..60]))
    }

    fn deadline(&self) -> Option<Deadline> {
        self.next.map(|at| Deadline { at, why: "a number" })
    }
}

fn talker() -> Node {
    Node { next: Some(Instant::from_millis(1)), ..Node::default() }
}

/// A talker, and two who listen.
fn segment() -> (Segment<Node>, [StationId; 3]) {
    let mut segment = Segment::new(SegmentConfig::default());
    let ids = [("talker", talker()), ("a", Node::default()), ("b", Node::default())]
        .map(|(name, node)| segment.add(StationConfig::named(name), node));
    (segment, ids)
}

fn heard(segment: &Segment<Node>, id: StationId) -> Vec<u8> {
    segment.machine(id).heard.iter().map(|(_, number)| *number).collect()
}

#[test]
fn a_frame_arrives_at_everybody_but_its_sender() {
    let (mut segment, [talker, a, b]) = segment();
    segment.run_for(Duration::from_millis(3));
    // 8 + 60 + 4 bytes at 80 ns, and 500 ns.
    assert_eq!(segment.machine(a).heard, [(1_006_260, 1), (2_006_260, 2)]);
    assert_eq!(segment.machine(a).heard, segment.machine(b).heard);
    assert!(segment.machine(talker).heard.is_empty());
    assert_eq!(segment.now(), Instant::from_millis(3));
}

#[test]
fn who_wants_to_send_waits_for_the_wire() {
    let (mut segment, [_, a, _]) = segment();
    segment.add(StationConfig::named("second talker"), talker());
    segment.run_for(Duration::from_micros(1_500));
    let waited: Vec<_> = segment.frames().map(|frame| frame.waited.as_nanos()).collect();
    assert_eq!(waited, [0, 6_720]);
    assert_eq!(segment.machine(a).heard, [(1_006_260, 1), (1_012_980, 1)]);
}

#[test]
fn every_fate_is_what_it_says() {
    let number = |passage: &Passage<'_>| passage.bytes[0];
    let (mut segment, [_, a, b]) = segment();
    segment.add_fault(move |passage| match (passage.to == a, number(passage)) {
        (true, 1) => Fate::Lose,
        (true, 2) => Fate::Corrupt,
        (true, 3) => Fate::Twice,
        (true, 4) => Fate::Late(Duration::from_micros(1_500)),
        (true, 6) => Fate::Replace(vec![99]),
        _ => Fate::Pass,
    });
    segment.run_for(Duration::from_millis(8));
    assert_eq!(heard(&segment, a), [3, 3, 5, 4, 99, 7]);
    assert_eq!(segment.machine(a).links, [LinkEvent::Up, LinkEvent::CrcError]);
    assert_eq!(heard(&segment, b), [1, 2, 3, 4, 5, 6, 7]);
}

#[test]
fn the_nth_of_a_kind_is_struck_until_the_fault_ends() {
    let (mut segment, [_, a, _]) = segment();
    let odd = move |passage: &Passage<'_>| passage.to == a && passage.bytes[0] % 2 == 1;
    segment.add_fault(nth(odd, 1..3, Fate::Lose));
    let all = segment.add_fault(|_| Fate::Lose);
    segment.remove_fault(all);
    segment.run_for(Duration::from_millis(8));
    assert_eq!(heard(&segment, a), [1, 2, 4, 6, 7]);
    segment.add_fault(|_| Fate::Lose);
    segment.clear_faults();
    segment.run_for(Duration::from_millis(1));
    assert_eq!(heard(&segment, a).last(), Some(&8));
}

#[test]
fn without_a_cable_nothing_is_heard_and_nothing_sent() {
    let (mut segment, [talker, a, b]) = segment();
    segment.cut(a);
    segment.run_for(Duration::from_micros(1_500));
    segment.plug(a);
    segment.cut(talker);
    segment.run_for(Duration::from_millis(1));
    segment.plug(talker);
    segment.run_for(Duration::from_millis(1));
    assert_eq!(heard(&segment, a), [3]);
    assert_eq!(heard(&segment, b), [1, 3]);
    assert_eq!(segment.machine(a).links, [LinkEvent::Up, LinkEvent::Down, LinkEvent::Up]);
    let links = [LinkEvent::Up, LinkEvent::Down, LinkEvent::NotSent, LinkEvent::Up];
    assert_eq!(segment.machine(talker).links, links, "number 2 was not sent");
}

#[test]
fn a_cut_takes_what_waits_in_the_adapter_and_what_is_on_its_way() {
    let mut segment = Segment::new(SegmentConfig::default());
    let slow = StationConfig { reaction: Duration::from_micros(2_500), ..StationConfig::named("talker") };
    let id = segment.add(slow, talker());
    let [a, b] = ["a", "b"].map(|name| segment.add(StationConfig::named(name), Node::default()));
    // Number 1 is in the middle of the wire, 2 and 3 wait.
    segment.run_for(Duration::from_micros(3_503));
    segment.cut(id);
    segment.cut(a);
    segment.plug(id);
    segment.plug(a);
    segment.run_for(Duration::from_micros(3_500));
    assert_eq!(
        segment.machine(id).links[1..],
        [LinkEvent::Down, LinkEvent::NotSent, LinkEvent::NotSent, LinkEvent::Up]
    );
    assert_eq!([heard(&segment, a), heard(&segment, b)], [vec![4], vec![1, 4]]);
}

#[test]
fn a_replaced_machine_begins_anew() {
    let (mut segment, [talker_id, a, _]) = segment();
    segment.run_for(Duration::from_micros(2_500));
    segment.replace(talker_id, Node { next: Some(Instant::from_millis(3)), ..Node::default() });
    segment.run_for(Duration::from_millis(1));
    assert_eq!(heard(&segment, a), [1, 2, 1]);
}

/// What the machine before it wanted to send is not what makes the adapter send for the new one.
#[test]
fn a_replaced_machine_has_its_own_reaction_time() {
    let mut segment = Segment::new(SegmentConfig::default());
    let slow = StationConfig { reaction: Duration::from_micros(800), ..StationConfig::named("talker") };
    let id = segment.add(slow, talker());
    let a = segment.add(StationConfig::named("a"), Node::default());
    segment.run_for(Duration::from_micros(1_100));
    segment.replace(id, Node { next: Some(Instant::from_micros(1_200)), ..Node::default() });
    segment.run_for(Duration::from_micros(1_050));
    assert_eq!(segment.machine(a).heard, [(2_006_260, 1)]);
}

#[test]
fn chance_is_in_the_seed_alone() {
    let run = |seed| {
        let mut segment = Segment::new(SegmentConfig { seed, ..SegmentConfig::default() });
        let jitter = Duration::from_micros(300);
        segment.add(StationConfig { jitter, ..StationConfig::named("talker") }, talker());
        let listener = segment.add(StationConfig::named("listener"), Node::default());
        segment.add_fault(rate(seed, 0.3, Fate::Lose));
        segment.run_for(Duration::from_millis(100));
        segment.machine(listener).heard.clone()
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
    assert!((50..90).contains(&run(1).len()), "{}", run(1).len());
}
