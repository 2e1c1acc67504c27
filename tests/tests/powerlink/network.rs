//! Whole networks from power-up, in virtual time.

use devicenet_tests::powerlink::Net;
use powerlink_core::nmt::NmtState;

#[test]
fn a_node_boots() {
    let mut net = Net::new(1);
    let done = net.run_until_complete(2_000);
    assert!(done, "{}", net.trace());
    assert_eq!(net.states(), [NmtState::Operational]);
}
