//! `monitor` beside those who speak.

use super::process::{Process, wait_for_listeners};
use super::real_kernel::Interface;

fn last(out: &str) -> serde_json::Value {
    serde_json::from_str(out.lines().last().unwrap()).unwrap()
}

#[test]
#[ignore = "needs vcan"]
fn a_master_and_its_slaves_are_watched() {
    let bus = Interface::new("vcan60");
    let mut monitor = Process::start(&["monitor", bus.0, "--json"]);
    wait_for_listeners(bus.0, 1);
    let slaves = ["valve", "gauge", "switch"].map(|name| Process::node("slave", bus.0, "line.toml", name));
    let mut master = Process::node("master", bus.0, "line.toml", "scanner");
    master.until_all(&["slave 10: poll: input data", "slave 11: poll: input data", "slave 12: COS/cyclic"]);
    for _ in 0..3 {
        monitor.until("poll: configuring -> established");
    }
    let watched = monitor.interrupted();
    let summary = last(&watched.out);
    let owned: Vec<u64> = (summary["nodes"].as_array().unwrap().iter())
        .filter(|node| node["state"] == "online" && node["master"] == 1)
        .filter_map(|node| node["mac"].as_u64())
        .collect();
    assert_eq!(owned, [10, 11, 12], "{summary}");
    assert!(summary["load_total"]["poll"].as_f64().unwrap() > 0.0, "{summary}");
    assert_eq!((&summary["last"], &summary["lost"]), (&true.into(), &0.into()), "{}", watched.err);
    drop((master, slaves));
}

/// Who waits for an event hears at once that there can be none.
#[test]
#[ignore = "needs vcan"]
fn a_recorder_tells_of_an_interface_that_goes_down_and_comes_back() {
    let bus = Interface::new("vcan62");
    bus.set("down");
    let file = crate::record::file("waited-for.log");
    let mut recorder = Process::start(&["record", bus.0, "--json", "--output", file.to_str().unwrap()]);
    for state in ["down", "up"] {
        recorder.until(&format!("\"state\":\"{state}\""));
        bus.set("up");
    }
    bus.set("down");
    recorder.until("\"state\":\"down\"");
    let ended = recorder.interrupted();
    assert_eq!(ended.code, 3, "{}", ended.err);
    assert!(ended.err.contains("vcan62 is down; as root: ip link set vcan62 up"), "{}", ended.err);
}

#[test]
#[ignore = "needs vcan"]
fn an_interface_that_is_down_in_the_end_is_told_after_the_summary() {
    let bus = Interface::new("vcan61");
    let mut monitor = Process::start(&["monitor", bus.0, "--json"]);
    monitor.until("\"state\":\"error_active\"");
    bus.set("down");
    monitor.until("\"state\":\"down\"");
    let ended = monitor.interrupted();
    assert_eq!(ended.code, 3, "{}", ended.err);
    assert!(ended.err.contains("vcan61 is down"), "{}", ended.err);
    let last = last(&ended.out);
    assert_eq!((&last["last"], &last["link"]), (&true.into(), &"down".into()));
}
