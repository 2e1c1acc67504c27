//! Nodes that speak DeviceNeX.

use crate::{run, trace};

trace!(
    of_two_with_one_address_the_lower_identity_keeps_it,
    "devicenex/two-with-one-address",
    "both begin with OA 67 in one bit; the higher one says its two Hellos again with OA 127, and stands by"
);
trace!(
    the_worked_example_of_the_paper,
    "devicenex/worked-example",
    "figures 12 to 18: silent until the manager is there, ROAM to 5, 67 and 109, B2 produces; from 20 s on B1 in its place, \
     nothing to A and C but questions; at 28 s B2 comes back and stands by"
);
trace!(
    a_roam_does_not_tell_its_sender,
    "devicenex/roam-race",
    "at 8 s two ROAMs with one identifier and other data: 17 collisions, then one, and the other comes too late"
);

/// Which scenario, and how many of its expectations hold: that none is lost in silence.
#[test]
fn every_other_scenario_holds() {
    for (name, expectations) in [
        ("full-network", 637),
        ("hello-storm", 511),
        ("half-a-serial-number", 4),
        ("manager-displaced", 16),
        ("manager-last", 11),
        ("manager-lost", 7),
        ("managers-joined", 14),
        ("second-manager", 10),
        ("segments-joined", 11),
        ("two-managers", 10),
        ("wrong-bit-rate", 13),
    ] {
        let (trace, outcome) = run(&format!("devicenex/{name}"));
        assert_eq!(outcome.verdict.failures, [], "{name}: {trace}");
        assert_eq!((outcome.verdict.held, outcome.verdict.unjudged), (expectations, 0), "{name}");
    }
}
