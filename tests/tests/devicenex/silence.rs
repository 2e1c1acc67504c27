//! A device sends nothing at a bit rate that it has not confirmed, and never disturbs a network that runs: the bus is the
//! referee.

use std::time::Duration;

use devicenex_core::access::AccessEvent;
use devicenex_core::device::DeviceEvent;
use devicenex_core::message::{MiniWho, Roam};
use link_core::frame::{extended_id, standard_id};
use link_core::{BitRate, Frame, Instant};
use transport_mock::nodes::{Babbler, Listener, Replay};
use transport_mock::record::Outcome;
use transport_mock::rng::Rng;
use transport_mock::{BusConfig, Change, Network, NodeConfig, NodeId, Record};

use super::block::{Node, node};
use super::plant::{device, oa};

/// What a device did that it must not do, or `None`.
#[derive(Debug, Default)]
struct Referee {
    /// The rate that the device has confirmed since it was plugged in or switched on.
    confirmed: Option<BitRate>,
    /// When something was last done to it: a frame of its own that was on the bus then may end anyhow.
    interfered: Instant,
    sent: usize,
    faults: Vec<String>,
}

impl Referee {
    fn see(&mut self, device: NodeId, rate: BitRate, record: &Record<'_, DeviceEvent>) {
        match record {
            Record::Event { node, event: DeviceEvent::Access(AccessEvent::BitRateLocked(rate)), .. }
                if *node == device =>
            {
                self.confirmed = *rate;
            }
            Record::Frame(frame) if frame.start >= self.interfered => {
                if frame.senders.iter().any(|sender| sender.node == device) {
                    self.sent += 1;
                    if self.confirmed != Some(rate) {
                        self.faults.push(format!("{frame} at {:?}, not {rate}", self.confirmed));
                    }
                }
                if frame.outcome != Outcome::Ok {
                    self.faults.push(format!("disturbed: {frame}"));
                }
            }
            Record::Violation(violation) => self.faults.push(violation.to_string()),
            _ => {}
        }
    }
}

/// A network with random traffic, and a device to which random things happen: its power, its cable, another network with
/// another bit rate, Mini-whos and ROAMs. In whatever state it is, nothing on the bus fails.
#[test]
fn a_device_is_silent_until_it_has_confirmed_the_bit_rate() {
    let mut sent = 0;
    for seed in 0..1_000 {
        sent += one_life(seed);
    }
    // It is not silent for ever.
    assert!(sent > 2_000, "{sent}");
}

fn one_life(seed: u64) -> usize {
    let mut rng = Rng::new(seed, 0);
    let mut rate = RATES[rng.below(3) as usize];
    let mut network = Network::new(BusConfig { shared: None, ..BusConfig::new(rate, seed) });
    let traffic = traffic(&mut network, &mut rng);
    let config = NodeConfig {
        power_up: Some(Instant::from_micros(rng.below(20_000))),
        bit_rate: Some(RATES[rng.below(3) as usize]),
        listen_only: true,
        ..NodeConfig::named("device")
    };
    let tested = network.add(config, node(SERIAL));
    let mut referee = Referee::default();
    for _ in 0..STEPS {
        let end = network.now() + Duration::from_millis(1 + rng.below(1_500));
        network.run_until(end, &mut |record: &Record<'_, DeviceEvent>| referee.see(tested, rate, record));
        referee.interfered = network.now();
        match rng.below(6) {
            0 => {
                referee.confirmed = None;
                network.apply(Change::PowerCycle(tested));
            }
            1 => {
                // Into another network.
                referee.confirmed = None;
                network.apply(Change::Cut(tested));
                rate = RATES[rng.below(3) as usize];
                for node in &traffic {
                    network.apply(Change::SetBitRate(*node, rate));
                }
                let end = network.now() + Duration::from_millis(rng.below(100));
                network.run_until(end, &mut |record: &Record<'_, DeviceEvent>| {
                    referee.see(tested, rate, record)
                });
                referee.interfered = network.now();
                network.apply(Change::Plug(tested));
            }
            2 => {
                let reset = network.command(tested, |device: &mut Node, now| device.reset(now));
                referee.confirmed = reset.and(None);
            }
            // Time passes.
            _ => {}
        }
    }
    assert_eq!(referee.faults, Vec::<String>::new(), "seed {seed}");
    referee.sent
}

/// Two nodes that send, one that manages, and all of them acknowledge.
fn traffic(network: &mut Network<DeviceEvent>, rng: &mut Rng) -> Vec<NodeId> {
    let io = Frame::new(standard_id(0x2A5), &rng.next_u64().to_le_bytes()).unwrap();
    let other = Frame::new(extended_id(0x0086_0007), &rng.next_u64().to_le_bytes()[..3]).unwrap();
    let mini_who = MiniWho { serial_low: 1 }.frame().unwrap();
    let roam = Roam { target: device(SERIAL), requested: oa(rng.below(127) as u8) }.frame().unwrap();
    let pauses = [20, 31].map(|millis| Duration::from_millis(millis + rng.below(40)));
    // They go on after they were restarted with another bit rate.
    let managed = (1..20_u64).flat_map(|round| {
        let at = Instant::from_millis(round * 1_000);
        [(at, mini_who), (at + Duration::from_millis(500), roam)]
    });
    vec![
        network.add_silent(NodeConfig::named("one"), Babbler::new(io, pauses[0])),
        network.add_silent(NodeConfig::named("other"), Babbler::new(other, pauses[1])),
        network.add_silent(NodeConfig::named("manager"), Replay::new(managed.collect::<Vec<_>>())),
        network.add_silent(NodeConfig::named("ear"), Listener::new(0)),
    ]
}

const SERIAL: u32 = 0x0102_0304;
const STEPS: u64 = 6;
const RATES: [BitRate; 3] = [BitRate::K125, BitRate::K250, BitRate::K500];
