//! Slaves and a master, and those who ask them.

use link_core::frame::standard_id;

use super::process::{Process, wait_for_listeners};
use super::real_kernel::{Interface, run};
use super::witness::Witness;
use crate::devicenet;

fn node(role: &str, bus: &Interface, name: &str) -> Process {
    Process::node(role, bus.0, "line.toml", name)
}

#[test]
#[ignore = "needs vcan"]
fn a_master_has_three_slaves_until_it_is_interrupted() {
    let bus = Interface::new("vcan70");
    let slaves = ["valve", "gauge", "switch"].map(|name| node("slave", &bus, name));
    let mut master = node("master", &bus, "scanner");
    master.until_all(&[
        "slave 10: Configuring -> Running",
        "slave 11: Configuring -> Running",
        "slave 12: Configuring -> Running",
        "slave 10: poll: input data 01 02 03",
        "slave 11: poll: input data 01 02 03 04 05 06 07 08 09 0A 0B 0C",
        "slave 12: COS/cyclic: input data 05",
    ]);
    let master = master.interrupted();
    assert_eq!(master.code, 0, "{}", master.err);
    assert!(master.err.ends_with("note: released the connections of 10, 11, 12\n"), "{}", master.err);
    // They are nobody's at once, and not when the connections have timed out.
    for mac in ["10", "11", "12"] {
        let get = devicenet(&["get", bus.0, mac, "1/1/1", "--allow-tx", "--listen", "1ms"]);
        assert_eq!(get.code(), 0, "{}", get.err());
    }
    let [valve, ..] = slaves.map(Process::interrupted);
    assert_eq!(valve.code, 0, "{}", valve.err);
    assert!(valve.out.contains("poll: output data 80"), "{}", valve.out);
}

#[test]
#[ignore = "needs vcan"]
fn one_mac_id_in_two_processes() {
    let bus = Interface::new("vcan71");
    let mut first = node("slave", &bus, "valve");
    first.until("-> OnLine");
    let mut second = node("slave", &bus, "valve");
    second.until("-> CommFault");
    let (first, second) = (first.interrupted().out, second.interrupted().out);
    assert!(!first.contains("-> CommFault"), "{first}");
    assert!(!second.contains("-> OnLine"), "{second}");
}

#[test]
#[ignore = "needs vcan"]
fn nodes_are_listed_and_asked() {
    let bus = Interface::new("vcan72");
    let mut gauge = node("slave", &bus, "gauge");
    gauge.until("-> OnLine");
    let scan = devicenet(&["scan", bus.0, "--allow-tx", "--listen", "1ms", "--json"]);
    assert_eq!(scan.code(), 0, "{}", scan.err());
    let [object] = &scan.json()[..] else { panic!("{}", scan.out()) };
    assert_eq!((&object["mac"], &object["product_name"]), (&11.into(), &"gauge".into()));
    let get = devicenet(&["get", bus.0, "11", "1/1/6", "--allow-tx", "--listen", "1ms"]);
    assert_eq!(
        (get.out().as_str(), get.code()),
        ("node 11  Identity 1 Serial number: 9030\n", 0),
        "{}",
        get.err()
    );
    let set = devicenet(&["set", bus.0, "11", "3/1/3", "1", "--allow-tx", "--listen", "1ms"]);
    assert_eq!(set.code(), 0, "{}", set.err());
    let get = devicenet(&["get", bus.0, "11", "3/1/3", "--allow-tx", "--listen", "1ms"]);
    assert!(get.out().starts_with("node 11  DeviceNet 1 Bus-off interrupt: "), "{} {}", get.out(), get.err());
    assert_eq!(devicenet(&["get", bus.0, "11", "3/1/3"]).code(), 4, "not without --allow-tx");
}

/// One line says what is wrong and what to do.
#[test]
#[ignore = "needs vcan"]
fn a_node_that_is_not_there_is_a_finding() {
    let bus = Interface::new("vcan73");
    for command in [&["get", bus.0, "13", "1/1/1"][..], &["set", bus.0, "13", "3/1/3", "1"]] {
        let absent = devicenet(&[command, &["--allow-tx", "--listen", "1ms"]].concat());
        assert_eq!((absent.code(), absent.out().as_str()), (1, ""), "{}", absent.err());
        assert_eq!(
            absent.error(),
            "node 13: no answer: it is absent, faulted, or at another bit rate; `devicenet scan` lists who is there"
        );
    }
}

#[test]
#[ignore = "needs vcan"]
fn an_interface_that_goes_down_ends_a_visit() {
    let bus = Interface::new("vcan74");
    let mut witness = Witness::on(bus.0);
    let scan = Process::start(&["scan", bus.0, "--allow-tx", "--listen", "1ms"]);
    // Of MAC ID 62.
    witness.until("its duplicate MAC ID check", |frame| frame.id() == standard_id(0x5F7).into());
    bus.set("down");
    let scan = scan.ended();
    assert_eq!((scan.code, scan.out.as_str()), (3, ""), "{}", scan.err);
    assert!(scan.err.contains("vcan74 went down before everything was asked\n"), "{}", scan.err);
}

#[test]
#[ignore = "needs vcan"]
fn an_interface_that_is_down_is_told_with_what_to_do() {
    let bus = Interface::new("vcan75");
    bus.set("down");
    for command in [
        &["scan", bus.0][..],
        &["scan", bus.0, "--allow-tx"],
        &["get", bus.0, "10", "1/1/1", "--allow-tx"],
        &["set", bus.0, "10", "3/1/3", "1", "--allow-tx"],
        &["recover", bus.0, "--allow-tx"],
        &["slave", bus.0, "line.toml", "--node", "valve", "--allow-tx"],
        &["master", bus.0, "line.toml", "--allow-tx"],
    ] {
        let run = devicenet(&[command, &["--listen", "1ms"]].concat());
        assert_eq!((run.code(), run.out().as_str()), (3, ""), "{command:?} {}", run.err());
        assert_eq!(run.error(), "vcan75 is down; as root: ip link set vcan75 up");
    }
    // All is not well on a bus of which nothing can be heard.
    let file = crate::record::file("down.log");
    for command in [&["record", "--output", file.to_str().unwrap()][..], &["monitor"]] {
        let run = devicenet(&[&[command[0], bus.0, "--for", "10ms"], &command[1..]].concat());
        assert_eq!(run.code(), 3, "{command:?} {}", run.err());
        assert_eq!(run.error(), "vcan75 is down; as root: ip link set vcan75 up");
    }
}

#[test]
#[ignore = "needs vcan"]
fn a_controller_that_is_off_the_bus_is_told_with_what_to_do() {
    let bus = Interface::new("vcan76");
    for listen in ["3s", "1ms"] {
        let get = Process::start(&["get", bus.0, "10", "1/1/1", "--allow-tx", "--listen", listen]);
        wait_for_listeners(bus.0, 1);
        run("cansend", &[bus.0, "20000040#0000000000000000"]);
        let get = get.ended();
        assert_eq!(get.code, 3, "{}", get.err);
        assert!(get.err.contains("bus-off") && get.err.contains("type can restart"), "{}", get.err);
    }
}
