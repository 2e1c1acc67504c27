//! What the documents say is what comes out.

use devicenet_cli::compare::{Comparison, Plan};
use devicenet_tests::outcomes::{Case, Counted, Start, table};
use link_core::BitRate;

use crate::traced_text;

#[test]
fn the_table_of_duplicate_mac_outcomes_is_computed() {
    let table = table();
    let document = devicenet_tests::read("docs/results.md");
    assert!(document.contains(&table), "docs/results.md should have this table:\n{table}");
}

/// The paper expects that both go bus-off. Neither does.
#[test]
fn two_nodes_never_go_bus_off_and_one_of_them_gets_on_line() {
    for bystander in [true, false] {
        let case = Case { nodes: 2, bystander, start: Start::SameBit };
        let Counted { on_line, bus_off, .. } = case.outcome(101..=130);
        assert!(on_line.iter().all(|count| *count == 1), "{case:?}: on line {on_line:?}");
        assert!(bus_off.iter().all(|count| *count == 0), "{case:?}: bus-off {bus_off:?}");
    }
}

/// DeviceNet and DeviceNeX side by side: the table and the picture.
#[test]
fn the_comparison_is_computed() {
    let comparison = Comparison::run(Plan { bit_rate: BitRate::K500, devices: 63, seed: 1 });
    let table = comparison.markdown();
    let document = devicenet_tests::read("docs/results.md");
    assert!(document.contains(&table), "docs/results.md should have this table:\n{table}");
    assert!(
        comparison.svg() == devicenet_tests::read("docs/compare.svg"),
        "docs/compare.svg is another picture: cargo run --release -- compare --svg docs/compare.svg"
    );
    // What the page says of them.
    let holds: Vec<bool> = comparison.claims.iter().map(|claim| claim.holds).collect();
    assert_eq!(holds, [true, true, false, true, true, false]);
    // Half of this claim is not measured, and the command says so as the page does.
    assert!(comparison.claims[3].finding.contains("does not show with two bytes"));
    assert!(document.contains("That a frame holds more data does not show with two bytes"));
}

/// The figures move with the bit rate and the number of devices; what they say stays.
#[test]
fn a_smaller_comparison_says_the_same() {
    let comparison = Comparison::run(Plan { bit_rate: BitRate::K125, devices: 5, seed: 7 });
    let holds: Vec<bool> = comparison.claims.iter().map(|claim| claim.holds).collect();
    // Five devices with one MAC ID are not many enough to go bus-off, but still one of them gets on line.
    assert_eq!(holds, [true, true, false, true, true, false], "{comparison}");
}

/// What the README shows is a scenario, and its expectations hold.
#[test]
fn the_scenario_of_the_readme() {
    let readme = devicenet_tests::read("README.md");
    let (_, after) = readme.split_once("```toml\n").expect("a scenario");
    let (text, _) = after.split_once("```").expect("its end");
    traced_text("README.md", text);
}
