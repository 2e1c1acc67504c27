//! DeviceNeX: which protocol is assumed, the words, the objects, the selection, the summary.
//!
//! `nex.log` is written by hand. Hello, Mini-who and ROAM are those of the paper's figures 3, 4 and 6, connection requests and responses
//! those of figures 7 and 8; the identifiers of the others are those of the profile (`devicenex_core::id`).

use std::path::PathBuf;

use serde_json::json;

use super::{assert_exit, capture, json_lines, run, run_with_input, stderr, stdout};

fn recording() -> String {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/decode/nex.log");
    path.to_str().expect("a path in UTF-8").to_owned()
}

#[test]
fn a_recording_of_devicenex_is_told_by_its_first_hello() {
    let output = run(&["decode", &recording()]);
    assert_exit(&output, 1);
    assert_eq!(stderr(&output), format!("note: {}: decoded as DeviceNeX: frame 1 is a Hello\n", recording()));
    let expected = "  0.000000     1  1F020100  00 00 23 01 01 00 01 00  | Hello 1 OA 1  vendor 291, product 1, revision 1, serial 0x00000001
  1.000000     1  1F020100  00 00 23 01 01 00 01 00  | Hello 2 OA 1  vendor 291, product 1, revision 1, serial 0x00000001
  2.000000     1  1FFE0100  remote [8]               | Mini-who of 1
  2.000500   127  1FFE4433  22 11 23 01 56 04 02 00  | Hello OA 127  vendor 291, product 1110, revision 2, serial 0x11223344 (assumed)
  2.001000     -  1EFE4433  22 11 23 01 56 04 02 43  | ROAM to OA 67  vendor 291, product 1110, revision 2, serial 0x11223344
  2.001500    67  1F864433  22 11 23 01 56 04 02 00  | Hello 1 OA 67  vendor 291, product 1110, revision 2, serial 0x11223344
  3.001500    67  1F864433  22 11 23 01 56 04 02 00  | Hello 2 OA 67  vendor 291, product 1110, revision 2, serial 0x11223344
  4.100000     1  1C860203  0E 01 01 07              | 1 -> 67  connectionless Get_Attribute_Single Identity 1 Product name
  4.100500    67  1C038700  03 8E 08 47 52 54 31 2D  | 67 -> 1  first fragment 0  03 8E 08 47 52 54 31 2D
  4.101000     1  1C8603C0  00                       | 1 -> 67  acknowledge of fragment 0
  4.101500    67  1C038781  44 52 54                 | 67 -> 1  last fragment 1 completes connectionless Get_Attribute_Single: Product name \"GRT1-DRT\"
  4.102000     1  1C8603C1  00                       | 1 -> 67  acknowledge of fragment 1
  4.200000     1  1D860209  4B C0 07 00 F4 01 02     | 1 -> 67  Connect multicast, producing, 29 bits, EPR 500 ms, Auto reset, Message ID 0
  4.200500    67  1D038609  4B C2 00 F4 01           | 67 -> 1  Connect: multicast, producing, 29 bits, EPR 500 ms, Message ID 2, body format 8/8
  4.300000    67  02860007  03 6B                    | multicast 67 -> *  03 6B
  4.400000     1  1D86020A  4B C0 0E 00 00 00 00     | 1 -> 67  Connect reserved 14 as predefined, 29-bit implicit, EPR 0 ms, Transition to timed out, Message ID 0
  4.400500    67  1D03860A  94 05 FF                 | 67 -> 1  Connect: error 0x05 Path destination unknown  ! refused: 0x05 Path destination unknown
  4.500000     -       782  0A 4B 00 31              | not DeviceNeX  0A 4B 00 31  ! 11-bit identifier that DeviceNeX does not use
";
    assert_eq!(stdout(&output), expected);
}

/// The other protocol's frames are foreign to each.
#[test]
fn what_is_said_on_the_command_line_is_what_counts() {
    let told = run(&["decode", "--protocol", "devicenex", &recording()]);
    assert_eq!((stdout(&told), stderr(&told)), (stdout(&run(&["decode", &recording()])), ""));
    let other = run(&["decode", "--json", "--protocol", "devicenet", &recording()]);
    let kinds: Vec<_> = json_lines(&other).iter().map(|frame| frame["kind"].clone()).collect();
    assert_eq!(kinds.iter().filter(|kind| **kind == "foreign").count(), 17);
    let slave = capture("slave-01-startup-poll.log");
    let heard = run(&["decode", &slave]);
    assert_eq!(stderr(&heard), "");
    let other = run(&["decode", "--json", "--protocol", "devicenex", &slave]);
    assert!(json_lines(&other).iter().all(|frame| frame["protocol"] != "devicenet"));
}

#[test]
fn frames_that_tell_nothing_are_devicenet_unless_all_have_29_bits() {
    let of = |input: &str| run_with_input(&["decode", "--json", "-"], input);
    let io = of("(1.0) can0 3C5#01\n");
    assert_eq!((json_lines(&io)[0]["protocol"].clone(), stderr(&io)), (json!("devicenet"), ""));
    let nex = of("(1.0) can0 02860007#01\n");
    assert_eq!(json_lines(&nex)[0]["protocol"], "devicenex");
    assert!(stderr(&nex).contains("decoded as DeviceNeX: the first frames have 29-bit identifiers"));
    // J1939 on a DeviceNet cable.
    let other = of("(1.0) can0 18FEF1FE#01\n(1.1) can0 3C5#01\n");
    assert_eq!(json_lines(&other)[0]["kind"], "foreign");
    assert!(stderr(&other).contains("decoded as DeviceNet: nothing in the first frames tells"));
}

