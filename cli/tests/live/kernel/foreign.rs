//! Another program on the same interface, which knows nothing of this project: python-can.

use std::path::Path;
use std::process::Command;

use super::process::Process;
use super::real_kernel::Interface;
use crate::devicenet;

#[path = "../../simulate/python.rs"]
mod python;

/// It asks our slave, disputes MAC IDs with it, and is asked by us. Its log of all that is decoded.
#[test]
#[ignore = "needs vcan"]
fn python_can_is_a_client_a_tool_and_two_devices() {
    let Some(python) = python::with_python_can("python_can_is_a_client_a_tool_and_two_devices") else {
        return;
    };
    let bus = Interface::new("vcan96");
    let mut gauge = Process::node("slave", bus.0, "line.toml", "gauge");
    gauge.until("-> OnLine");
    let log = crate::record::file("foreign.log");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/python/foreign.py");
    let mut foreign = Process::spawn(Command::new(python).arg(script).arg(bus.0).arg(&log));

    foreign.until("has MAC ID 10");
    let mut valve = Process::node("slave", bus.0, "line.toml", "valve");
    valve.until("-> CommFault");
    foreign.until("is asked at MAC ID 20");
    let get = devicenet(&["get", bus.0, "20", "1/1/7", "--allow-tx", "--listen", "1ms"]);
    assert_eq!(
        (get.out().as_str(), get.code()),
        ("node 20  Identity 1 Product name: \"thing\"\n", 0),
        "{}",
        get.err()
    );
    let foreign = foreign.ended();
    assert_eq!(foreign.code, 0, "{}", foreign.err);
    let gauge = gauge.interrupted();
    assert!(!gauge.out.contains("CommFault"), "it has defended its MAC ID: {}", gauge.out);

    let decoded = devicenet(&["decode", log.to_str().unwrap()]);
    for words in [
        "| 5 -> 11  Allocate explicit, master 5\n",
        "| 11 -> 5  Get_Attribute_Single: Product name \"gauge\"\n",
        "| 11 -> 5  last fragment 2 completes Get_Attribute_Single: Data 01 02 03 04 05 06 07 08 09 0A 0B 0C\n",
        "| dup MAC 11 request  vendor 39321 serial 0x00000001",
        "| dup MAC 10 response  vendor 39321 serial 0x0000002A",
        "| 62 -> 20  Allocate explicit, master 62\n",
    ] {
        assert!(decoded.out().contains(words), "{words} is missing in\n{}", decoded.out());
    }
}
