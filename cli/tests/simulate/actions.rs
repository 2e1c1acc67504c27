//! Actions that cannot be done are told, and do not stop what comes after.

use super::{Scratch, devicenet, stdout};

/// Its switch is turned to the MAC ID that it is to give away.
#[test]
fn a_tool_that_cannot_recover_says_so_and_goes_on() {
    let text = r#"
[bus]
duration = "30s"
[[node]]
name = "tool"
protocol = "devicenet"
role = "tool"
mac = 62
identity = { vendor = 1, serial = 1 }
[[node]]
name = "ear"
role = "external"
[[action]]
at = "1s"
node = "tool"
do = "set_mac"
value = 12
[[action]]
at = "4s"
node = "tool"
do = "recover"
value = { vendor = 1, serial = 2, mac = 12 }
[[action]]
at = "4s"
node = "tool"
do = "who"
[[expect]]
by = "30s"
node = "tool"
event = "who_done"
"#;
    let scenario = Scratch::new("recover.toml", text);
    let output = devicenet(&["simulate", scenario.path()]);
    let told = "the action recover has no effect: MAC ID 12 is the tool's own: give the device another";
    assert!(stdout(&output).contains(told), "{}", stdout(&output));
    assert_eq!(output.status.code(), Some(0), "{}", stdout(&output));
}

/// A master whose switch is turned to the MAC ID of the only slave of its multicast poll has no such command any more.
#[test]
fn a_master_with_the_mac_id_of_its_only_multicast_slave_does_without() {
    let text = r#"
[bus]
duration = "4s"
[[node]]
name = "master"
protocol = "devicenet"
role = "master"
mac = 1
identity = { vendor = 1, serial = 1 }
[[node.scan]]
mac = 10
multicast_poll = { produce = 1, consume = 2, epr = "100ms" }
[[node]]
name = "ear"
role = "external"
[[action]]
at = "1s"
node = "master"
do = "set_mac"
value = 10
[[expect]]
by = "4s"
node = "master"
state = "online"
"#;
    let scenario = Scratch::new("alone.toml", text);
    let output = devicenet(&["simulate", scenario.path()]);
    assert_eq!(output.status.code(), Some(0), "{}", stdout(&output));
}
