//! The fault matrix is made of the exchanges and of tests by name; the tables of conformance topics name tests, and those of Ethernet
//! POWERLINK are made of the transitions in the core. All must be true, and none may drift.
//!
//! ```sh
//! UPDATE_DOCS=1 cargo test -p devicenet-tests --test exchanges
//! ```

mod powerlink_faults;
mod powerlink_topics;

use std::collections::BTreeSet;
use std::env;

use devicenet_tests::{read, workspace_root};

use crate::script;

#[test]
fn the_fault_matrix_is_up_to_date() {
    let mut page = INTRODUCTION.to_owned();
    page.push_str("\n## A slave\n\n| Fault | What must hold | Exchange |\n|---|---|---|\n");
    for exchange in script::all() {
        if let Some(words) = &exchange.fault {
            exchange.play();
            let (file, name) = (&exchange.file, &exchange.name);
            page.push_str(&format!("| {name} | {words} | [{file}](../tests/exchanges/{file}) |\n"));
        }
    }
    page.push_str(
        "\n## Client, master, tool and network access\n\n| Fault | What must hold | Test |\n|---|---|---|\n",
    );
    for (fault, words, test) in OTHERS {
        page.push_str(&format!("| {fault} | {words} | {} |\n", list(&[test])));
    }
    page.push_str(&powerlink_faults::faults());
    is_up_to_date("docs/fault-matrix.md", &page);
}

/// Those of DeviceNet are written by hand, those of Ethernet POWERLINK follow them.
#[test]
fn the_conformance_topics_of_powerlink_are_up_to_date() {
    let page = read("docs/conformance.md");
    let by_hand = page.split(powerlink_topics::HEADING).next().unwrap_or_default();
    is_up_to_date(
        "docs/conformance.md",
        &format!("{}\n\n{}", by_hand.trim_end(), powerlink_topics::topics()),
    );
}

#[track_caller]
fn is_up_to_date(path: &str, page: &str) {
    if env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(workspace_root().join(path), page).expect("it can be written");
    }
    assert!(read(path) == page, "{path} is stale: run this test with UPDATE_DOCS=1");
}

/// Every fault that must be there.
#[test]
fn no_fault_is_forgotten() {
    let page = read("docs/fault-matrix.md");
    for fault in FAULTS {
        assert!(page.contains(&format!("| {fault} |")), "{fault}");
    }
}

#[test]
fn conformance_topics_name_tests_and_exchanges_that_exist() {
    let exchanges: BTreeSet<String> = script::all().map(|exchange| exchange.name).collect();
    let page = read("docs/conformance.md");
    let mut topics = 0;
    for row in page.lines().filter(|line| line.starts_with("| ") && !line.ends_with("| Held by |")) {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let [topic, places] = cells[..] else { panic!("not a row of two cells: {row}") };
        topics += 1;
        // A name may have a comma, and a quotation mark ends it.
        let places = places.replace("\", ", "\"\n").replace("`, ", "`\n");
        let names: Vec<&str> = places.lines().collect();
        assert!(names.iter().any(|name| !name.is_empty()), "{topic}: no test");
        for name in names {
            match (name.strip_prefix('`'), name.strip_prefix('"')) {
                (Some(test), _) => assert!(exists(test.trim_end_matches('`')), "{topic}: no test {name}"),
                (_, Some(exchange)) => {
                    assert!(
                        exchanges.contains(exchange.trim_end_matches('"')),
                        "{topic}: no exchange {name}"
                    );
                }
                _ => assert!(name.starts_with("not "), "{topic}: {name} is neither a test nor an exchange"),
            }
        }
    }
    assert!(topics >= TOPICS, "{topics} topics");
    assert!(page.contains("No conformance is claimed"));
}

/// Names of tests that exist, as a cell.
fn list(tests: &[&str]) -> String {
    for test in tests {
        assert!(exists(test), "there is no test {test}");
    }
    tests.iter().map(|test| format!("`{test}`")).collect::<Vec<_>>().join(", ")
}

/// A test by its path: the package, then the modules, then the function.
fn exists(test: &str) -> bool {
    let mut parts: Vec<&str> = test.split("::").collect();
    let (Some(function), root) = (parts.pop(), parts.remove(0)) else { return false };
    let root = match root {
        "link_core" => "link-core/src",
        "cip_core" => "cip-core/src",
        "devicenet_core" => "devicenet-core/src",
        "powerlink_core" => "powerlink-core/src",
        "tests" => "tests/tests",
        "cli" => "cli/tests",
        _ => return false,
    };
    let path = format!("{root}/{}", parts.join("/"));
    [format!("{path}.rs"), format!("{path}/mod.rs"), format!("{path}/main.rs")].iter().any(|file| {
        let text = std::fs::read_to_string(workspace_root().join(file)).unwrap_or_default();
        let written = text.split("#[test]").skip(1).any(|after| {
            let name = after.split("fn ").nth(1).and_then(|rest| rest.split('(').next());
            name == Some(function)
        });
        // The scenarios with a trace are tests that a macro makes.
        let mut made = text.split("trace!(").skip(1);
        written || made.any(|after| after.trim_start().split(',').next() == Some(function))
    })
}

const INTRODUCTION: &str = "# Fault matrix

