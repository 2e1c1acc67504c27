//! What an interface is, and what happens to it while a command runs.

use std::process::{Child, Command, Stdio};

use link_core::Frame;
use link_core::frame::standard_id;

use super::adapter::Adapter;
use super::process::{Process, wait_for_listeners};
use super::real_kernel::{Interface, ip, run};
use super::witness::Witness;
use crate::devicenet;

#[test]
#[ignore = "needs slcan"]
fn a_listen_only_interface_is_told_before_anything_is_sent() {
    let adapter = Adapter::attach("slcan90", &[]);
    adapter.set_up(&["bitrate", "125000", "listen-only", "on"]);
    for command in [
        &["scan", adapter.name][..],
        &["get", adapter.name, "10", "1/1/1"],
        &["set", adapter.name, "10", "3/1/3", "1"],
        &["recover", adapter.name],
        &["slave", adapter.name, "line.toml", "--node", "valve"],
        &["master", adapter.name, "line.toml"],
    ] {
        let run = devicenet(&[command, &["--allow-tx"]].concat());
        assert_eq!((run.code(), run.out().as_str()), (4, ""), "{command:?} {}", run.err());
        assert_eq!(
            run.error(),
            "slcan90 is listen-only, so it sends nothing; as root: ip link set slcan90 down && ip link set slcan90 type can \
             listen-only off && ip link set slcan90 up"
        );
    }
    let scan = devicenet(&["scan", adapter.name, "--listen", "1ms"]);
    assert_eq!(scan.code(), 0, "it may listen: {}", scan.err());
}

#[test]
#[ignore = "needs slcan"]
fn one_frame_confirms_the_bit_rate_of_a_controller() {
    let mut adapter = Adapter::attach("slcan91", &[]);
    adapter.set_up(&["bitrate", "125000"]);
    let get = devicenet(&["get", adapter.name, "10", "1/1/1", "--allow-tx", "--listen", "10ms"]);
    assert_eq!(get.code(), 4, "{}", get.err());
    assert!(get.error().starts_with("nothing was heard on slcan91 in 10ms"), "{}", get.err());
    let node = ["slave", adapter.name, "line.toml", "--node", "valve", "--allow-tx", "--listen", "2s"];
    let mut slave = Process::start(&node);
    wait_for_listeners(adapter.name, 1);
    // A check of node 11 for its MAC ID.
    adapter.says("t45F700341246230000\r");
    slave.until("NonExistent -> SendingDupMac");
    // Nothing was sent before that of the slave.
    let heard = adapter.hears("t457700341245230000\r");
    assert_eq!(heard.matches('t').count(), 1, "{heard}");
    assert_eq!(slave.interrupted().code, 0);
}

/// Frames of a program.
struct Crowd(Child);

impl Crowd {
    /// As fast as it can write them, on a machine with one processor.
    fn on(bus: &Interface) -> Self {
        Self::every("0", "3CA", bus)
    }

    fn every(milliseconds: &str, id: &str, bus: &Interface) -> Self {
        let arguments = [bus.0, "-g", milliseconds, "-I", id, "-L", "8"];
        // Behind whoever else has something to do.
        let crowd =
            Command::new("nice").args(["-n", "19", "cangen"]).args(arguments).stdout(Stdio::null()).spawn();
        Self(crowd.unwrap())
    }
}

impl Drop for Crowd {
    fn drop(&mut self) {
        let _ = self.0.kill().and_then(|()| self.0.wait());
    }
}

/// There is always one more frame; the end comes all the same.
#[test]
#[ignore = "needs vcan"]
fn the_end_comes_on_a_crowded_bus() {
    let bus = Interface::new("vcan92");
    let crowd = Crowd::on(&bus);
    let file = crate::record::file("crowded.log");
    for command in [
        &["record", bus.0, "--trigger", "bus-off", "--for", "300ms", "-o", file.to_str().unwrap()][..],
        &["scan", bus.0, "--listen", "300ms"],
        &[
            "slave",
            bus.0,
            "line.toml",
            "--node",
            "valve",
            "--allow-tx",
            "--listen",
            "100ms",
            "--for",
            "300ms",
        ],
        &["master", bus.0, "line.toml", "--allow-tx", "--listen", "0s", "--for", "300ms"],
    ] {
        let ended = Process::start(command).ended();
        // In this time a master has no I/O with anybody.
        let code = i32::from(command[0] == "master");
        assert_eq!(ended.code, code, "{command:?} {}", ended.err);
    }
    // So it does when it is interrupted.
    let record = Process::start(&["record", bus.0, "--trigger", "bus-off", "-o", file.to_str().unwrap()]);
    wait_for_listeners(bus.0, 1);
    assert_eq!(record.interrupted().code, 0);
    drop(crowd);
}

