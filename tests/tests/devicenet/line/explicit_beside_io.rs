//! Nobody starves: slaves that come late, long explicit requests and heartbeats beside a scan without interscan delay at
//! 125 kbit/s, and the scan beside them.
//!
//! A scan of 63 slaves is 126 frames, 66 ms. It has room for seven explicit messages of the master, an eighth of its polls,
//! and gives way to fifteen frames when its commands are out. Heartbeats of slaves with low MAC IDs come between the
//! commands: at worst all slaves send theirs in one scan. Together that is at most 211 frames; 150 ms bound their time.

use core::time::Duration;

use cip_core::code::{ClassId, InstanceId, ServiceCode};
use cip_core::message::Request;
use devicenet_core::master::{MasterEvent, SlaveEvent, SlaveState};
use devicenet_tests::line::{Line, LineMaster, Plan, Told, mac};
use link_core::{BitRate, Instant};

use super::io_went_on;

#[test]
fn nothing_starves_beside_a_scan_without_interscan_delay() {
    let plan = Plan { heartbeat: Some(1), late: Some((FIRST_LATE, LATE)), ..Plan::new(BitRate::K125) };
    let mut line = Line::new(&plan);
    line.run_until(|line| running(line) == 59, Duration::from_secs(10));
    line.forget();
    for _ in 0..9000 {
        for slave in TALKATIVE.map(mac) {
            // Busy with the request before.
            let _ = line.network.command(line.master, |master: &mut LineMaster, now| {
                let request = Request::new(
                    ServiceCode::GET_ATTRIBUTE_LIST,
                    ClassId::IDENTITY,
                    InstanceId(1),
                    &ATTRIBUTES,
                );
                master.request(now, slave, &request, 1)
            });
        }
        line.run(Duration::from_millis(1));
    }
    let count = |wanted: Told| line.told.iter().filter(|(.., told)| *told == wanted).count();
    for slave in TALKATIVE.map(mac) {
        let answered = Told::Master(MasterEvent::Slave { mac_id: slave, event: SlaveEvent::Response });
        assert!(count(answered) > 20, "slave {slave}: {}", count(answered));
        assert_eq!(line.master().slave_counters(slave).unwrap().explicit_failed, 0);
    }
    for entry in line.master().scan_list() {
        let late = entry.mac_id >= mac(FIRST_LATE);
        let heartbeats = line.master().slave_counters(entry.mac_id).unwrap().heartbeats;
        assert!(heartbeats >= if late { 3 } else { 8 }, "slave {}: {heartbeats}", entry.mac_id);
    }
    let runs = |told: &Told| matches!(told, Told::Master(MasterEvent::Slave { mac_id, event: SlaveEvent::StateChanged { to: SlaveState::Running, .. } }) if *mac_id >= mac(FIRST_LATE));
    let up = line.told.iter().filter(|(.., told)| runs(told)).map(|(at, ..)| *at).max().unwrap();
    assert!(up <= LATE + LATE_RUN_AFTER, "{up}");
    for scan in line.scans() {
        assert!(scan.frames <= 126 + 63 + 7 + 15, "{scan:?}");
        assert!(scan.cycle <= LONGEST_SCAN, "{scan:?}");
    }
    assert_eq!(running(&line), 63);
    io_went_on(&line, Duration::from_millis(200));
}

fn running(line: &Line) -> usize {
    let master = line.master();
    let runs = |slave| master.state(slave) == Some(SlaveState::Running);
    master.scan_list().filter(|entry| runs(entry.mac_id)).count()
}

const LONGEST_SCAN: Duration = Duration::from_millis(150);
/// Two seconds are the waits of their network access.
const LATE_RUN_AFTER: Duration = Duration::from_secs(4);
const FIRST_LATE: u8 = 60;
/// When the last four get power.
const LATE: Instant = Instant::from_millis(5000);
/// The slaves that the application talks to without a pause: all their identifiers compete.
const TALKATIVE: [u8; 4] = [1, 20, 40, 59];
/// Get_Attribute_List of everything that the Identity object has: the request takes four fragments, the response eight.
const ATTRIBUTES: [u8; 16] = [7, 0, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0, 7, 0];
