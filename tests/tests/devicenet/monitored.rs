//! The vectors through the monitor: all frames of one source, in their order, through one monitor, with what the meaning
//! of each vector says in the fields of the reading.
//!
//! Frames are missing between the vectors, so what needs them is assumed, and a fragment can be without its first.

use std::collections::BTreeMap;

use devicenet_core::MacId;
use devicenet_core::monitor::Predefined;
use serde_json::{Value, json};

use crate::harness::{Line, Observer};
use crate::vectors::{Kind, VECTORS};

/// Number, and fields that the reading must have with these values; `null` demands that the field is absent.
fn expectations() -> BTreeMap<u16, Value> {
    let get = |class: u16, instance: u16, attribute: u16| {
        json!({ "kind": "explicit_request", "service": 0x0E, "class": class, "instance": instance,
                "attribute": attribute, "problem": null })
    };
    let set = |class: u16, instance: u16, attribute: u16, value: &str, text: &str| {
        json!({ "kind": "explicit_request", "service": 0x10, "class": class, "instance": instance,
                "attribute": attribute, "value": value, "value_text": text, "problem": null })
    };
    let got = |value: &str| json!({ "kind": "explicit_response", "service": 0x0E, "value": value, "problem": null });
    let ack = |src: u8, dst: u8, count: u8| {
        json!({ "kind": "fragment_ack", "src": src, "dst": dst, "problem": null,
                "frag": { "type": "ack", "count": count, "status": 0 } })
    };
    let table = [
        (
            2,
            json!({ "kind": "group2_unconnected_request", "group": 2, "msg": 6, "src": 10, "dst": 9, "service": 0x4B,
            "class": 3, "instance": 1, "choice": 7, "value_text": "master 10", "problem": null, "assumed": null }),
        ),
        (
            4,
            json!({ "kind": "explicit_response", "src": 9, "dst": 10, "service": 0x10, "value": "100e",
            "problem": null, "assumed": true }),
        ),
        (6, set(5, 4, 9, "0a0e", "EPR 3594 ms")),
        (8, set(3, 1, 2, "01", "Baud rate 250 kbit/s")),
        (
            10,
            json!({ "kind": "offline_fault_request", "group": 4, "msg": 0x2D, "service": 0x4B, "service_name": "Who",
            "value_text": "all nodes, delay by byte 2", "problem": null }),
        ),
        (
            12,
            json!({ "kind": "poll_command", "dst": 9, "frag": { "type": "last", "count": 1 }, "problem": null,
            "message": null, "assumed": true }),
        ),
        (14, set(0x65, 1, 1, "014600", "attribute 1 01 46 00")),
        (16, set(5, 1, 9, "0000", "EPR 0 ms")),
        (18, set(5, 2, 9, "0000", "EPR 0 ms")),
        (20, set(5, 4, 9, "0000", "EPR 0 ms")),
        (
            22,
            json!({ "kind": "group2_unconnected_request", "src": 10, "dst": 3, "service": 0x4C, "class": 3,
            "choice": 0x51, "problem": null }),
        ),
        // The fragments that it acknowledges are missing.
        (
            24,
            json!({ "kind": "fragment_ack", "src": 3, "dst": 10,
            "frag": { "type": "ack", "count": 1, "status": 0 }, "problem_code": "unknown_acknowledge" }),
        ),
        (
            26,
            json!({ "kind": "fragment", "src": 0, "dst": 3, "frag": { "type": "first", "count": 0 },
            "problem": null }),
        ),
        // The fragment that it acknowledges is missing.
        (
            28,
            json!({ "kind": "fragment_ack", "src": 3, "dst": 0,
            "frag": { "type": "ack", "count": 1, "status": 0 } }),
        ),
        (30, json!({ "kind": "fragment", "src": 3, "dst": 0, "frag": { "type": "first", "count": 0 } })),
        (
            32,
            json!({ "kind": "fragment_ack", "src": 0, "dst": 3,
            "frag": { "type": "ack", "count": 1, "status": 0 } }),
        ),
        (34, json!({ "kind": "poll_command", "dst": 5, "value": null, "problem": null })),
        (36, json!({ "src": 5, "problem_code": "misplaced_poll_response" })),
        (
            38,
            json!({ "kind": "dup_mac_request", "src": 1, "port": 0, "vendor": 8, "serial": 0x1289_F506,
            "problem": null }),
        ),
        (
            40,
            json!({ "kind": "explicit_response", "src": 2, "dst": 1, "service": 0x4B,
            "value_text": "body format 8/8", "problem": null, "assumed": true }),
        ),
        (42, set(5, 1, 12, "03", "watchdog_timeout_action Deferred delete")),
        // Its request is missing, and no. 42 waits with the other transaction ID.
        (
            44,
            json!({ "kind": "explicit_response", "service": 0x0E, "value": "6c00",
            "problem_code": "transaction_mismatch" }),
        ),
        (46, get(1, 1, 2)),
        // It answers another request than no. 46, which asks for the device type.
        (48, json!({ "kind": "explicit_response", "service": 0x0E, "value": "8214", "problem": null })),
        (
            50,
            json!({ "kind": "explicit_request", "msg": 4, "service": 0x4B, "class": 3, "instance": 1, "choice": 2,
            "problem": null }),
        ),
        (52, get(5, 2, 8)),
        (54, set(5, 2, 9, "fa00", "EPR 250 ms")),
        (
            56,
            json!({ "kind": "poll_command", "dst": 2, "frag": { "type": "last", "count": 1 }, "message": null }),
        ),
        (
            58,
            json!({ "kind": "poll_response", "src": 2, "frag": { "type": "first", "count": 0 }, "message": null,
            "problem": null }),
        ),
        (60, json!({ "kind": "explicit_response", "src": 2, "dst": 0, "service": 0x4B, "problem": null })),
        (
            62,
            json!({ "kind": "group2_unconnected_request", "service": 0x4C, "choice": 1, "src": 0, "dst": 2,
            "problem": null }),
        ),
        (64, got("6c05")),
        (66, get(1, 1, 7)),
        (
            68,
            json!({ "kind": "fragment", "src": 2, "frag": { "type": "last", "count": 1 }, "message": null }),
        ),
        (70, ack(0, 2, 1)),
        (72, set(5, 1, 9, "8200", "EPR 130 ms")),
        (
            74,
            json!({ "kind": "explicit_response", "service": 0x10, "class": 5, "instance": 1, "attribute": 9,
            "value": "8200", "value_text": "EPR 130 ms", "request": { "n": 7, "latency": 0.001 },
            "problem": null }),
        ),
        // Its request is missing, and the request before it is answered.
        (
            76,
            json!({ "kind": "explicit_response", "service": 5, "service_name": "Reset",
            "problem_code": "unexpected_response" }),
        ),
        (
            78,
            json!({ "kind": "unconnected_request", "group": 3, "msg": 6, "src": 0, "dst": 63, "service": 0x4B,
            "value_text": "Group 3 Message ID 4, body format 16/16", "problem": null }),
        ),
        (
            80,
            json!({ "kind": "explicit_response", "group": 3, "msg": 4, "src": 63, "dst": 0, "service": 0x4B,
            "value_text": "body format 16/16", "problem": null, "assumed": true }),
        ),
        (82, get(1, 1, 1)),
        (
            84,
            json!({ "kind": "explicit_response", "src": 63, "dst": 0, "service": 0x0E, "value": "0000",
            "problem": null }),
        ),
        (86, get(1, 1, 3)),
        // The fragments that it acknowledges are missing.
        (
            88,
            json!({ "kind": "fragment_ack", "src": 63, "dst": 0,
            "frag": { "type": "ack", "count": 0, "status": 0 } }),
        ),
        (
            90,
            json!({ "kind": "fragment", "src": 0, "dst": 63, "frag": { "type": "last", "count": 1 },
            "message": null }),
        ),
        (92, get(5, 2, 7)),
        (
            94,
            json!({ "kind": "explicit_response", "service": 0x0E, "class": 5, "instance": 2, "attribute": 7,
            "value": "2000", "value_text": "produced_connection_size 32", "problem": null }),
        ),
        (
            96,
            json!({ "kind": "unconnected_response", "src": 63, "dst": 0, "service": 0x4C,
            "service_name": "Close_Connection" }),
        ),
        (
            98,
            json!({ "kind": "poll_command", "dst": 63, "frag": { "type": "first", "count": 0 }, "problem": null,
            "message": null }),
        ),
        (
            100,
            json!({ "kind": "poll_command", "frag": { "type": "middle", "count": 3 }, "message": null,
            "problem": "fragment 3 after 0" }),
        ),
        (
            102,
            json!({ "kind": "poll_command", "frag": { "type": "last", "count": 4 }, "message": null,
            "problem_code": "no_first_fragment" }),
        ),
        (
            104,
            json!({ "kind": "offline_ownership_request", "src": 1, "service": 0x4B, "vendor": 6,
            "serial": 0x0506_0708, "problem": null }),
        ),
        (
            106,
            json!({ "kind": "offline_ownership_response", "src": 1, "service": 0x4B, "vendor": 6,
            "request": { "n": 1, "latency": 0.001 }, "problem": null }),
        ),
        (
            108,
            json!({ "kind": "offline_fault_request", "service": 0x4D, "service_name": "Change_MAC_ID",
            "value_text": "to 3", "vendor": 6, "serial": 0x0506_0708, "problem": null }),
        ),
        (
            110,
            json!({ "kind": "offline_fault_response", "port": 0, "vendor": 6, "serial": 0x0506_0708,
            "problem": null }),
        ),
        (
            112,
            json!({ "kind": "shutdown", "src": 3, "class": 4, "instance": 2,
            "value_text": "Assembly 2, vendor-specific code 0x0201", "problem": null }),
        ),
        (
            114,
            json!({ "kind": "explicit_response", "src": 3, "dst": 10, "service": 0x14, "status": 2, "additional": 3,
            "status_name": "Resource unavailable", "problem": null }),
        ),
        (
            116,
            json!({ "kind": "unconnected_request", "src": 0, "dst": 5, "service": 0x4C, "instance": 2,
            "problem": null }),
        ),
        (
            118,
            json!({ "kind": "unconnected_response", "src": 5, "dst": 0, "service": 0x4C,
            "request": { "n": 7, "latency": 0.001 }, "instance": 2, "problem": null }),
        ),
    ];
    table.into_iter().collect()
}