/// The interface is switched off and on, and the adapter unplugged and plugged in again, while a master polls. Nobody is started anew.
#[test]
#[ignore = "needs vcan"]
fn io_goes_on_when_the_interface_is_back() {
    let bus = Interface::new("vcan93");
    let mut slaves =
        ["valve", "gauge", "switch"].map(|name| Process::node("slave", bus.0, "line.toml", name));
    let mut master = Process::node("master", bus.0, "line.toml", "scanner");
    let is_up = [
        "slave 10: poll: input data 01 02 03",
        "slave 11: poll: input data 01 02 03 04 05 06 07 08 09 0A 0B 0C",
        "slave 12: COS/cyclic: input data 05",
    ];
    let is_down =
        ["slave 10: Running -> Offline", "slave 11: Running -> Offline", "slave 12: Running -> Offline"];
    master.until_all(&is_up);
    slaves[0].until("poll: output data 80");
    let switched: [fn(&Interface); 2] = [|bus| bus.set("down"), |bus| bus.set("up")];
    for [take, give] in [switched, [Interface::unplug, Interface::plug]] {
        take(&bus);
        master.until_all(&is_down);
        give(&bus);
        let mut witness = Witness::on(bus.0);
        master.until_all(&is_up);
        slaves[0].until("poll: output data 80");
        let mut polls = 0;
        // The response of node 10, with its inputs.
        witness.until("polls", |frame| {
            polls += usize::from(frame.id() == standard_id(0x3CA).into() && frame.data() == [1, 2, 3]);
            polls >= 20
        });
    }
    assert_eq!(master.interrupted().code, 0);
    assert!(slaves.map(Process::interrupted).iter().all(|slave| slave.code == 0));
}

/// It never restarts by itself, so it is of no use from then on.
#[test]
#[ignore = "needs vcan"]
fn a_node_that_is_bus_off_in_the_end_has_failed() {
    let bus = Interface::new("vcan104");
    for (role, name) in [("slave", "valve"), ("master", "scanner")] {
        let mut node = Process::node(role, bus.0, "line.toml", name);
        node.until("-> OnLine");
        run("cansend", &[bus.0, "20000040#0000000000000000"]);
        node.until("OnLine -> CommFault");
        let ended = node.interrupted();
        assert_eq!(ended.code, 1, "{role} {}", ended.err);
        assert!(
            ended.err.ends_with("check the bit rate, the cable and its terminators\n"),
            "{role} {}",
            ended.err
        );
    }
}

/// An interface that echoes what has left its queue, which it does not within the test, and tells of no error.
#[test]
#[ignore = "needs vcan"]
fn a_driver_that_says_nothing_is_told_once() {
    let bus = Interface::new("vcan105");
    run("tc", &["qdisc", "add", "dev", bus.0, "root", "netem", "delay", "60s"]);
    let node =
        ["slave", bus.0, "line.toml", "--node", "valve", "--allow-tx", "--listen", "1ms", "--for", "12s"];
    let ended = Process::start(&node).ended();
    // After three seconds, and after six more.
    assert_eq!(ended.out.matches("not sent").count(), 2, "{}", ended.out);
    let told = "vcan105: its driver tells neither that a frame was sent nor of an error";
    assert_eq!(ended.err.matches(told).count(), 1, "{}", ended.err);
}

