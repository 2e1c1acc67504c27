//! `docs/json.md` names every field that the commands print, and no other.

use std::collections::BTreeSet;

use serde_json::Value;

use crate::{devicenet, record::file};

/// The fields of a section: what stands in backticks in the first column of its tables; of a table of events, in the others, as far as it
/// is a field, and what follows the tables.
fn documented(section: &str) -> BTreeSet<String> {
    let text = include_str!("../../../docs/json.md");
    let (_, section) = text.split_once(&format!("\n{section}\n")).unwrap();
    let end = ["\n## ", "\n### "].iter().filter_map(|heading| section.find(heading)).min();
    let mut fields = BTreeSet::new();
    let mut is_event = false;
    for line in section[..end.unwrap_or(section.len())].lines() {
        let mut columns = line.strip_prefix('|').unwrap_or_default().split('|');
        let first = columns.next().unwrap_or_default();
        if line.starts_with("| `event` | when |") {
            is_event = true;
            fields.insert("event".to_owned());
        } else if is_event && line.starts_with('|') {
            // Values are behind a colon, remarks in brackets.
            let further = columns.nth(1).unwrap_or_default();
            fields.extend(further.split(';').flat_map(|part| names(part.split(':').next().unwrap())));
        } else if line.starts_with("All have") {
            fields.extend(names(line).filter(|name| name != "summary"));
        } else if !line.starts_with('|') {
            is_event = false;
        } else {
            fields.extend(names(first));
        }
    }
    // The heading of the table of a summary.
    fields.remove("summary");
    fields
}

fn names(text: &str) -> impl Iterator<Item = String> {
    text.split('`').skip(1).step_by(2).map(str::to_owned)
}

/// The fields of objects, those within others with a dot.
fn printed(objects: &[Value]) -> BTreeSet<String> {
    fn walk(path: &str, value: &Value, fields: &mut BTreeSet<String>) {
        match value {
            Value::Object(object) => {
                for (key, value) in object {
                    let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                    walk(&path, value, fields);
                    fields.insert(path);
                }
            }
            Value::Array(list) => list.iter().for_each(|value| walk(path, value, fields)),
            _ => {}
        }
    }
    let mut fields = BTreeSet::new();
    objects.iter().for_each(|object| walk("", object, &mut fields));
    fields
}

/// What several commands print is documented, and what is documented is printed by one of them, but for what few buses have.
#[track_caller]
fn agree(sections: &[&str], runs: &[&[&str]], rare: &[&str], other_form: impl Fn(String) -> Option<String>) {
    let documented: BTreeSet<String> = sections.iter().flat_map(|section| documented(section)).collect();
    let objects: Vec<Value> = runs.iter().flat_map(|arguments| devicenet(arguments).json()).collect();
    let printed: BTreeSet<String> = printed(&objects).into_iter().filter_map(other_form).collect();
    let undocumented: Vec<_> = printed.difference(&documented).collect();
    assert!(undocumented.is_empty(), "{sections:?} say nothing of {undocumented:?}");
    let missing: Vec<_> =
        documented.difference(&printed).filter(|field| !rare.contains(&field.as_str())).collect();
    assert!(missing.is_empty(), "{sections:?} tell of {missing:?}, which nothing prints");
}

const CAPTURE: &str = "../../../tests/captures/slave-01-startup-poll.log";

#[test]
fn of_decode() {
    let captures = ["slave-01-startup-poll", "slave-04-fragmented-response", "session-two-slaves-on-vcan"];
    let captures = captures.map(|name| format!("../../../tests/captures/{name}.log"));
    let problems = file("field-problems.log");
    // A service that is not supported, on an explicit connection that was not allocated; a response to nothing.
    let log = "(1.0) can0 454#014B050201\n(1.1) can0 453#019408FF\n(1.2) can0 45F#00341245230000\n(1.3) can0 457#80341245230000\n";
    std::fs::write(&problems, log).unwrap();
    let files = captures.iter().map(String::as_str).chain([
        "../../../tests/captures/candump-L-mixed.log",
        problems.to_str().unwrap(),
        "../decode/nex.log",
    ]);
    let runs: Vec<[&str; 3]> = files.map(|file| ["decode", "--json", file]).collect();
    let runs: Vec<&[&str]> = runs.iter().map(<[_; 3]>::as_slice).collect();
    let rare = ["eds", "eds.file", "eds.values", "eds.text", "requested"];
    agree(&["## decode"], &runs, &rare, |field| match field.strip_prefix("message.") {
        Some("kind" | "data") | None => Some(field),
        Some(within) => Some(within.to_owned()),
    });
}

