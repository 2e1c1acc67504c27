//! The nodes of DeviceNeX.

use crate::{BUS, VALVE, refused};

/// Six lines; what follows begins on line 7.
const DEVICE: &str = "[bus]
[[node]]
name = \"sensor\"
protocol = \"devicenex\"
role = \"device\"
identity = { vendor = 0x1234, product = 7, serial = 1 }
";

#[test]
fn roles_and_protocols_belong_together() {
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "device"
protocol = "devicenet""#,
        "5:12: the role `device` is not one of devicenet; expected `devicenex`",
    );
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "manager"
protocol = "canopen""#,
        "5:12: there is no protocol `canopen`; expected `devicenet` or `devicenex`",
    );
    refused(
        VALVE,
        r#"[[node]]
name = "a"
role = "device"
protocol = "devicenex"
identity = { vendor = 1, serial = 1 }"#,
        "11:12: `devicenex` beside `devicenet` on one bus; expected one protocol, since both would use the same identifiers",
    );
}

#[test]
fn addresses_and_times() {
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "manager"
protocol = "devicenex""#,
        "2:1: `oa`, the operational address of the manager, is missing",
    );
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "manager"
protocol = "devicenex"
oa = 127"#,
        "6:6: `oa` is 127; expected an operational address, 0 to 126",
    );
    refused(
        DEVICE,
        "oa = 128",
        "7:6: `oa` is 128; expected an operational address, 0 to 126, or 127 for none",
    );
    refused(
        DEVICE,
        "mac = 5",
        "7:7: `mac` means nothing for the role `device`; expected `name`, `count`, `role`, `power_up`, `reaction`, \
         `bit_rate`, `clock_ppm`, `protocol`, `oa`, `identity`, `port`, `boi`, `hello_wait`, `announcement`, `produce`, \
         `consume` or `input`",
    );
    refused(
        DEVICE,
        "hello_wait = \"0s\"",
        "7:14: `hello_wait` is 0s; expected at least 1ms, for others to object",
    );
    refused(
        DEVICE,
        "announcement = \"1500us\"",
        "7:16: `announcement` is 1.5ms; expected whole milliseconds",
    );
}

/// A manager with OA 1, whose table ends in line 14; a database after it begins in line 15.
const MANAGER: &str = "[bus]
[[node]]
name = \"sensor\"
protocol = \"devicenex\"
role = \"device\"
count = 3
identity = { vendor = 0x1234, product = 7, serial = 1 }
[[node]]
name = \"manager\"
protocol = \"devicenex\"
role = \"manager\"
oa = 1
identity = { vendor = 0x1234, product = 1, serial = 9 }

";

#[test]
fn planned_devices() {
    for (entry, expected) in [
        ("device = \"sensor-1\"", "15:1: `oa`, the planned address, is missing"),
        ("oa = 127", "16:6: `oa` is 127; expected an operational address, 0 to 126"),
        ("oa = 5", "15:1: `device`, for whom the address is, is missing"),
        ("oa = 1\ndevice = \"sensor-1\"", "16:6: OA 1 is the manager's own; expected another"),
        ("oa = 125\ndevice = \"sensor\"", "16:6: the addresses rise beyond 126; expected a lower `oa`"),
        (
            "oa = 5\ndevice = \"sensor-1\"\n[[node.planned]]\noa = 5\ndevice = \"sensor-2\"",
            "19:6: OA 5 is planned already; expected another",
        ),
        (
            "oa = 5\ndevice = \"sensor\"\n[[node.planned]]\noa = 9\ndevice = \"sensor-2\"",
            "20:10: this device is planned for OA 6 already; expected another, or every device of a product",
        ),
        (
            "oa = 5\ndevice = \"sensor-1\"\n[[node.planned]]\noa = 9\n\
             device = { vendor = 0x1234, product = 7, serial = 1 }",
            "20:10: this device is planned for OA 5 already; expected another, or every device of a product",
        ),
        (
            "oa = 5\ndevice = { vendor = 1 }",
            "17:10: this is no device; expected the name of a node, or { vendor = 0x1234, product = 7, revision = 1, \
             serial = 0x00002345 }",
        ),
        (
            "oa = 5\ndevice = \"sensr\"",
            "17:10: there is no node `sensr`; expected `manager`, `sensor`, `sensor-1`, `sensor-2` or `sensor-3`",
        ),
    ] {
        refused(MANAGER, &format!("[[node.planned]]\n{entry}"), expected);
    }
}

#[test]
fn planned_connections() {
    for (entry, expected) in [
        ("{ epr = \"1s\" }", "18:16: `connection`, its name, is missing"),
        (
            "{ connection = \"explicit\" }",
            "18:31: the explicit connection is not planned, the manager opens it when it needs it; expected another",
        ),
        (
            "{ connection = \"multicast_consumer\" }",
            "18:31: `multicast_consumer` consumes; expected `from`, whose data it consumes, too",
        ),
        (
            "{ connection = \"multicast_consumer\", from = 9 }",
            "18:60: nobody is planned there; expected the `oa` of an entry, or the name of its device",
        ),
        (
            "{ connection = \"multicast_consumer\", from = \"sensor-1\" }",
            "18:60: OA 5 has no connection on which it sends by itself; expected one, such as `multicast_producer`",
        ),
        (
            "{ connection = \"poll\", watchdog = \"bark\" }",
            "18:50: there is no watchdog `bark`; expected `time_out`, `auto_delete` or `auto_reset`",
        ),
        (
            "{ connection = \"poll\" }, { connection = \"poll\" }",
            "18:41: `poll` is planned twice; a device has each but `dynamic` once",
        ),
        (
            "{ connection = \"dynamic\" }, { connection = \"dynamic\" }, { connection = \"dynamic\" }, \
             { connection = \"dynamic\" }, { connection = \"dynamic\" }",
            "18:128: there are 5 connections; expected at most 4 with one device",
        ),
    ] {
        let plan = format!("[[node.planned]]\noa = 5\ndevice = \"sensor-1\"\nconnections = [{entry}]");
        refused(MANAGER, &plan, expected);
    }
}

#[test]
fn what_can_be_expected() {
    refused(
        DEVICE,
        "[[expect]]\nby = \"1s\"\nnode = \"sensor\"\nstate = \"comm_fault\"",
        "10:9: there is no state `comm_fault`; expected `nonexistent`, `online`, `detecting_bit_rate`, `hello_1`, \
         `hello_2`, `standby`, `bus_off` or `faulted`",
    );
    refused(
        VALVE,
        "[[expect]]\nby = \"1s\"\nnode = \"valve\"\noa = 5",
        "11:6: `valve` has the role `access` and no `oa`; expected a node with the role `device` or `manager`",
    );
    refused(
        DEVICE,
        "[[expect]]\nnever = true\nnode = \"sensor\"\nevent = \"duplicate_mac_id\"",
        "10:9: `sensor` has the role `device` and no event `duplicate_mac_id`; expected a node with the role \
         `access`, `slave`, `master` or `tool`",
    );
}