/// The same, but others are heard: whoever looks for a wrong bit rate looks in vain.
#[test]
#[ignore = "needs vcan"]
fn a_driver_that_says_nothing_on_a_bus_that_is_alive_is_no_lone_node() {
    let bus = Interface::new("vcan106");
    run("tc", &["qdisc", "add", "dev", bus.0, "root", "netem", "delay", "4s"]);
    // Of the check for its MAC ID of another node, which a tool listens to while it is on its own.
    let _others = Crowd::every("200", "42F", &bus);
    Witness::on(bus.0).until("the first of them", |_| true);
    let ended = Process::start(&["recover", bus.0, "--allow-tx", "--listen", "1ms"]).ended();
    let told = "vcan106: its driver does not tell that a frame was sent, though others are heard";
    assert_eq!(ended.err.matches(told).count(), 1, "{}{}", ended.out, ended.err);
    assert!(!ended.err.contains("tells neither"), "{}", ended.err);
}

/// A master and eight slaves on an interface that has room for one frame, and sends one in a millisecond: whoever comes second hears that
/// there is no room. Every poll is answered once all the same, and none is sent before the last was answered.
#[test]
#[ignore = "needs vcan"]
fn a_full_transmit_queue_loses_nothing() {
    let bus = Interface::new("vcan94");
    ip(&["link", "set", bus.0, "txqueuelen", "1"]);
    run("tc", &["qdisc", "add", "dev", bus.0, "root", "netem", "rate", "128kbit", "limit", "1"]);
    let file = crate::record::file("crowded.toml");
    std::fs::write(&file, crowded()).unwrap();
    let file = file.to_str().unwrap();
    let mut slaves = CROWD.map(|mac| Process::node("slave", bus.0, file, &format!("slave-{mac}")));
    slaves.iter_mut().for_each(|slave| slave.until("-> OnLine"));
    let mut master = Process::node("master", bus.0, file, "scanner");
    master.until_all(
        &CROWD.map(|mac| format!("slave {mac}: Configuring -> Running")).each_ref().map(String::as_str),
    );

    let mut witness = Witness::on(bus.0);
    let mut polls = CROWD.map(|mac| Polls { mac, answered: 0, is_asked: None });
    witness.until("polls of every slave", |frame| {
        polls.iter_mut().for_each(|polls| polls.see(frame));
        polls.iter().all(|polls| polls.answered >= 50)
    });
    let statistics = run("tc", &["-s", "qdisc", "show", "dev", bus.0]);
    assert!(!statistics.contains("dropped 0,"), "nobody found the queue full: {statistics}");
    let master = master.interrupted();
    assert!(!master.out.contains("Running -> "), "{}", master.out);
    assert_eq!(master.code, 0, "{}", master.err);
    assert!(
        master.err.ends_with("released the connections of 10, 11, 12, 13, 14, 15, 16, 17\n"),
        "{}",
        master.err
    );
}

/// The polls of a slave, of which the beginning may not have been seen.
struct Polls {
    mac: u16,
    answered: u32,
    is_asked: Option<bool>,
}

impl Polls {
    fn see(&mut self, frame: &Frame) {
        let is = |id| frame.id() == standard_id(id).into();
        if is(0x405 | self.mac << 3) {
            assert_ne!(
                self.is_asked.replace(true),
                Some(true),
                "slave {}: a poll was not answered",
                self.mac
            );
        } else if is(0x3C0 | self.mac) {
            assert_ne!(self.is_asked.replace(false), Some(false), "slave {}: it answers twice", self.mac);
            self.answered += 1;
        }
    }
}

/// The time that a busy machine takes is not what this is about.
fn crowded() -> String {
    let identity = |serial| format!("identity = {{ vendor = 0x1234, serial = {serial} }}\n");
    let mut text = String::from("[bus]\nduration = \"60s\"\n");
    for mac in CROWD {
        text += &format!(
            "[[node]]\nname = \"slave-{mac}\"\nprotocol = \"devicenet\"\nrole = \"slave\"\nmac = {mac}\n"
        );
        text += &format!("poll = {{ produce = 8, consume = 8 }}\n{}", identity(mac));
    }
    text += "[[node]]\nname = \"scanner\"\nprotocol = \"devicenet\"\nrole = \"master\"\nmac = 1\nresponse_wait = \"500ms\"\n";
    text += &identity(1);
    for mac in CROWD {
        text += &format!("[[node.scan]]\nmac = {mac}\npoll = {{ produce = 8, consume = 8 }}\nepr = \"1s\"\n");
    }
    text
}

const CROWD: [u16; 8] = [10, 11, 12, 13, 14, 15, 16, 17];
