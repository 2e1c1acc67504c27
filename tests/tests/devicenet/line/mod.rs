//! A line of one master and up to 63 slaves, all real, in virtual time.

mod bring_up;
mod explicit_beside_io;
mod factory_fresh;
mod scan_cycle;

use core::time::Duration;

use cip_core::connection::IoState;
use devicenet_core::Identifier;
use devicenet_core::master::SlaveState;
use devicenet_core::slave::{self, SlaveEvent};
use devicenet_tests::line::{Line, Told};
use link_core::Instant;

/// What no user of a running line may notice: every slave is polled and answers within its expected packet rate, and
/// nobody has timed out.
#[track_caller]
fn io_went_on(line: &Line, expected_packet_rate: Duration) {
    let master = line.master();
    for entry in master.scan_list() {
        let slave = entry.mac_id;
        for id in [Identifier::poll_command(slave), Identifier::poll_response(slave)] {
            let sent: Vec<Instant> =
                line.sent.iter().filter(|sent| sent.id == id).map(|sent| sent.end).collect();
            let longest = sent.windows(2).map(|pair| pair[1].saturating_since(pair[0])).max();
            assert!(longest.is_some_and(|longest| longest <= expected_packet_rate), "{id:?}: {longest:?}");
        }
        let counters = master.slave_counters(slave).unwrap();
        assert_eq!((counters.missed, counters.timeouts), (0, 0), "slave {slave}");
        assert_eq!(master.state(slave), Some(SlaveState::Running), "slave {slave}");
    }
    // The explicit connections time out as they should, ten seconds after their last message.
    let watchdog = line.told.iter().find(|(_, node, told)| {
        line.slaves.contains(node)
            && matches!(told, Told::Slave(slave::Event::Slave(SlaveEvent::Io { to: IoState::TimedOut, .. })))
    });
    assert_eq!(watchdog, None);
}