What goes wrong on a network, and what must hold then. Each row is a test: this page is written by it
(`UPDATE_DOCS=1 cargo test -p devicenet-tests --test exchanges`), and a test fails when the page is stale.
The exchanges were written by hand from the tables of CIP Vol. 3, frame by frame; a frame that is not in them fails the test too.
They are played on the simulated bus, and their traces, with the times of the bus, are the snapshots beside the test. What is named
of Ethernet POWERLINK are tests of one node against frames by hand, and of networks on the simulated segment.
";

/// Faults that are not those of one slave alone.
const OTHERS: &[(&str, &str, &str)] = &[
    (
        "Stale transaction ID in a response",
        "It is no answer: the client waits on, and asks again",
        "devicenet_core::client::tests::what_is_not_the_answer_is_ignored",
    ),
    (
        "A response is lost",
        "The client asks again, with the same transaction ID",
        "devicenet_core::client::tests::a_lost_response_is_asked_for_again_with_the_same_transaction_id",
    ),
    (
        "Too much data, either way",
        "Both ends say so, and the client has a typed outcome",
        "devicenet_core::client::tests::too_much_data_either_way",
    ),
    (
        "A master after its restart",
        "It releases what it left behind, and allocates anew",
        "devicenet_core::master::tests::bring_up::connections_of_an_earlier_life_are_released",
    ),
    (
        "A slave of another master",
        "It is left alone, and tried again later",
        "devicenet_core::master::tests::bring_up::a_slave_of_another_master_is_left_alone",
    ),
    (
        "A slave falls silent",
        "Status 72 after four times the packet rate, then it is brought up again",
        "devicenet_core::master::tests::io::a_slave_that_falls_silent_is_lost_and_contacted_again",
    ),
    (
        "A slave sends wrong lengths",
        "Status 85, and its watchdog is not fed",
        "devicenet_core::master::tests::io::wrong_lengths_do_not_feed_the_watchdog",
    ),
    (
        "Two tools claim the offline set at once",
        "One of them owns it",
        "devicenet_core::tool::tests::sequence::of_two_that_claim_at_once_the_first_on_the_bus_wins",
    ),
    (
        "The owner of an offline recovery dies",
        "The other tool, which gave way to it, owns the set when it asks again, and recovers the node",
        "tests::scenarios::exchange::the_owner_of_an_offline_recovery_dies",
    ),
    (
        "A MAC ID that the tool would give away is taken",
        "It is told",
        "devicenet_core::tool::tests::sequence::a_mac_id_that_is_taken",
    ),
    (
        "Two nodes with one MAC ID start at any distance",
        "Never are both on line",
        "tests::devicenet::access::twins_never_both_get_on_line",
    ),
    (
        "Segments with one MAC ID are joined",
        "The first defence silences one of the two",
        "tests::devicenet::access::joined_segments_with_the_same_mac_id_fault_one_of_the_two",
    ),
    (
        "Bus-off",
        "With bus-off interrupt 1 the node comes back after the back-off and checks again; with 0 it stays away",
        "devicenet_core::access::tests::bus_off::with_boi_the_controller_is_restarted_after_the_back_off_and_the_check_begins_anew",
    ),
];

const FAULTS: &[&str] = &[
    "The first fragment is missing",
    "A gap",
    "A middle fragment is repeated",
    "The count wraps at 64",
    "The last fragment before the first",
    "Two peers interleaved",
    "Begun anew",
    "An acknowledge is lost",
    "The acknowledge of the last fragment is lost",
    "A wrong acknowledge",
    "The client has too little room",
    "Single fragment",
    "A body that is a multiple of 6",
    "A body that is a multiple of 7",
    "I/O: a message that is a multiple of 7",
    "No byte in all",
    "At the limit",
    "One byte above the limit",
    "Never finished",
    "A second master",
    "Release of what is not allocated",
    "Nothing chosen",
    "I/O without an explicit connection",
    "A packet rate of 0",
    "At the edge by one bit",
    "Watchdog action 0: timed out",
    "Watchdog action 1: auto delete",
    "Watchdog action 2: auto reset",
    "Watchdog action 3: deferred delete",
    "Change of state and cyclic at once",
    "Bit-strobe for a node that is not there",
    "Table of connections full",
    "A stale transaction ID",
    "A clock that steps back",
    "Called seconds late",
    "Two deadlines in one tick",
    "The controller takes nothing",
    "Own frames are echoed",
    "A spoofed master",
    "A replayed offline command",
    "A flood of opens",
    "Two clients interleaved",
    "A client falls silent",
    "Two masters ask in the same bit",
    "A spoofed command",
    "A first fragment that is not 0",
    "A response that is a multiple of 6",
    "A response at the limit",
    "I/O: the first fragment is missing",
    "I/O: a gap and a repetition",
    "I/O: single fragment",
    "I/O: no byte in all",
    "I/O: never finished",
    "I/O: at the limit",
    "I/O: one fragment above the limit",
    "I/O: too long",
    "Alone on the bus",
    "Two nodes check in the same bit",
    "A check of a wrong length",
    "A duplicate takes everything",
];

/// How many topics and rows of error tables there are at least.
const TOPICS: usize = 160;
