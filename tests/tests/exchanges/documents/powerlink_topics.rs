//! The conformance topics of Ethernet POWERLINK: the transitions as their tables in the core have them, each with its test, and what a
//! managing node needs to start a node.

use std::fmt::Write as _;

use powerlink_core::cycle::{CYCLE_EDGES, CycleEdge, CycleMode, CycleState};
use powerlink_core::nmt::EDGES;

use super::list;

/// The sections of the conformance topics, from their heading on.
pub(super) fn topics() -> String {
    let mut page = format!("{HEADING}\n\n{TOPICS_INTRODUCTION}");
    page.push_str("\n### To be started by a managing node\n\n| Topic | Held by |\n|---|---|\n");
    for (topic, tests) in STARTED {
        writeln!(page, "| {topic} | {} |", list(tests)).unwrap();
    }
    page.push_str("\n### Transitions of NMT\n\n| Topic | Held by |\n|---|---|\n");
    page.push_str(&nmt());
    page.push_str("\n### Transitions of the cycle\n\n| Topic | Held by |\n|---|---|\n");
    for edge in CYCLE_EDGES {
        let CycleEdge { mode, from, event, losses, to } = edge;
        let lost = if losses.is_empty() { String::new() } else { format!("; lost: {losses}") };
        let tests = list(&[cycle_test(*mode, *from, *to, edge)]);
        writeln!(page, "| {mode}: {from}, {event}, to {to}{lost} | {tests} |").unwrap();
    }
    page
}

/// The rows of NMT: a name, a cause and a target each, with all states that it leaves.
fn nmt() -> String {
    let mut rows: Vec<(&str, String, String, Vec<String>)> = Vec::new();
    for edge in EDGES {
        let (cause, to, from) = (edge.cause.to_string(), edge.to.to_string(), edge.from.to_string());
        match rows.iter_mut().find(|row| (row.0, &row.1, &row.2) == (edge.name, &cause, &to)) {
            Some(row) => row.3.push(from),
            None => rows.push((edge.name, cause, to, vec![from])),
        }
    }
    let mut page = String::new();
    for (name, cause, to, from) in rows {
        let (_, tests) = TRANSITIONS.iter().find(|(names, _)| names.contains(&name)).expect("a test of each");
        writeln!(page, "| {name}: {cause}, in {}, to {to} | {} |", from.join(", "), list(tests)).unwrap();
    }
    page
}

fn cycle_test(mode: CycleMode, from: CycleState, to: CycleState, edge: &CycleEdge) -> &'static str {
    use CycleState::{NonCyclic, WaitPreq, WaitSoa, WaitSoc};
    match (mode, from) {
        (CycleMode::Polled, NonCyclic) => {
            "powerlink_core::node::tests::cycle::a_node_outside_of_the_cycle_enters_it_with_a_soc"
        }
        // No frame leads there: a node is stopped in a cycle.
        (CycleMode::Stopped, NonCyclic) => {
            "powerlink_core::cycle::tests::every_edge_is_taken_and_nothing_else_happens"
        }
        (CycleMode::Polled, WaitSoc) if to == WaitSoa => {
            "powerlink_core::node::tests::cycle::polled_waiting_for_soc_as_openpowerlink"
        }
        (CycleMode::Polled, WaitPreq) if edge.losses.is_empty() && to == WaitSoc => {
            "powerlink_core::node::tests::cycle::before_it_is_ready_no_preq_is_due_and_no_time_runs"
        }
        (CycleMode::Polled, WaitSoc) => "powerlink_core::node::tests::cycle::polled_waiting_for_soc",
        (CycleMode::Polled, WaitPreq) => "powerlink_core::node::tests::cycle::polled_waiting_for_preq",
        (CycleMode::Polled, WaitSoa) => "powerlink_core::node::tests::cycle::polled_waiting_for_soa",
        (CycleMode::Stopped, WaitSoc) => "powerlink_core::node::tests::cycle::stopped_waiting_for_soc",
        (CycleMode::Stopped, WaitPreq) => "powerlink_core::node::tests::cycle::stopped_waiting_for_preq",
        (CycleMode::Stopped, WaitSoa) => "powerlink_core::node::tests::cycle::stopped_waiting_for_soa",
    }
}

pub(super) const HEADING: &str = "## Ethernet POWERLINK";

const TOPICS_INTRODUCTION: &str = "Nor is conformance to EPSG DS 301 claimed: only EPSG's test can give that. What follows is written by
`UPDATE_DOCS=1 cargo test -p devicenet-tests --test exchanges`: the transitions are those of the tables in `powerlink-core` (`EDGES`,
`CYCLE_EDGES`), of which the debug builds check each step, and `nmt::tests` and `cycle::tests` that each is taken and no other. The tests
named here say what a node does by each, on the wire and in its objects.
";

