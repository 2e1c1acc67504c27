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
         `bit_rate`, `clock_ppm`, `protocol`, `oa`, `identity`, `port`, `boi`, `hello_wait` or `announcement`",
    );
    refused(
        DEVICE,
        "hello_wait = \"0s\"",
        "7:14: `hello_wait` is 0s; expected at least 1ms, for others to object",
    );
    refused(
        DEVICE,
        "announcement = \"1500us\"",
        "7:16: `announcement` is 1.5ms; expected whole milliseconds, 0ms for never",
    );
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
