//! A line or an object for each frame.

use super::{assert_exit, capture, json_lines, run, stderr, stdout, temporary};

const CAPTURES: [&str; 12] = [
    "bei-mhk5-cos.log",
    "candump-L-mixed.log",
    "candump-ta.txt",
    "icpdas-can8124-poll.log",
    "icpdas-i7242d-cyclic.log",
    "inficon-get-set-assembly-path.log",
    "mks-baratron-explicit.log",
    "session-two-slaves-on-vcan.log",
    "slave-01-startup-poll.log",
    "slave-04-fragmented-response.log",
    "socketcan-le-usec.pcap",
    "socketcan.pcapng",
];

#[test]
fn every_capture_gives_a_line_and_an_object_for_each_frame() {
    for name in CAPTURES {
        let text = run(&["decode", &capture(name)]);
        let json = run(&["decode", "--json", &capture(name)]);
        let objects = json_lines(&json);
        assert_eq!(stdout(&text).lines().count(), objects.len(), "{name}");
        assert_eq!(text.status.code(), json.status.code(), "{name}");
        assert_eq!(stderr(&text), "", "{name}");
        assert!(stdout(&text).lines().all(|line| line.contains("  | ")), "{name}");
        for (object, n) in objects.iter().zip(1u64..) {
            let object = object.as_object().unwrap();
            let first: Vec<_> = object.keys().collect();
            for field in ["t", "n", "id", "ext", "rtr", "dlc", "data"] {
                assert!(object.contains_key(field), "{name}: {field} is missing in {first:?}");
            }
            assert_eq!(object["n"], n, "{name}");
        }
    }
}

#[test]
fn json_keeps_every_digit_of_the_time() {
    let output = run(&["decode", "--json", &capture("slave-01-startup-poll.log")]);
    let first = stdout(&output).lines().next().unwrap();
    let start =
        r#"{"t":1700000002.500300,"n":1,"id":1111,"ext":false,"rtr":false,"dlc":7,"data":"00341245230000","#;
    assert!(first.starts_with(start), "{first}");
}

#[test]
fn json_has_the_fields_of_a_response() {
    let output = run(&["decode", "--json", &capture("slave-01-startup-poll.log")]);
    let response = json_lines(&output).swap_remove(5);
    let expected = serde_json::json!({
        "t": 1_700_000_006.020_3, "n": 6, "id": 0x453, "ext": false, "rtr": false, "dlc": 4, "data": "0190c409",
        "channel": "can0", "protocol": "devicenet", "group": 2, "msg": 3, "src": 10, "dst": 1,
        "kind": "explicit_response", "service": 0x10, "service_name": "Set_Attribute_Single",
        "class": 5, "instance": 1, "attribute": 9, "attribute_name": "expected_packet_rate",
        "value": "c409", "value_text": "EPR 2500 ms", "request": { "n": 5, "latency": 0.0003 },
        "text": "10 -> 1  Set_Attribute_Single: EPR 2500 ms",
    });
    assert_eq!(response, expected);
}

#[test]
fn json_has_the_fields_of_what_is_no_devicenet() {
    let objects = json_lines(&run(&["decode", "--json", &capture("candump-L-mixed.log")]));
    let expected = serde_json::json!({
        "t": 1_700_000_000.000_5, "n": 6, "id": 4, "ext": false, "rtr": false, "dlc": 8, "data": "0004000000000000",
        "channel": "can0", "protocol": "unknown", "kind": "foreign",
        "problem": "error frame: controller problem", "problem_code": "error_frame",
        "text": "error frame: controller problem",
    });
    assert_eq!(objects[5], expected);
    assert_eq!((&objects[6]["kind"], &objects[6]["dlc"]), (&"foreign".into(), &9.into()));
}

#[test]
fn text_is_aligned_and_tells_who_and_what() {
    let output = run(&["decode", &capture("icpdas-can8124-poll.log")]);
    let expected = "\
1700000000.000000    10       44E  0A 4B 03 01 07 0A        | 10 -> 9  Allocate explicit + poll + bit-strobe, master 10
1700000000.001000     9       44B  0A CB 00                 | 9 -> 10  Allocate: body format 8/8
1700000000.002000    10       44C  0A 10 05 02 09 0A 0E     | 10 -> 9  Set_Attribute_Single Connection 2 EPR 3594 ms
1700000000.003000     9       44B  0A 90 10 0E              | 9 -> 10  Set_Attribute_Single: EPR 3600 ms (3594 ms requested)
";
    assert_eq!(stdout(&output), expected);
    assert_exit(&output, 0);
}

#[test]
fn formats_of_the_same_traffic_decode_to_the_same_words() {
    let lines = |name| {
        let output = run(&["decode", &capture(name)]);
        stdout(&output).lines().take(20).map(str::to_owned).collect::<Vec<_>>()
    };
    let log = lines("slave-01-startup-poll.log");
    assert_eq!(lines("candump-ta.txt"), log);
    assert_eq!(lines("socketcan-le-usec.pcap"), log);
    assert_eq!(lines("socketcan.pcapng"), log);
}

/// pcapng lets an interface have any name.
#[test]
fn the_name_of_an_interface_does_not_command_the_terminal() {
    use devicenet_cli::recording::{Content, WriteFormat, Writer};
    use link_core::{Frame, Instant, frame::standard_id};
    let mut bytes = Vec::new();
    let mut writer = Writer::new(&mut bytes, WriteFormat::PcapNg).unwrap();
    for name in ["can0", "\u{1B}[31m"] {
        let frame = Content::Classic(Frame::new(standard_id(0x455), &[]).unwrap());
        writer.write(Instant::ZERO, 9, name, &frame).unwrap();
    }
    writer.finish().unwrap();
    let file = temporary("names.pcapng");
    std::fs::write(&file, bytes).unwrap();
    for (arguments, expected) in [
        (&["decode", &file][..], " \u{FFFD}[31m/- "),
        (&["decode", "--summary", &file], "\n\u{FFFD}[31m: 1 frame in "),
    ] {
        let output = run(arguments);
        assert!(
            stdout(&output).contains(expected) && !stdout(&output).contains('\u{1B}'),
            "{}",
            stdout(&output)
        );
    }
    let objects = json_lines(&run(&["decode", "--json", &file]));
    assert_eq!(objects[1]["channel"], "\u{1B}[31m", "JSON escapes it");
}
