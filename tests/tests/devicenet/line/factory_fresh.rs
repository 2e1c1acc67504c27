//! Two nodes fresh from the factory, both with MAC ID 63, are plugged into a line that runs. The tool gives each an address
//! of its own without a power cycle, and the I/O of the line goes on.
//!
//! The line has the usual interscan delay of 10 ms, or none. Without one the loser of a collision needs the time that the
//! master leaves after errors on the bus: it is error-passive, and in frames that follow each other in three bits it would
//! have no room for its error delimiter, count 8 errors for each of them, and go bus-off.

use core::time::Duration;

use devicenet_core::MacId;
use devicenet_core::access::{self, Fault};
use devicenet_core::message::{DelayOffset, DeviceIdentity, PortNumber};
use devicenet_core::slave;
use devicenet_core::tool::{CommandError, Config, OfflineTool, ToolEvent, ToolState};
use devicenet_tests::line::{Line, LineBlock, Plan, Told, block, identity, mac};
use link_core::{BitRate, Instant};
use transport_mock::NodeId;

use super::io_went_on;

/// A line of 60 slaves at 125 kbit/s, with a tool, and the twins that come later.
struct Site {
    line: Line,
    tool: NodeId,
    twins: [NodeId; 2],
}

impl Site {
    /// The line runs, the tool is on line, and the twins get power, the second so much later than the first.
    fn new(tool: u8, apart: Duration, interscan_delay: Duration) -> Self {
        let plan = Plan {
            slaves: 1..=60,
            expected_packet_rate: EXPECTED_PACKET_RATE,
            interscan_delay,
            ..Plan::new(BitRate::K125)
        };
        let mut line = Line::new(&plan);
        let device = DeviceIdentity { vendor: 0x1234.into(), serial: 0x00C0_FFEE };
        let config = Config::new(access::Config::new(device, PortNumber::ZERO, mac(tool)));
        let tool = line.network.add(transport_mock::NodeConfig::named("tool"), OfflineTool::new(config));
        line.run_until(
            |line| line.is_running() && line.tool(tool).access().is_online(),
            Duration::from_secs(10),
        );
        line.forget();
        let now = line.network.now();
        let twin = |line: &mut Line, serial: u32, at: Instant| {
            let device = LineBlock { identity: identity(serial), ..block(0) };
            let config = slave::Config::new(&device.identity, MacId::DEFAULT);
            line.add_slave("fresh", at, config, device)
        };
        let twins = [twin(&mut line, 0x1000_0001, now), twin(&mut line, 0x1000_0002, now + apart)];
        Self { line, tool, twins }
    }

    #[track_caller]
    fn command(&mut self, command: impl FnOnce(&mut OfflineTool, Instant) -> Result<(), CommandError>) {
        self.line.network.command(self.tool, command).expect("the tool").expect("a command that it takes");
    }

    /// Claims the offline connection set, and asks who is faulted.
    #[track_caller]
    fn finds(&mut self) -> Vec<DeviceIdentity> {
        let tool = self.tool;
        self.command(OfflineTool::claim);
        self.line.run_until(|line| line.tool(tool).state() == ToolState::Owner, Duration::from_secs(3));
        self.command(|tool, now| tool.who(now, DelayOffset::SERIAL));
        let is_done = |told: &Told| matches!(told, Told::Tool(ToolEvent::WhoDone { .. }));
        self.line.run_until(|line| line.told.iter().any(|(.., told)| is_done(told)), Duration::from_secs(5));
        let found = self.line.told.iter().filter_map(|(.., told)| match told {
            Told::Tool(ToolEvent::Found(answer)) => Some(answer.device),
            _ => None,
        });
        found.collect()
    }

    #[track_caller]
    fn gives(&mut self, device: DeviceIdentity, address: u8) {
        self.command(|tool, now| tool.change_mac_id(now, device, mac(address)));
        let recovered = Told::Tool(ToolEvent::Recovered { device, mac: mac(address) });
        self.line
            .run_until(|line| line.told.iter().any(|(.., told)| *told == recovered), Duration::from_secs(5));
    }

    #[track_caller]
    fn is_healthy(&self, addresses: [u8; 2]) {
        for (twin, address) in self.twins.into_iter().zip(addresses) {
            let access = self.line.slave(twin).access();
            assert!(access.is_online());
            assert_eq!(access.mac_id(), mac(address));
        }
        io_went_on(&self.line, Duration::from_millis(EXPECTED_PACKET_RATE.into()));
    }
}

/// A tool whose own MAC ID is 63 defends it: every node fresh from the factory fails its check, and the tool finds it.
#[test]
fn a_tool_at_mac_id_63_finds_and_addresses_both() {
    for apart in [0, 10, 1500].map(Duration::from_millis) {
        let mut site = Site::new(63, apart, PAUSE);
        site.line.run(Duration::from_secs(3));
        for twin in site.twins {
            assert_eq!(site.line.slave(twin).access().fault(), Some(Fault::DuplicateMacId), "{apart:?}");
        }
        let mut found = site.finds();
        found.sort_by_key(|device| device.serial);
        assert_eq!(found.iter().map(|device| device.serial).collect::<Vec<_>>(), [0x1000_0001, 0x1000_0002]);
        site.gives(found[0], 61);
        site.gives(found[1], 62);
        site.is_healthy([61, 62]);
    }
}

/// With a tool elsewhere one of the two gets MAC ID 63 by itself: what both want is there for one. The other is repaired.
#[test]
fn a_tool_elsewhere_addresses_the_one_that_lost() {
    for apart in [0, 10, 1500].map(Duration::from_millis) {
        let mut site = Site::new(61, apart, PAUSE);
        site.line.run(Duration::from_secs(5));
        let online = site.twins.map(|twin| site.line.slave(twin).access().is_online());
        assert_ne!(online[0], online[1], "{apart:?}");
        let found = site.finds();
        assert_eq!(found.len(), 1, "{apart:?}");
        site.gives(found[0], 62);
        site.is_healthy(if online[0] { [63, 62] } else { [62, 63] });
    }
}

/// A scan without a pause has room for the loser of the collision to end its error flag.
#[test]
fn a_scan_without_a_pause_leaves_both_on_the_bus() {
    let mut site = Site::new(61, Duration::ZERO, Duration::ZERO);
    site.line.run(Duration::from_secs(5));
    let faults = site.twins.map(|twin| site.line.slave(twin).access().fault());
    assert_eq!(faults, [Some(Fault::DuplicateMacId), None]);
    let found = site.finds();
    assert_eq!(found.len(), 1);
    site.gives(found[0], 62);
    site.is_healthy([62, 63]);
}

const PAUSE: Duration = Duration::from_millis(10);
const EXPECTED_PACKET_RATE: u16 = 100;
