//! The figures of DeviceNet.

use core::fmt::Write as _;
use core::time::Duration;

use devicenet_core::Identifier;
use devicenet_core::access::{AccessEvent, StateKind};
use devicenet_core::id::Purpose;
use devicenet_core::master::{MasterEvent, SlaveEvent, SlaveState};
use link_core::Instant;
use transport_mock::NodeId;

use super::Plan;
use super::bench::{Bench, Sent};
use super::half::{
    Establishment, Fresh, Full, Half, ROUNDS, Replacement, START, Signs, Spare, Standby, Transfer,
};
use crate::scenario::Output;
use crate::simulate::{MasterMachine, NodeEvent, SlaveMachine};

pub(super) fn measure(plan: &Plan) -> Half {
    Half {
        fresh: fresh(plan),
        full: full(plan),
        establishment: establishment(plan),
        transfer: transfer(plan),
        replacement: replacement(plan),
        standby: standby(plan),
    }
}

/// A master with an empty scan list is on line; then all devices are switched on.
fn fresh(plan: &Plan) -> Fresh {
    let mut text = master("");
    for device in 1..=plan.devices {
        text += &slave("device", device, 63, START);
    }
    Fresh::of(Bench::new(plan, &text), plan, SIGNS)
}

/// 64 nodes, each with a MAC ID of its own on its switches.
fn full(plan: &Plan) -> Full {
    let bench = line(plan, 63);
    let mut all = bench.nodes("device");
    all.push(bench.node("master"));
    Full::of(&bench, &all, SIGNS)
}

/// A master brings up its slaves, each of which then sends and gets two bytes by poll.
fn establishment(plan: &Plan) -> Establishment {
    let bench = line(plan, plan.devices);
    let purpose = |sent: &Sent| Identifier::of_frame(&sent.frame).map(Identifier::purpose);
    let mac_of = |sent: &Sent| Identifier::of_frame(&sent.frame)?.mac_id().map(u8::from);
    let first_data = |mac: u8| {
        let is_it = |sent: &&Sent| purpose(sent) == Some(Purpose::PollResponse) && mac_of(sent) == Some(mac);
        bench.sent.iter().filter(|sent| sent.frame.dlc() > 0).find(is_it).map(|sent| sent.end)
    };
    let is_set_up = |sent: &&Sent| {
        let is_io = matches!(
            purpose(sent),
            Some(Purpose::DuplicateMacCheck | Purpose::PollCommand | Purpose::PollResponse)
        );
        // The first poll command asks for the data.
        let before_data = mac_of(sent).and_then(first_data).is_some_and(|first| sent.end <= first);
        before_data && (!is_io || purpose(sent) == Some(Purpose::PollCommand))
    };
    let is_check = |sent: &&Sent| purpose(sent) == Some(Purpose::DuplicateMacCheck);
    let last = (1..=plan.devices).filter_map(first_data).max().unwrap_or_default();
    let of_one = bench.traffic(bench.sent.iter().filter(|sent| mac_of(sent) == Some(1)).filter(is_set_up));
    Establishment {
        devices: plan.devices.into(),
        of_producer: of_one,
        // It is told what to do in the same way, and gets the data from the master.
        of_consumer: of_one,
        of_all: bench.traffic(bench.sent.iter().filter(is_set_up)),
        access: bench.traffic(bench.sent.iter().filter(is_check)),
        until_data: last.saturating_since(Instant::ZERO),
    }
}

/// The master has the input of B from its poll response, and sends it to A and C with their next poll commands. What the
/// application of the master does takes no time.
fn transfer(plan: &Plan) -> Transfer {
    let (a, b, c) = (1, 2, 3);
    let mut bench = line(plan, 3);
    let mut delays = Vec::new();
    let mut traffic = None;
    for round in 1..=ROUNDS {
        let at = plan.moment(bench.network.now(), round);
        bench.run_to(at);
        let data = [round, 0x5A];
        let (from, node) = (bench.sent.len(), bench.node(&format!("device-{b}")));
        bench.network.command(node, |slave: &mut SlaveMachine, now| slave.set_input(now, &data));
        let input = |told: &NodeEvent| matches!(told, NodeEvent::Input { data: new, .. } if **new == data);
        let master = bench.node("master");
        // One step of the bus after the other: the application acts at once.
        while bench.first_told(at, master, input).is_none() {
            let next = bench.network.next_event_time();
            bench.run_to(next + Duration::from_nanos(1));
        }
        for mac in [a, c] {
            let output = Output::Slave(mac, data.to_vec());
            let set = |master: &mut MasterMachine, _| master.set_output(&output).is_ok();
            bench.network.command(master, set);
        }
        let output = |told: &NodeEvent| matches!(told, NodeEvent::Output { data: new, .. } if **new == data);
        let told =
            |bench: &Bench, mac: u8| bench.first_told(at, bench.node(&format!("device-{mac}")), output);
        bench.run_until(at + Duration::from_secs(1), |bench| {
            [a, c].iter().all(|mac| told(bench, *mac).is_some())
        });
        let last = [a, c].iter().filter_map(|mac| told(&bench, *mac)).max().unwrap_or(at);
        delays.push(last.saturating_since(at));
        traffic.get_or_insert_with(|| {
            let carries = |sent: &&Sent| sent.frame.data() == data;
            let carrying = bench.sent[from..].iter().filter(carries).filter(|sent| sent.end <= last);
            // The command that asked for the input is the last one before the response.
            let first =
                bench.sent[from..].iter().position(|sent| carries(&sent)).map_or(0, |place| from + place);
            let asked = bench.sent[..first].iter().rfind(|sent| {
                Identifier::of_frame(&sent.frame)
                    == devicenet_core::MacId::new(b).map(Identifier::poll_command)
            });
            bench.traffic(asked.into_iter().chain(carrying))
        });
    }
    Transfer::of(traffic, &delays)
}

