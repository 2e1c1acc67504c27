//! The fault matrix of Ethernet POWERLINK: what goes wrong around a node and on a segment.

use super::list;

/// The rows of the fault matrix.
pub(super) fn faults() -> String {
    let mut page = "\n## Ethernet POWERLINK\n\n| Fault | What must hold | Test |\n|---|---|---|\n".to_owned();
    for (fault, words, tests) in FAULTS {
        page.push_str(&format!("| {fault} | {words} | {} |\n", list(tests)));
    }
    page
}

/// A fault, what must hold, and its tests.
const FAULTS: &[(&str, &str, &[&str])] = &[
    (
        "SoC, PReq or SoA is lost, at and around each threshold",
        "Each adds 8, a good cycle takes 1 away; at the threshold an error entry and `PreOperational1`, below it nothing but the count",
        &[
            "powerlink_core::node::tests::losses::symptoms_in_a_row_around_each_threshold",
            "powerlink_core::node::tests::losses::good_cycles_between_two_symptoms",
            "powerlink_core::node::tests::errors::lost_socs",
            "powerlink_core::node::tests::errors::lost_preqs",
            "powerlink_core::node::tests::errors::lost_soas_count_and_may_lead_to_a_reaction",
        ],
    ),
    (
        "One loss is noticed several times",
        "By order and by time a lost SoC counts once, a lost SoA too",
        &[
            "powerlink_core::cycle::tests::a_lost_soc_counts_once_however_it_is_noticed",
            "powerlink_core::cycle::tests::a_lost_soa_counts_once_however_it_is_noticed",
        ],
    ),
    (
        "SoC, PReq, SoA or PRes is lost in a network",
        "One, and one in ten cycles for ever, change nothing; of two in a row the managing node learns, and both run again",
        &[
            "tests::powerlink::losses::single_losses_change_nothing",
            "tests::powerlink::losses::two_losses_in_a_row_are_a_cycle_error",
            "tests::powerlink::losses::the_memory_of_a_loss_is_as_long_as_the_rule_says",
        ],
    ),
    (
        "Silence",
        "`PreOperational1` two cycles after the last SoC; in `PreOperational2` it waits, as the cycle length may be unknown",
        &["powerlink_core::node::tests::errors::silence"],
    ),
    (
        "There is no managing node",
        "`BasicEthernet` after 0x1F99, where clients are answered uninvited; any frame of the network ends it",
        &[
            "powerlink_core::node::tests::boot::without_a_managing_node_it_settles_for_basic_ethernet",
            "powerlink_core::node::tests::boot::any_frame_of_the_network_ends_basic_ethernet",
            "powerlink_core::node::tests::objects::without_a_managing_node_clients_are_answered_at_once",
            "tests::powerlink::faults::without_a_managing_node_a_node_settles_for_plain_ethernet_until_one_comes",
        ],
    ),
    (
        "A cable is cut",
        "The node leaves operation by its own supervision, the others go on, and it comes back; less than a cycle is forgiven",
        &[
            "tests::powerlink::faults::a_node_whose_cable_was_cut_comes_back_and_the_others_go_on",
            "tests::powerlink::faults::a_short_interruption_is_no_loss",
            "tests::powerlink::faults::a_node_that_is_not_polled_forgives_one_short_interruption",
        ],
    ),
    (
        "The managing node is killed, and restarted",
        "Everybody waits in `PreOperational1`, is reset by the new one, and runs",
        &[
            "tests::powerlink::faults::without_a_managing_node_everybody_waits_and_with_a_new_one_everybody_starts",
            "tests::powerlink::faults::a_managing_node_that_begins_anew_at_once_resets_everybody",
        ],
    ),
    (
        "A node is switched off and on",
        "EC tells the managing node, and it is started again",
        &["tests::powerlink::faults::a_node_that_was_switched_off_and_on_comes_back"],
    ),
    (
        "A node is another one than planned, or refuses its configuration",
        "It is not started, is told, and tried again",
        &[
            "tests::powerlink::faults::a_node_that_is_not_the_one_of_the_plan_is_refused_and_tried_again",
            "tests::powerlink::faults::a_node_that_refuses_its_configuration_is_not_started",
        ],
    ),
    (
        "SDO commands that cannot be carried out",
        "Each abort code, in the bytes of its answer; the connection goes on",
        &[
            "powerlink_core::node::tests::aborts::every_abort_in_the_bytes_of_its_answer",
            "powerlink_core::node::tests::aborts::aborts_of_a_mapping",
            "powerlink_core::node::tests::aborts::aborts_of_a_segmented_write",
            "powerlink_core::node::tests::aborts::a_value_that_is_too_long_to_read",
        ],
    ),
    (
        "SDO frames are lost, or come in another order",
        "None is carried out before its turn; what is missing is asked for (rcon 3), whatever the distance of its number",
        &[
            "powerlink_core::node::tests::sequence::lost_and_out_of_order",
            "powerlink_core::node::tests::sequence::every_distance_of_a_number",
            "powerlink_core::node::tests::sequence::a_lost_answer_to_the_opening",
        ],
    ),
    (
        "SDO frames come twice",
        "Carried out once, acknowledged if that is asked for, answered again if that is",
        &["powerlink_core::node::tests::sequence::duplicates"],
    ),
    (
        "SDO frames of a connection that is elsewhere",
        "Every pair of rcon and scon, closed, opening and open: carried out in an open connection only",
        &["powerlink_core::node::tests::sequence::connections_that_are_elsewhere"],
    ),
    (
        "An SDO client falls silent, or acknowledges nothing",
        "The answer is sent twice more, then the client is forgotten, within the time of 0x1300",
        &[
            "powerlink_core::node::tests::sequence::a_silent_client_is_forgotten",
            "powerlink_core::node::tests::objects::a_client_that_falls_silent_is_asked_twice_and_forgotten",
            "powerlink_core::node::tests::clients::a_client_that_acknowledges_nothing_is_given_up_however_much_it_says",
        ],
    ),
    (
        "A third SDO client",
        "Refused with an event; the two have their turns",
        &["powerlink_core::sdo::tests::clients_take_turns_and_a_third_is_refused"],
    ),
    (
        "Frames that are too short",
        "Dropped, counted, told; the state stays",
        &[
            "powerlink_core::node::tests::bytes::cut_frames_are_dropped",
            "powerlink_core::node::tests::errors::a_frame_that_is_cut_is_dropped",
        ],
    ),
    (
        "Frames that are too long",
        "What follows the message is padding, up to any length",
        &["powerlink_core::node::tests::faults::frames_that_are_too_long"],
    ),
    (
        "A PReq longer than its limit or than its frame",
        "It is answered, then the communication is reset (GT6)",
        &[
            "powerlink_core::node::tests::bytes::a_poll_longer_than_the_limit_is_answered_before_the_reset",
            "powerlink_core::node::tests::errors::a_preq_of_invalid_format",
        ],
    ),
    (
        "Unknown message types, services and requests; reserved bits",
        "Counted and dropped; reserved bits are not looked at",
        &[
            "powerlink_core::node::tests::bytes::an_unknown_message_type_is_dropped",
            "powerlink_core::node::tests::bytes::unknown_requests_and_services_are_ignored",
            "powerlink_core::node::tests::bytes::reserved_bits_are_ignored",
        ],
    ),
    (
        "Another version",
        "Of the protocol: answered, with the own one in the IdentResponse. Of a mapping: its data are not used, and an error is told",
        &[
            "powerlink_core::node::tests::faults::another_version_of_the_protocol_is_answered",
            "powerlink_core::node::tests::data::the_version_of_a_mapping",
        ],
    ),
    (
        "Frames at addresses that are not theirs",
        "Counted and dropped",
        &["powerlink_core::node::tests::bytes::foreign_addresses_are_dropped"],
    ),
    (
        "A spoofed managing node",
        "Who sends as node 240 is obeyed, whatever its MAC address: there is no other sign. PReq and NMT commands of any other node are not",
        &[
            "powerlink_core::node::tests::faults::a_spoofed_managing_node",
            "powerlink_core::node::tests::bytes::a_poll_of_another_node_is_ignored",
            "powerlink_core::node::tests::commands::commands_that_nobody_follows",
        ],
    ),
    (
        "Two managing nodes",
        "One goes on, the other listens, and takes over when the first is gone",
        &[
            "tests::powerlink::faults::of_two_managing_nodes_at_the_same_moment_the_lower_address_goes_on",
            "tests::powerlink::faults::two_networks_that_are_joined_have_one_managing_node",
            "tests::powerlink::faults::there_is_one_managing_node_at_a_time",
        ],
    ),
    (
        "Two nodes with one node ID",
        "Both are told of it, and so is the managing node; the one that was identified runs, until it is gone",
        &[
            "powerlink_core::node::tests::bytes::another_node_with_the_same_number_is_told",
            "tests::powerlink::same_number::of_two_that_start_together_the_first_to_answer_is_the_node",
            "tests::powerlink::same_number::one_that_comes_later_takes_nothing_over",
            "tests::powerlink::same_number::the_other_one_follows_when_the_first_is_gone",
        ],
    ),
    (
        "Own frames are echoed",
        "Counted, and nothing else is different",
        &["powerlink_core::node::tests::faults::own_frames_that_come_back_are_counted"],
    ),
    (
        "Frames come in another order",
        "Two neighbours of a cycle that change places: one symptom of a kind at most, no change of state",
        &["powerlink_core::node::tests::faults::frames_in_another_order_change_no_state"],
    ),
    (
        "Frames come twice",
        "One symptom of a kind at most, no change of state; a command is followed once",
        &[
            "powerlink_core::node::tests::faults::a_frame_that_comes_twice_changes_no_state",
            "powerlink_core::node::tests::faults::a_command_that_comes_twice_is_followed_once",
            "tests::powerlink::faults::frames_that_arrive_twice_or_with_errors_do_no_harm",
        ],
    ),
    (
        "Anything of this at once, by chance, in a thousand networks",
        "When it is over, everybody is `Operational` again",
        &["tests::powerlink::chaos::after_any_losses_every_node_is_operational_again"],
    ),
    (
        "The clock of a node steps back",
        "The time stands until the clock is where it was; nothing ends early, polls are answered",
        &["powerlink_core::node::tests::faults::a_clock_that_steps_back"],
    ),
    (
        "A node is called seconds late",
        "Every wait that is over is served, before what the call brings; every SoC that was due is missed, in one step",
        &[
            "powerlink_core::node::tests::faults::called_seconds_late",
            "powerlink_core::node::tests::losses::a_node_that_is_called_late_misses_as_many_socs",
        ],
    ),
    (
        "Two ends of waits in one tick",
        "Both are served",
        &["powerlink_core::node::tests::faults::two_deadlines_in_one_tick"],
    ),
    (
        "The adapter takes nothing",
        "Told and counted; the node goes on with the next frame",
        &["powerlink_core::node::tests::faults::an_adapter_that_takes_nothing"],
    ),
    (
        "An answer is not fetched in time",
        "It is dropped and counted, not sent into another node's slot",
        &["powerlink_core::node::tests::losses::answers_that_nobody_fetched_are_not_sent_later"],
    ),
    (
        "Jitter, collisions, wrong checksums",
        "Counted; checksums, and what the options say, lead to `PreOperational1` at their threshold",
        &[
            "powerlink_core::node::tests::time::too_much_jitter_is_a_cycle_error_only_where_that_is_chosen",
            "powerlink_core::node::tests::time::collisions_count_and_checksums_lead_to_a_reaction",
        ],
    ),
];
