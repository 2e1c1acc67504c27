//! The figures of DeviceNeX.

use core::fmt::Write as _;
use core::time::Duration;

use devicenex_core::Identifier;
use devicenex_core::access::{AccessEvent, StateKind};
use devicenex_core::id::Layout;
use devicenex_core::manager::{DeviceState, ManagerEvent, PlannedEvent};
use link_core::Instant;
use transport_mock::NodeId;

use super::Plan;
use super::bench::{Bench, Sent, Traffic};
use super::half::{
    Establishment, Fresh, Full, Half, ROUNDS, Replacement, START, Signs, Spare, Standby, Transfer,
};
use crate::simulate::{DeviceMachine, ManagerMachine, NodeEvent};

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

/// A manager that has all of them in its database is on line; then they are switched on.
fn fresh(plan: &Plan) -> Fresh {
    let text = devices("device", plan.devices, START) + &manager(&planned(""));
    Fresh::of(Bench::new(plan, &text), plan, SIGNS)
}

/// 127 nodes: the manager has address 0, 126 devices get the others.
fn full(plan: &Plan) -> Full {
    let mut bench = Bench::new(plan, &(devices("device", 126, Instant::ZERO) + &manager(&planned(""))));
    let mut all = bench.nodes("device");
    all.push(bench.node("manager"));
    bench.run_until(START + plan.patience(), |bench| all.iter().all(|node| is_on_line(bench, *node)));
    Full::of(&bench, &all, SIGNS)
}

/// A manager brings up its devices, each of which then sends two bytes.
fn establishment(plan: &Plan) -> Establishment {
    let (bench, trio) = (line(plan), trio(plan));
    let first_data = |oa: u8| {
        let is_it =
            |sent: &&Sent| matches!(layout(sent), Layout::Implicit { source, .. } if source.number() == oa);
        bench.sent.iter().find(is_it).map(|sent| sent.end)
    };
    let is_access = |sent: &&Sent| matches!(layout(sent), Layout::Hello { .. } | Layout::Roam { .. });
    let last = (1..=plan.devices).filter_map(first_data).max().unwrap_or_default();
    Establishment {
        devices: plan.devices.into(),
        of_producer: set_up(&bench, 1),
        of_consumer: set_up(&trio, 2),
        of_all: (1..=plan.devices).map(|oa| set_up(&bench, oa)).fold(Traffic::default(), Traffic::and),
        access: bench.traffic(bench.sent.iter().filter(is_access).filter(|sent| sent.end <= last)),
        until_data: last.saturating_since(Instant::ZERO),
    }
}

/// What the manager and a device say to each other from the moment at which the device is on line until its connections
/// are made.
fn set_up(bench: &Bench, oa: u8) -> Traffic {
    let devices = bench.nodes("device");
    let Some(from) = devices.get(usize::from(oa) - 1).copied() else { return Traffic::default() };
    let on_line = bench.first_told(Instant::ZERO, from, gets_on_line).unwrap_or_default();
    let runs = bench.first_told(Instant::ZERO, bench.node("manager"), |event| {
        running(event).is_some_and(|running| running == oa)
    });
    let is_of_it = |sent: &&Sent| {
        sent.start >= on_line && runs.is_some_and(|runs| sent.end <= runs) && with_whom(sent) == Some(oa)
    };
    bench.traffic(bench.sent.iter().filter(is_of_it))
}

/// B sends its input to A and C by itself, when it changes.
fn transfer(plan: &Plan) -> Transfer {
    let mut bench = trio(plan);
    let (b, consumers) = (bench.node("device-1"), ["device-2", "device-3"]);
    let mut delays = Vec::new();
    let mut traffic = None;
    for round in 1..=ROUNDS {
        let at = plan.moment(bench.network.now(), round);
        bench.run_to(at);
        let (data, from) = ([round, 0x5A], bench.sent.len());
        bench.network.command(b, |device: &mut DeviceMachine, now| device.set_input(now, &data));
        let output =
            |told: &NodeEvent| matches!(told, NodeEvent::DeviceOutput { data: new, .. } if **new == data);
        let told = |bench: &Bench| consumers.map(|name| bench.first_told(at, bench.node(name), output));
        bench.run_until(at + Duration::from_secs(1), |bench| told(bench).iter().all(Option::is_some));
        let last = told(&bench).into_iter().flatten().max().unwrap_or(at);
        delays.push(last.saturating_since(at));
        traffic.get_or_insert_with(|| {
            let carries = |sent: &&Sent| sent.frame.data() == data && sent.end <= last;
            bench.traffic(bench.sent[from..].iter().filter(carries))
        });
    }
    Transfer::of(traffic, &delays)
}

/// The example of the paper: a spare of B stands by when B is cut off.
fn replacement(plan: &Plan) -> Replacement {
    let mut bench = trio(plan);
    bench.run_to(bench.network.now() + Duration::from_secs(1));
    let cut = plan.moment(bench.network.now(), 1);
    bench.run_to(cut);
    let (lost, spare) = (bench.node("device-1"), bench.node("spare-1"));
    let is_data = |sent: &Sent| matches!(layout(sent), Layout::Implicit { .. });
    let Spare { cut, first } = Spare::replaces(&mut bench, plan, lost, spare, is_data);
    bench.run_to(first + plan.patience());
    let is_back = state(&bench, lost) == Some(StateKind::Standby);
    Replacement {
        until_data: first.saturating_since(cut),
        returned: if is_back { "stands by, as the next spare" } else { "does not stand by" },
        is_spare_again: is_back,
    }
}

