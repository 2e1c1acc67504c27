//! A thousand networks that lose frames by chance: whatever happened, in the end everybody runs.

use std::time::Duration;

use devicenet_tests::powerlink::{Net, config, plan};
use powerlink_core::nmt::NmtState;
use transport_mock::ethernet::{Fate, Keep, SegmentConfig, rate};

#[test]
fn after_any_losses_every_node_is_operational_again() {
    for seed in 0..1_000 {
        let segment = SegmentConfig { seed, keep: Keep::Nothing, ..SegmentConfig::default() };
        let nodes = 1 + (seed % 3) as u8;
        let plans: Vec<_> = (1..=nodes).map(plan).collect();
        let mut net = Net::with(config(), &plans, segment);
        // From one frame in a hundred to one in three, from the beginning or in operation.
        if seed % 2 == 0 {
            net.run_until_complete(2_000);
        }
        net.segment.add_fault(rate(seed, 0.01 + 0.32 * (seed % 10) as f64 / 10.0, Fate::Lose));
        if seed % 5 == 0 {
            net.segment.add_fault(rate(!seed, 0.05, Fate::Late(Duration::from_micros(200 + seed))));
            net.segment.add_fault(rate(seed << 9, 0.05, Fate::Twice));
            net.segment.add_fault(rate(seed << 20, 0.02, Fate::Corrupt));
        }
        net.run(500 + seed);
        net.segment.clear_faults();
        // So long may it take until everybody has noticed what was lost.
        net.run(1_000);
        let is_complete = net.run_until_complete(10_000);
        assert!(is_complete, "seed {seed}: {:?}, {:?}", net.states(), net.mn(|mn, _| *mn.counters()));
        net.run(100);
        assert_eq!(net.states(), vec![NmtState::Operational; usize::from(nodes)], "seed {seed}");
    }
}