#[test]
fn every_vector_is_read_as_its_meaning_says() {
    let expectations = expectations();
    assert!(
        expectations.keys().copied().eq(VECTORS.iter().map(|vector| vector.number)),
        "every vector has one"
    );
    let mut wrong = Vec::new();
    for (number, line) in read_all() {
        let object = line.json.as_object().expect("an object");
        let wanted = expectations[&number].as_object().expect("an object");
        for (field, value) in wanted {
            let found = object.get(field).unwrap_or(&Value::Null);
            if found != value {
                wrong.push(format!("no. {number}: {field} is {found}, {value} expected, in {}", line.text));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A misprint must not pass.
#[test]
fn misprints_are_flagged() {
    let misprints = VECTORS.iter().filter(|vector| vector.kind == Kind::Misprint).map(|vector| vector.number);
    let misprints: Vec<u16> = misprints.collect();
    assert!(!misprints.is_empty());
    for (number, line) in read_all() {
        assert!(!misprints.contains(&number) || line.problem.is_some(), "no. {number}: {}", line.text);
    }
}

/// No message is put together from fragments that do not follow each other.
#[test]
fn no_message_is_made_of_a_gap() {
    for (number, line) in read_all() {
        assert_eq!(line.json.get("message"), None, "no. {number}");
    }
}

#[test]
fn an_error_response_names_the_service_that_was_refused() {
    let mut observer = Observer::new();
    assert_eq!(observer.line(0, "454: 01 0E 64 01 01").json.get("requested"), None);
    let refused = observer.line(1, "453: 01 94 16 FF").json;
    assert_eq!((&refused["service"], &refused["requested"]), (&json!(0x14), &json!(0x0E)));
    observer.line(2, "454: 01 0E 01 01 01");
    assert_eq!(observer.line(3, "453: 01 8E 34 12").json.get("requested"), None);
}

/// Every vector with its reading: one monitor for each source.
fn read_all() -> Vec<(u16, Line)> {
    let mut observer = Observer::new();
    let mut source = "";
    let mut lines = Vec::new();
    for vector in VECTORS {
        if vector.source != source {
            source = vector.source;
            observer = Observer::new();
            known_sizes(&mut observer);
        }
        let data = vector.data.iter().map(|byte| format!(" {byte:02X}")).collect::<String>();
        let millis = observer.n;
        lines.push((vector.number, observer.line(millis, &format!("{:03X}:{data}", vector.id))));
    }
    lines
}

/// The sizes that the sources tell beside the frames: no. 12, 56 and 58, 98 to 102.
fn known_sizes(observer: &mut Observer) {
    for (slave, consumed, produced) in
        [(9, Some(10), None), (2, Some(12), Some(13)), (63, Some(32), Some(32))]
    {
        let slave = MacId::new(slave).expect("a MAC ID");
        observer.monitor.set_io_sizes(slave, Predefined::Poll, consumed, produced);
    }
}