/// A line that exchanges I/O and misses one device, and a device in Standby beside it.
fn standby(plan: &Plan) -> Standby {
    let idle = devices("idle", 1, Instant::ZERO).replace("0x22110001", "0x3311F001");
    let text = devices("device", plan.devices.min(62), Instant::ZERO) + &idle;
    let mut bench = Bench::new(plan, &(text + &manager(&planned(PRODUCER))));
    bench.run_until(START + plan.patience(), |bench| runs(bench, plan.devices.min(62).into()));
    let idle = bench.node("idle-1");
    Standby::of(bench, |bench| bench.network.machine(idle).map_or(0, DeviceMachine::received))
}

/// So many devices that produce, with their manager.
fn line(plan: &Plan) -> Bench {
    let text = devices("device", plan.devices, Instant::ZERO) + &manager(&planned(PRODUCER));
    let mut bench = Bench::new(plan, &text);
    bench.run_until(START + plan.patience(), |bench| runs(bench, plan.devices.into()));
    bench.run_to(bench.network.now() + Duration::from_millis(200));
    bench
}

/// B produces, A and C consume, and B has a spare.
fn trio(plan: &Plan) -> Bench {
    let spare = devices("spare", 1, Instant::ZERO).replace("0x22110001", "0x3311F001");
    let consumer = "connections = [{ connection = \"multicast_consumer\", from = 1 }]\n";
    let entries = format!(
        "[[node.planned]]\noa = 1\ndevice = \"device-1\"\nspares = [\"spare-1\"]\n{PRODUCER}\
         [[node.planned]]\noa = 2\ndevice = \"device-2\"\n{consumer}\
         [[node.planned]]\noa = 3\ndevice = \"device-3\"\n{consumer}"
    );
    let text = devices("device", 3, Instant::ZERO) + &spare + &manager(&entries);
    let mut bench = Bench::new(plan, &text);
    bench.run_until(START + plan.patience(), |bench| runs(bench, 3));
    bench.run_to(bench.network.now() + Duration::from_millis(200));
    bench
}

fn manager(entries: &str) -> String {
    format!(
        "[[node]]\nname = \"manager\"\nprotocol = \"devicenex\"\nrole = \"manager\"\noa = 0\n\
         identity = {{ vendor = 0x1234, product = 1, serial = 1 }}\n{entries}"
    )
}

/// All devices, from address 1 on.
fn planned(connections: &str) -> String {
    format!("[[node.planned]]\noa = 1\ndevice = \"device\"\n{connections}")
}

fn devices(name: &str, count: u8, power_up: Instant) -> String {
    let mut text = String::new();
    let millis = power_up.as_nanos() / 1_000_000;
    // Writing to a string cannot fail.
    let _ = write!(
        text,
        "[[node]]\nname = \"{name}\"\nprotocol = \"devicenex\"\nrole = \"device\"\ncount = {count}\n\
         produce = 2\nconsume = 2\npower_up = \"{millis}ms\"\n\
         identity = {{ vendor = 0x1234, product = 7, serial = 0x22110001 }}\n"
    );
    text
}

fn layout(sent: &Sent) -> Layout {
    Identifier::of_frame(&sent.frame).layout()
}

/// The device with which the manager, address 0, speaks.
fn with_whom(sent: &Sent) -> Option<u8> {
    let (Layout::Connection { route, .. }
    | Layout::Connectionless { route, .. }
    | Layout::Explicit { route, .. }) = layout(sent)
    else {
        return None;
    };
    Some(route.source.number().max(route.destination.number()))
}

/// The address of the planned device that runs now.
fn running(event: &NodeEvent) -> Option<u8> {
    let NodeEvent::Manager(event) = event else { return None };
    match **event {
        ManagerEvent::Planned(oa, PlannedEvent::StateChanged { to: DeviceState::Running, .. }) => {
            Some(oa.number())
        }
        _ => None,
    }
}

/// Whether so many devices run.
fn runs(bench: &Bench, devices: usize) -> bool {
    bench.told.iter().filter(|(.., event)| running(event).is_some()).count() >= devices
}

fn state(bench: &Bench, node: NodeId) -> Option<StateKind> {
    let device = bench.network.machine(node).map(|device: &DeviceMachine| device.access().state().kind());
    device.or_else(|| bench.network.machine(node).map(|node: &ManagerMachine| node.access().state().kind()))
}

fn is_on_line(bench: &Bench, node: NodeId) -> bool {
    state(bench, node) == Some(StateKind::Online)
}

const fn gets_on_line(event: &NodeEvent) -> bool {
    matches!(event, NodeEvent::NexAccess(AccessEvent::StateChanged { to: StateKind::Online, .. }))
}

const SIGNS: Signs = Signs { is_on_line, gets_on_line };
/// As long as the expected packet rate of the polls of DeviceNet.
const PRODUCER: &str = "connections = [{ connection = \"multicast_producer\", epr = \"100ms\" }]\n";