/// What a managing node of openPOWERLINK 2.7.2 checks before it starts a node.
const STARTED: &[(&str, &[&str])] = &[
    (
        "IdentResponse of 176 bytes, in every state from `PreOperational1` on, `Stopped` too",
        &["powerlink_core::node::tests::started::an_ident_response_has_176_bytes_in_every_state"],
    ),
    (
        "StatusResponse of 72 bytes or more, up to 13 errors, with the right EC",
        &[
            "powerlink_core::node::tests::started::a_status_response_has_72_bytes_in_every_state_and_ec_follows_er",
            "powerlink_core::node::tests::started::a_status_response_with_all_the_errors_that_it_can_tell",
        ],
    ),
    (
        "An SDO server over ASnd: 0x1006 is written in any case",
        &[
            "powerlink_core::node::tests::started::the_cycle_length_is_written_in_every_state",
            "powerlink_core::node::tests::objects::an_object_of_the_application_is_written_in_every_state",
        ],
    ),
    (
        "RS and PR in PRes, StatusResponse and IdentResponse; one frame for an invitation",
        &[
            "powerlink_core::node::tests::started::what_waits_is_told_and_one_frame_goes_out_when_invited",
            "powerlink_core::node::tests::started::a_pres_asks_for_the_slot",
            "powerlink_core::node::tests::started::without_a_pres_the_responses_ask_for_the_slot",
            "powerlink_core::node::tests::started::requests_are_counted",
            "powerlink_core::node::tests::started::seven_frames_are_seven_or_more",
        ],
    ),
    (
        "PRes to a PReq in three states; in time: `scripts/instructions` has a budget for it",
        &["powerlink_core::node::tests::started::a_poll_is_answered_in_three_states"],
    ),
    (
        "NMT commands to the node and to all, in every state, plain and with a list of nodes",
        &[
            "powerlink_core::node::tests::started::commands_are_followed_from_unicast_and_broadcast",
            "powerlink_core::node::tests::commands::every_command_in_every_state",
        ],
    ),
    (
        "Frames that nobody padded",
        &[
            "powerlink_core::node::tests::started::unpadded_frames_are_accepted",
            "tests::powerlink::faults::unpadded_frames_are_as_good_as_padded_ones",
        ],
    ),
    (
        "All of it: a recorded managing node of openPOWERLINK brings the node to `Operational`",
        &["tests::powerlink::boot::our_node_in_the_place_of_theirs_becomes_operational"],
    ),
];

/// The tests of each transition of NMT.
const TRANSITIONS: &[(&[&str], &[&str])] = &[
    (&["GT1"], &["powerlink_core::node::tests::resets::gt1_power_on"]),
    (&["GT2"], &["powerlink_core::node::tests::resets::gt2_local_reset"]),
    (&["GT3"], &["powerlink_core::node::tests::resets::gt3_switch_off"]),
    (
        &["GT4"],
        &[
            "powerlink_core::node::tests::resets::gt4_reset_node",
            "powerlink_core::node::tests::commands::a_reset_may_come_during_the_initialisation",
        ],
    ),
    (
        &["GT5"],
        &[
            "powerlink_core::node::tests::resets::gt5_reset_communication",
            "powerlink_core::node::tests::commands::a_reset_may_come_during_the_initialisation",
        ],
    ),
    (
        &["GT6"],
        &[
            "powerlink_core::node::tests::resets::gt6_internal_communication_error",
            "powerlink_core::nmt::tests::every_edge_is_taken_and_every_state_reached",
        ],
    ),
    (&["GT7"], &["powerlink_core::node::tests::resets::gt7_reset_configuration"]),
    (
        &["GT8"],
        &[
            "powerlink_core::node::tests::resets::gt8_software_reset",
            "powerlink_core::node::tests::commands::a_reset_may_come_during_the_initialisation",
        ],
    ),
    (
        &["GT10", "GT11", "GT12"],
        &["powerlink_core::node::tests::resets::gt10_gt11_gt12_ct1_the_initialisation_goes_on_by_itself"],
    ),
    (
        &["CT1"],
        &[
            "powerlink_core::node::tests::resets::gt10_gt11_gt12_ct1_the_initialisation_goes_on_by_itself",
            "powerlink_core::node::tests::transitions::ct1_takes_the_configuration_over_and_waits_for_the_network",
        ],
    ),
    (&["CT2"], &["powerlink_core::node::tests::transitions::ct2_soa_soc_or_by_choice_a_poll"]),
    (&["CT3"], &["powerlink_core::node::tests::transitions::ct3_basic_ethernet_timeout"]),
    (&["CT4"], &["powerlink_core::node::tests::transitions::ct4_soc"]),
    (
        &["CT5", "CT6"],
        &[
            "powerlink_core::node::tests::transitions::ct5_ct6_ready_to_operate_needs_the_command_and_the_application",
        ],
    ),
    (&["CT7"], &["powerlink_core::node::tests::transitions::ct7_start_node"]),
    (&["CT8"], &["powerlink_core::node::tests::transitions::ct8_stop_node"]),
    (&["CT9", "CT10"], &["powerlink_core::node::tests::transitions::ct9_ct10_enter_pre_operational_2"]),
    (&["CT11"], &["powerlink_core::node::tests::transitions::ct11_cycle_error"]),
    (&["CT12"], &["powerlink_core::node::tests::transitions::ct12_any_frame_of_the_network"]),
];