const POWERLINK: &str = "../../../tests/captures/powerlink/boot.pcap";

#[test]
fn of_decode_of_powerlink() {
    let runs: [&[&str]; 1] = [&["decode", "--json", POWERLINK]];
    // The capture has no problem, no tag, no other protocol, and every transfer in one part.
    let rare = [
        "captured",
        "channel",
        "vlan",
        "ethertype",
        "reason",
        "nodes",
        "note",
        "problem",
        "problem_code",
        "sdo.part",
        "sdo.total",
        "message",
        "message_type",
        "asnd_service",
    ];
    agree(&["### decode of Ethernet POWERLINK"], &runs, &rare, Some);
}

#[test]
fn of_a_summary_of_powerlink() {
    let two_senders = file("two-senders.pcap");
    let bytes =
        std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/captures/powerlink/boot.pcap")).unwrap();
    // The first frame twice, a SoA of the managing node: the second time from node 7.
    let mut foreign = bytes[24..24 + 16 + 54].to_vec();
    foreign[16 + 16] = 7;
    // NMTResetNode to node 1, with a reason.
    let reset = [
        &[0; 8][..],
        &[26, 0, 0, 0, 26, 0, 0, 0],
        &[0x01, 0x11, 0x1E, 0, 0, 4, 2, 0, 0, 0, 0, 0xF0, 0x88, 0xAB],
        &[6, 1, 240, 4, 0x28, 0, 0x43, 0x82, 0, 0, 0, 0],
    ]
    .concat();
    std::fs::write(&two_senders, [&bytes[..24 + 16 + 54], &foreign, &reset].concat()).unwrap();
    let runs: [&[&str]; 2] = [
        &["decode", "--summary", "--json", POWERLINK],
        &["decode", "--summary", "--json", two_senders.to_str().unwrap()],
    ];
    let known = |field: String| {
        let is_kind = field.starts_with("kinds.");
        let is_identity = field.starts_with("identity.");
        (field != "summary" && !is_kind && !is_identity).then_some(field)
    };
    let rare = ["states_forgotten", "sdo_given_up", "sdo_not_stored", "clock_back"];
    agree(&["### decode --summary of Ethernet POWERLINK"], &runs, &rare, known);
}

#[test]
fn of_a_summary() {
    let scenario = file("summed-up.log");
    let simulated = devicenet(&["simulate", "drop.toml", "--record", scenario.to_str().unwrap()]);
    assert_eq!(simulated.code(), 0, "{}", simulated.err());
    let runs: [&[&str]; 2] = [
        &["decode", "--summary", "--json", "../../../tests/captures/candump-L-mixed.log"],
        &["decode", "--summary", "--json", scenario.to_str().unwrap()],
    ];
    let rare =
        ["product", "product_name", "client", "first_cause", "scanner_status", "facts", "until", "mac"];
    let sections = ["## decode --summary", "### finding"];
    agree(&sections, &runs, &rare, |field| {
        (!field.starts_with("facts.") && field != "summary").then_some(field)
    });
}

/// Without what frames have beside it, and what is counted of slaves: these are fields of the library.
#[test]
fn of_simulate() {
    let nex = "../../../tests/scenarios/devicenex/worked-example.toml";
    let failing = file("field-failing.toml");
    let alone = "[bus]\nbit_rate = 500000\nduration = \"10ms\"\n[[node]]\nname = \"ear\"\nrole = \"listener\"\n\
                 [[expect]]\nnode = \"ear\"\nby = \"5ms\"\nevent = \"bus_off\"\n";
    std::fs::write(&failing, alone).unwrap();
    let runs: [&[&str]; 4] = [
        &["simulate", "--json", "../../scenarios/plant.toml"],
        &["simulate", "--json", "drop.toml"],
        &["simulate", "--json", nex],
        &["simulate", "--json", failing.to_str().unwrap()],
    ];
    let documented: BTreeSet<String> = documented("## simulate");
    let mut printed_fields = BTreeSet::new();
    for run in runs {
        let objects = devicenet(run).json();
        let of_frame = |object: &&Value| object["event"] == "frame";
        printed_fields.extend(printed(&objects.iter().filter(|o| !of_frame(o)).cloned().collect::<Vec<_>>()));
    }
    let is_counted = |field: &str| {
        field.starts_with("nodes.slave.")
            || field
                .strip_prefix("nodes.scan.slaves.")
                .is_some_and(|rest| !["mac", "state", "status"].contains(&rest))
    };
    let undocumented: Vec<_> = printed_fields
        .difference(&documented)
        .filter(|field| !is_counted(field) && !["bus", "nodes"].contains(&field.as_str()))
        .collect();
    assert!(undocumented.is_empty(), "docs/json.md says nothing of {undocumented:?}");
    for field in ["device", "nodes.oa", "nodes.received", "held", "found", "by"] {
        assert!(documented.contains(field) && printed_fields.contains(field), "{field}");
    }
}

