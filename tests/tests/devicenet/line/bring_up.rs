//! From power-up to I/O.
//!
//! Nobody can be faster than the two waits of network access and the frames without which no slave comes up: duplicate MAC
//! ID checks, and for each slave nine explicit requests with their responses. Polls of slaves that run already are not
//! counted as necessary.

use devicenet_tests::line::{bring_up_table, bring_ups};

/// Slaves are asked in turn, so that their reactions pass at the same time. Together with the table of `docs/results.md`.
#[test]
fn sixty_three_slaves_run_in_at_most_1_25_times_what_it_takes_at_least() {
    let all = bring_ups();
    for (plan, found) in &all {
        assert!(found.time > found.least(), "{plan:?}: {found:?}");
        assert!(found.time * 100 <= found.least() * 125, "{plan:?}: {found:?}");
    }
    let table = bring_up_table(&all);
    let document = devicenet_tests::read("docs/results.md");
    assert!(document.contains(&table), "docs/results.md should have this table:\n{table}");
}
