//! Two, three and sixty-three nodes with one MAC ID, in every order.

use devicenet_cli::scenario::StateName;
use devicenet_cli::simulate::Outcome;

use crate::{run, trace};

trace!(
    the_second_comes_late_and_is_told_so,
    "duplicate-late",
    "the request of the second is answered by a response of the first; the second sends nothing more"
);
trace!(
    the_second_comes_while_the_first_is_alone,
    "duplicate-while-the-first-is-alone",
    "the second is error-active and disturbs the first, so that its own request gets through, and the first is silent"
);
trace!(
    two_at_once_beside_a_bystander,
    "duplicate-at-once",
    "16 collisions to TEC 128 each; then the left request gets through, then the right one, which makes left silent"
);
trace!(
    two_at_once_alone,
    "duplicate-at-once-alone",
    "as beside a bystander, but left is not acknowledged; right gets through first"
);
trace!(
    a_request_in_the_first_wait_silences_the_first,
    "duplicate-in-the-first-wait",
    "first faults without a word when second asks; second never learns of it and gets on line"
);
trace!(
    a_request_in_the_second_wait_silences_the_first,
    "duplicate-in-the-second-wait", "as in the first wait"
);
trace!(
    three_at_once_beside_a_bystander,
    "duplicate-3-at-once",
    "after 16 collisions the requests get through one after the other, each silencing the one before"
);
trace!(
    three_at_once_alone,
    "duplicate-3-at-once-alone", "as beside a bystander, but the first is not acknowledged"
);
trace!(
    joined_segments_with_a_twin_each,
    "segments-joined",
    "nothing happens at 3 s; at 4 s both answer the third node: 16 collisions of the responses, then one hears the other"
);

/// One line a node: the trace of 63 is long, and says the same sixty times.
#[track_caller]
fn summary_of(outcome: &Outcome) -> String {
    assert_eq!(outcome.verdict.failures, []);
    let line = |node: &devicenet_cli::simulate::NodeSummary| {
        let state = node.state.map_or("-", StateName::name);
        let (sent, failed, tec, bus_offs) = (node.sent, node.failed, node.tec, node.bus_offs);
        format!("{}: {state}, sent {sent}, failed {failed}, TEC {tec}, bus-off {bus_offs}\n", node.node)
    };
    outcome.summary.nodes.iter().map(line).collect()
}

#[test]
fn sixty_three_at_once_beside_a_bystander() {
    let (_, outcome) = run("duplicate-63-at-once");
    insta::with_settings!({
        description => "16 collisions, then one node gets through in each round until TEC 256: 15 silent, 1 on line, 47 bus-off",
        omit_expression => true,
        prepend_module_to_snapshot => false,
    }, {
        insta::assert_snapshot!("summary__duplicate-63-at-once", summary_of(&outcome));
    });
}

#[test]
fn sixty_three_at_once_alone() {
    let (_, outcome) = run("duplicate-63-at-once-alone");
    insta::with_settings!({
        description => "as beside a bystander, but the first that gets through is not acknowledged",
        omit_expression => true,
        prepend_module_to_snapshot => false,
    }, {
        insta::assert_snapshot!("summary__duplicate-63-at-once-alone", summary_of(&outcome));
    });
}

#[test]
fn with_sixty_three_some_go_bus_off_and_exactly_one_gets_on_line() {
    for name in ["duplicate-63-at-once", "duplicate-63-at-once-alone"] {
        let (_, outcome) = run(name);
        let twins = || outcome.summary.nodes.iter().filter(|node| node.state.is_some());
        assert_eq!(twins().count(), 63);
        assert_eq!(twins().filter(|node| node.state == Some(StateName::OnLine)).count(), 1, "{name}");
        assert_eq!(twins().filter(|node| node.bus_offs == 1).count(), 47, "{name}");
    }
}

#[test]
fn two_twins_collide_sixteen_times_until_both_are_error_passive() {
    let (_, outcome) = run("duplicate-at-once");
    assert_eq!(outcome.summary.bus.errors, 16);
    // The one that got through last has an error more, from the frame that won against it.
    assert_eq!(outcome.summary.nodes.iter().map(|node| node.max_tec).collect::<Vec<_>>(), [128, 136, 0]);
}