#[test]
fn of_compare() {
    agree(&["## compare"], &[&["compare", "--devices", "3", "--json"]], &[], |field| {
        (field != "measures").then_some(field)
    });
}

#[test]
fn of_monitor() {
    let errors = file("field-errors.log");
    let log =
        "(1.0) can0 40A#00\n(1.2) can0 20000204#0010000000008005\n(1.3) can0 20000004#0001000000000000\n";
    std::fs::write(&errors, log).unwrap();
    let errors = format!("log:{}", errors.display());
    let plant = "sim:../../scenarios/plant.toml";
    let runs: [&[&str]; 3] = [
        &["monitor", "sim:drop.toml", "--json"],
        &["monitor", plant, "--json"],
        &["monitor", &errors, "--json"],
    ];
    let rare = ["nodes.revision", "nodes.product_name"];
    agree(&["## monitor", "### finding"], &runs, &rare, |field| {
        let field = field.strip_prefix("findings.").map_or(field.clone(), str::to_owned);
        let field = field.replace("load_total.", "load.").replace("nodes.explicit.", "nodes.io.");
        let is_container = ["nodes", "nodes.connections"].contains(&field.as_str());
        (!field.starts_with("facts.") && !is_container).then_some(field)
    });
}

#[test]
fn of_scan() {
    let runs: [&[&str]; 3] = [
        &["scan", "sim:owned.toml", "--listen", "6s", "--json"],
        &["scan", "sim:two.toml", "--listen", "3s", "--json"],
        &["scan", &format!("log:{CAPTURE}"), "--json"],
    ];
    agree(&["## scan"], &runs, &["problem"], Some);
}

#[test]
fn of_get_and_set() {
    let two =
        |more: &[&'static str]| [&["get", "sim:two.toml"], more, &["--listen", "3s", "--json"]].concat();
    let set = ["set", "sim:two.toml", "11", "3/1/3", "1", "--listen", "3s", "--json"];
    let runs = [
        two(&["10", "1/1/7"]),
        two(&["10", "0x64/1/3"]),
        two(&["13", "1/1/1"]),
        set.to_vec(),
        ["get", "sim:owned.toml", "10", "1/1/1", "--listen", "6s", "--json"].to_vec(),
    ];
    let runs: Vec<&[&str]> = runs.iter().map(Vec::as_slice).collect();
    agree(&["## get and set"], &runs, &["additional"], Some);
}

#[test]
fn of_recover() {
    let run =
        |more: &[&'static str]| [&["recover", "sim:twins.toml", "--listen", "6s", "--json"], more].concat();
    let runs = [
        run(&["--assign-free"]),
        run(&["--assign", "1:1=9"]),
        run(&["--identify", "0x1234:0x2347", "--identify", "1:1"]),
    ];
    let runs: Vec<&[&str]> = runs.iter().map(Vec::as_slice).collect();
    agree(&["## recover"], &runs, &[], Some);
}

#[test]
fn of_record() {
    let path = file("fields.log");
    let run: &[&str] = &["record", "sim:drop.toml", "--json", "--output", path.to_str().unwrap()];
    agree(&["## record"], &[run], &["state"], Some);
}

#[test]
fn of_slave_and_master() {
    let runs: [&[&str]; 4] = [
        &["master", "sim:two.toml", "line.toml", "--for", "20s", "--json"],
        &["master", "sim:two.toml", "owned.toml", "--for", "20s", "--json"],
        &["slave", "sim:owned.toml", "line.toml", "--node", "switch", "--for", "20s", "--json"],
        &["slave", "sim:fields.toml", "line.toml", "--node", "valve", "--for", "20s", "--json"],
    ];
    agree(&["## slave and master"], &runs, &[], Some);
}