#[test]
fn the_objects_say_what_the_words_say() {
    let frames = json_lines(&run(&["decode", "--json", &recording()]));
    let pick = |n: usize, keys: &[&str]| -> serde_json::Value {
        keys.iter().map(|key| frames[n - 1][*key].clone()).collect()
    };
    assert_eq!(
        pick(1, &["protocol", "kind", "src", "stage"]),
        json!(["devicenex", "hello_request", 1, "first"])
    );
    assert_eq!(pick(3, &["kind", "src", "dst", "serial_low"]), json!(["mini_who", 1, 127, 1]));
    assert_eq!(
        pick(4, &["stage", "vendor", "product", "revision", "serial", "port", "assumed"]),
        json!(["asked", 0x0123, 0x0456, 2, 0x1122_3344, 0, true])
    );
    assert_eq!(pick(5, &["kind", "dst", "requested_oa"]), json!(["roam", 127, 67]));
    assert_eq!(pick(6, &["request"]), json!([{ "n": 5, "latency": 0.0005 }]));
    assert_eq!(
        pick(8, &["kind", "transaction", "service_name", "class", "instance", "attribute"]),
        json!(["connectionless_request", 3, "Get_Attribute_Single", 1, 1, 7])
    );
    assert_eq!(pick(11, &["frag"]), json!([{ "type": "last", "count": 1 }]));
    assert_eq!(frames[10]["message"]["value_text"], "Product name \"GRT1-DRT\"");
    assert_eq!(frames[10]["message"]["kind"], "connectionless_response");
    assert_eq!(
        pick(
            13,
            &["kind", "predefined", "group_select", "source_message", "instance", "epr", "watchdog_action"]
        ),
        json!(["connection_request", true, 4, 0, 7, 500, 2])
    );
    assert_eq!(pick(14, &["source_message", "instance", "epr", "body_format"]), json!([2, 7, 500, 0]));
    assert_eq!(
        pick(15, &["kind", "msg", "value", "connection"]),
        json!(["implicit", 2, "036b", {
            "server": 67, "client": 1, "instance": 7, "name": "multicast, producing, 29 bits", "state": "established"
        }])
    );
    assert_eq!(pick(17, &["status", "problem_code"]), json!([5, "connection_refused"]));
    assert_eq!(pick(18, &["protocol", "kind"]), json!(["unknown", "foreign"]));
}

#[test]
fn frames_are_selected_by_address_and_kind() {
    let texts = |options: &[&str]| -> Vec<u64> {
        let output = run(&[&["decode", "--json"], options, &[&recording()]].concat());
        json_lines(&output).iter().map(|frame| frame["n"].as_u64().unwrap()).collect()
    };
    assert_eq!(texts(&["--oa", "67"]), [3, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17]);
    assert_eq!(texts(&["--mac", "0x7F"]), [3, 4, 5]);
    assert_eq!(texts(&["--kind", "roam,mini_who"]), [3, 5]);
    assert_eq!(texts(&["--kind", "fragment_ack"]), [10, 12]);
    assert_eq!(texts(&["--kind", "poll_command"]), [0_u64; 0]);
}

#[test]
fn options_of_devicenet_are_refused() {
    for (options, told) in [
        (&["--protocol", "devicenex", "--scanlist"][..], "--scanlist is for DeviceNet"),
        (&["--oa", "100", "--eds", "x.eds"], "--eds is for DeviceNet"),
        (&["--protocol", "devicenet", "--mac", "64"], "a MAC ID of DeviceNet is 0 to 63"),
        (&["--mac", "128"], "an operational address of DeviceNeX 0 to 127"),
    ] {
        let output = run(&[&["decode"], options, &[&recording()]].concat());
        assert_exit(&output, 2);
        assert!(stderr(&output).contains(told), "{}", stderr(&output));
    }
}

#[test]
fn the_summary_has_a_row_for_each_node_and_connection() {
    let output = run(&["decode", "--summary", "--json", &recording()]);
    let rows = json_lines(&output);
    let of = |summary: &str| rows.iter().filter(|row| row["summary"] == summary).collect::<Vec<_>>();
    let nodes: Vec<_> = of("node")
        .iter()
        .map(|row| (row["node"].clone(), row["frames"].clone(), row["access"].clone()))
        .collect();
    assert_eq!(
        nodes,
        [
            (json!(1), json!(8), json!("online")),
            (json!(67), json!(7), json!("online")),
            (json!(127), json!(1), json!(null)),
            (json!(null), json!(2), json!(null)),
        ]
    );
    let connections: Vec<_> = of("connection")
        .iter()
        .map(|row| (row["node"].clone(), row["connection"].clone(), row["frames"].clone()))
        .collect();
    assert_eq!(
        connections,
        [
            (json!(null), json!("network access"), json!(7)),
            (json!(67), json!("connection requests"), json!(3)),
            (json!(67), json!("connectionless"), json!(5)),
            (json!(67), json!("multicast, producing, 29 bits"), json!(2)),
        ]
    );
    let problems: Vec<_> = of("problem").iter().map(|row| row["problem"].clone()).collect();
    assert_eq!(problems, [json!("connection_refused"), json!("standard_identifier")]);
    let words = run(&["decode", "--summary", &recording()]);
    assert!(stdout(&words).contains("vendor 291, serial 0x11223344"), "{}", stdout(&words));
}
