//! Ethernet POWERLINK as another program reads it.

use std::process::Command;

use powerlink_core::wire::{NmtStateCode, RequestedService};
use serde_json::Value;

use super::powerlink::{BOOT, boot};
use super::{capture, json_lines, stdout, tshark};

/// Message type, nodes, services, targets, states, sizes, flags of each frame.
#[test]
fn tshark_agrees() {
    if !tshark::is_here("tshark_agrees") {
        return;
    }
    let fields = [
        "epl.mtyp",
        "epl.src",
        "epl.dest",
        "epl.asnd.svid",
        "epl.soa.svid",
        "epl.soa.svtg",
        "epl.soa.stat",
        "epl.pres.stat",
        "epl.asnd.ires.state",
        "epl.asnd.sres.stat",
        "epl.preq.size",
        "epl.pres.size",
        "epl.pres.rd",
        "epl.soa.er",
        "epl.asnd.sres.ec",
    ];
    let selected = fields.iter().flat_map(|field| ["-e", field]);
    let tshark = Command::new("tshark")
        .args(["-n", "-T", "fields", "-E", "separator=,"])
        .args(selected)
        .args(["-r", &capture(BOOT)])
        .output()
        .unwrap();
    // Numbers come in decimal, in hexadecimal, as True and False.
    let theirs: Vec<Vec<Option<u64>>> =
        stdout(&tshark).lines().map(|line| line.split(',').map(number).collect()).collect();
    let ours: Vec<Vec<Option<u64>>> = json_lines(&boot(&["--json"])).iter().map(numbers).collect();
    assert_eq!(theirs.len(), 640);
    for ((theirs, ours), n) in theirs.iter().zip(&ours).zip(1..) {
        assert_eq!(theirs, ours, "frame {n}");
    }
}

fn number(text: &str) -> Option<u64> {
    match (text, text.strip_prefix("0x")) {
        ("True", _) => Some(1),
        ("False", _) => Some(0),
        (_, Some(digits)) => Some(u64::from_str_radix(digits, 16).unwrap()),
        ("", _) => None,
        _ => Some(text.parse().unwrap()),
    }
}

/// What tshark's fields are in an object of ours.
fn numbers(object: &Value) -> Vec<Option<u64>> {
    let kind = object["kind"].as_str().unwrap();
    let (message_type, service) = match kind {
        "soc" => (1, None),
        "preq" => (3, None),
        "pres" => (4, None),
        "soa" => (5, None),
        "asnd_ident_response" => (6, Some(1)),
        "asnd_status_response" => (6, Some(2)),
        "asnd_nmt_command" => (6, Some(4)),
        "asnd_sdo" => (6, Some(5)),
        other => panic!("{other}"),
    };
    let of = |which: &str, value: Option<u64>| value.filter(|_| kind == which);
    let named = |codes: Vec<(String, u64)>, name: &Value| {
        codes.into_iter().find(|(known, _)| name == known.as_str()).map(|(_, code)| code)
    };
    let services = RequestedService::NAMED.iter().map(|code| (code.to_string(), code.0.into())).collect();
    let states = NmtStateCode::NAMED.iter().map(|code| (code.to_string(), code.0.into())).collect();
    let state = named(states, &object["nmt_state"]);
    let has =
        |flag: &str| object["flags"].as_array().map(|flags| u64::from(flags.iter().any(|name| name == flag)));
    let size = object["value"].as_str().and_then(|value| u64::try_from(value.len() / 2).ok());
    vec![
        Some(message_type),
        object["src"].as_u64(),
        object["dst"].as_u64(),
        service,
        of("soa", named(services, &object["requested_service"])),
        of("soa", Some(object["target"].as_u64().unwrap_or(0))),
        of("soa", state),
        of("pres", state),
        of("asnd_ident_response", state),
        of("asnd_status_response", state),
        of("preq", size),
        of("pres", size),
        of("pres", has("RD")),
        of("soa", has("ER")),
        of("asnd_status_response", has("EC")),
    ]
}
