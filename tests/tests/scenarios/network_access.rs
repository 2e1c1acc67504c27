//! One node with a MAC ID: alone, bus-off, at the wrong rate, with Quick Connect, repaired.

use std::path::Path;

use devicenet_cli::scenario::Scenario;
use devicenet_cli::simulate::{self, Settings};

use crate::{PAIR, holds, run, trace};

trace!(
    a_lone_node_stays_error_passive,
    "lone", "TEC 128 after 16 attempts and never more; no bus-off; the request is never sent"
);
trace!(
    a_lone_node_gets_on_line_when_another_comes,
    "lone-until-another-comes",
    "at 100 ms the scanner appears and acknowledges; both are on line two waits later"
);
trace!(bus_off_with_boi_0_is_for_good, "bus-off-boi-0", "OnLine -> CommFault: bus-off, and nothing after it");
trace!(
    bus_off_with_boi_1_begins_anew,
    "bus-off-boi-1",
    "OnLine -> SendingDupMac: bus-off, BOI; 100 ms and 128 x 11 bits later a request, on line two waits later"
);
trace!(
    a_wrong_bit_rate_stops_the_bus,
    "wrong-bit-rate",
    "everything is well until 0.5 s; after it no frame gets through, and all are error-passive"
);
trace!(
    quick_connect_is_on_line_with_the_first_request,
    "quick-connect", "on line within a millisecond; the second request a second later"
);
trace!(
    quick_connect_is_stopped_by_a_response,
    "quick-connect-duplicate", "on line for the time of one frame, until the response of the valve"
);
trace!(
    a_faulted_node_is_repaired_through_the_offline_set,
    "offline-repair", "who, identify, change to 11, then requests with MAC ID 11, and on line"
);

#[test]
fn a_lone_node_sends_sixteen_frames_to_error_passive_and_no_more_counts() {
    let (_, outcome) = run("lone");
    let node = &outcome.summary.nodes[0];
    assert_eq!((node.sent, node.tec, node.max_tec, node.bus_offs), (0, 128, 128, 0));
    // 125 kbit/s, 100 bits and the error frame: about a thousand attempts a second.
    assert!((990..1_010).contains(&node.failed), "{}", node.failed);
}

/// Without `to`, what is never so is not so to the end of the run, which is later than that of the scenario here.
#[test]
fn never_is_the_whole_run() {
    let text = format!(
        "{PAIR}[[action]]\nat = \"10s\"\nnode = \"valve\"\ndo = \"reset\"\n\
         [[expect]]\nnever = true\nfrom = \"10s\"\nnode = \"valve\"\nstate = \"online\"\n"
    );
    let scenario = Scenario::parse("pair", &text, Path::new("")).unwrap();
    let until = |seconds| {
        let until = Some(core::time::Duration::from_secs(seconds));
        simulate::outcome(&scenario, Settings { seed: None, until }).verdict
    };
    assert_eq!((until(11).held, until(11).failures.len()), (1, 0), "it is not on line again yet");
    let found: Vec<String> = until(13).failures.into_iter().map(|failure| failure.found).collect();
    assert_eq!(found.len(), 1);
    assert!(found[0].starts_with("online at 12.0"), "{found:?}");
    assert_eq!(until(9).unjudged, 1, "it ends before that begins");
}

#[test]
fn an_event_and_the_state_that_it_leads_to() {
    holds(
        r#"
        [[expect]]
        by = "10ms"
        node = "valve"
        event = "sent"
        state = "waiting_dup_mac"
        [[expect]]
        never = true
        node = "valve"
        event = "sent"
        state = "sending_dup_mac"
        [[expect]]
        from = "2s"
        to = "3s"
        node = "valve"
        event = "state_changed"
        state = "online""#,
    );
}