/// Automatic device replacement is on, and a device out of the box is on the bus as MAC ID 63.
fn replacement(plan: &Plan) -> Replacement {
    let scan =
        scan(1, "replaceable = true\nkey = { vendor = 0x1234, product = 7 }\n") + &scan(2, "") + &scan(3, "");
    let mut text = master(&format!("replacement = \"on\"\n{scan}"));
    for mac in 1..=3 {
        text += &slave("device", mac, mac, Instant::ZERO);
    }
    text += &slave("spare", 9, 63, Instant::ZERO);
    let mut bench = Bench::new(plan, &text);
    bench.run_until(START + plan.patience(), |bench| runs(bench, 3));
    let cut = plan.moment(bench.network.now() + Duration::from_secs(1), 1);
    bench.run_to(cut);
    let (lost, spare) = (bench.node("device-1"), bench.node("spare-9"));
    let is_data = |sent: &Sent| {
        let purpose = Identifier::of_frame(&sent.frame).map(Identifier::purpose);
        purpose == Some(Purpose::PollResponse) && sent.frame.dlc() > 0
    };
    let Spare { cut, first } = Spare::replaces(&mut bench, plan, lost, spare, is_data);
    bench.run_to(first + Duration::from_secs(10));
    let is_back = is_on_line(&bench, lost);
    Replacement {
        until_data: first.saturating_since(cut),
        returned: if is_back { "on line" } else { "off line, until somebody sets its MAC ID" },
        is_spare_again: is_back,
    }
}

/// A line that exchanges I/O and misses one slave, and a device out of the box on line beside it.
fn standby(plan: &Plan) -> Standby {
    let text = line_text(plan.devices.min(62)) + &slave("idle", 99, 63, Instant::ZERO);
    let mut bench = Bench::new(plan, &text);
    bench.run_until(START + plan.patience(), |bench| runs(bench, plan.devices.min(62).into()));
    let idle = bench.node("idle-99");
    Standby::of(bench, |bench| bench.network.machine(idle).map_or(0, SlaveMachine::received))
}

/// So many slaves that run with their master.
fn line(plan: &Plan, slaves: u8) -> Bench {
    let mut bench = Bench::new(plan, &line_text(slaves));
    bench.run_until(START + plan.patience(), |bench| runs(bench, slaves.into()));
    bench.run_to(bench.network.now() + Duration::from_millis(100));
    bench
}

fn line_text(slaves: u8) -> String {
    let scan: String = (1..=slaves).map(|mac| scan(mac, "")).collect();
    let mut text = master(&scan);
    for mac in 1..=slaves {
        text += &slave("device", mac, mac, Instant::ZERO);
    }
    text
}

fn master(more: &str) -> String {
    format!(
        "[[node]]\nname = \"master\"\nprotocol = \"devicenet\"\nrole = \"master\"\nmac = 0\ninterscan_delay = \"0ms\"\n\
         identity = {{ vendor = 0x1234, product = 1, serial = 1 }}\n{more}"
    )
}

fn scan(mac: u8, more: &str) -> String {
    format!("[[node.scan]]\nmac = {mac}\nepr = \"{EPR}ms\"\npoll = {{ produce = 2, consume = 2 }}\n{more}")
}

fn slave(name: &str, number: u8, mac: u8, power_up: Instant) -> String {
    let mut text = format!(
        "[[node]]\nname = \"{name}-{number}\"\nprotocol = \"devicenet\"\nrole = \"slave\"\nmac = {mac}\n"
    );
    let (serial, millis) = (0x2211_0000 + u32::from(number), power_up.as_nanos() / 1_000_000);
    // Writing to a string cannot fail.
    let _ = writeln!(text, "identity = {{ vendor = 0x1234, product = 7, serial = {serial} }}");
    let _ = writeln!(text, "poll = {{ produce = 2, consume = 2 }}\npower_up = \"{millis}ms\"");
    text
}

/// Whether so many slaves run.
fn runs(bench: &Bench, slaves: usize) -> bool {
    let running = |(_, _, event): &&(Instant, NodeId, NodeEvent)| {
        matches!(
            event,
            NodeEvent::Master(MasterEvent::Slave {
                event: SlaveEvent::StateChanged { to: SlaveState::Running, .. },
                ..
            })
        )
    };
    bench.told.iter().filter(running).count() >= slaves
}

fn is_on_line(bench: &Bench, node: NodeId) -> bool {
    let slave = bench.network.machine(node).is_some_and(|slave: &SlaveMachine| slave.access().is_online());
    slave || bench.network.machine(node).is_some_and(|master: &MasterMachine| master.access().is_online())
}

const fn gets_on_line(event: &NodeEvent) -> bool {
    matches!(event, NodeEvent::Access(AccessEvent::StateChanged { to: StateKind::OnLine, .. }))
}

const SIGNS: Signs = Signs { is_on_line, gets_on_line };
/// Expected packet rate of every connection, in ms.
const EPR: u16 = 100;
