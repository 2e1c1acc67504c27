//! Documents that would drift if nobody looked.

use clap::CommandFactory;
use devicenet_tests::{read, workspace_root};

#[test]
fn every_public_crate_is_in_the_picture_of_the_architecture() {
    let page = read("docs/architecture.md");
    for folder in [
        "link-core/",
        "cip-core/",
        "devicenet-core/",
        "devicenex-core/",
        "powerlink-core/",
        "transport-mock/",
        "transport-socketcan/",
        "transport-ethernet/",
        "cli/",
        "tests/",
        "fuzz/",
        "docs/",
    ] {
        assert!(
            page.lines().any(|line| line.starts_with(folder)),
            "{folder} is missing in docs/architecture.md"
        );
    }
}

#[test]
fn the_minimum_rust_version_is_written_once() {
    let manifest = read("Cargo.toml");
    assert_eq!(manifest.matches("rust-version = ").count(), 1);
    for member in [
        "link-core",
        "cip-core",
        "devicenet-core",
        "devicenex-core",
        "powerlink-core",
        "transport-mock",
        "transport-socketcan",
        "transport-ethernet",
        "cli",
        "tests",
        "fuzz",
    ] {
        let member = read(&format!("{member}/Cargo.toml"));
        assert!(member.contains("rust-version.workspace = true"));
    }
}

/// Each row names where a feature is: a path of the workspace or a subcommand. What is supported exists, and what is not
/// supported does not.
#[test]
fn the_table_of_what_is_supported_tells_the_truth() {
    let readme = read("README.md");
    let mut states = Vec::new();
    for line in readme.lines().skip_while(|line| !line.starts_with("| feature |")).skip(2) {
        let Some(cells) = line.strip_prefix('|') else { break };
        let [feature, state, places, ""] = cells.split('|').map(str::trim).collect::<Vec<_>>()[..] else {
            panic!("not a row of three cells: {line}");
        };
        let places: Vec<&str> = places.split(',').map(|place| place.trim().trim_matches('`')).collect();
        for place in &places {
            assert_eq!(exists(place), state == "yes", "{feature}: README says {state}, look at {place}");
        }
        states.push(state);
    }
    assert!(
        states.contains(&"yes") && states.iter().all(|state| ["yes", "planned"].contains(state)),
        "{states:?}"
    );
}

fn exists(place: &str) -> bool {
    match place.strip_prefix("devicenet ") {
        Some(subcommand) => devicenet_cli::args::Cli::command().find_subcommand(subcommand).is_some(),
        None => workspace_root().join(place).exists(),
    }
}

#[test]
fn the_readme_begins_with_its_two_commands() {
    let readme = read("README.md");
    let blocks: Vec<&str> = readme.split("```").skip(1).step_by(2).take(2).collect();
    assert_eq!(blocks, ["sh\ncargo run --release -- simulate\n", "sh\ncargo test --workspace\n"]);
}

#[test]
fn links_between_documents_lead_somewhere() {
    for (page, folder) in [
        ("README.md", "."),
        ("docs/architecture.md", "docs"),
        ("docs/results.md", "docs"),
        ("docs/conformance.md", "docs"),
        ("docs/fault-matrix.md", "docs"),
    ] {
        let text = read(page);
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let path = link.split('#').next().unwrap_or_default();
            let is_here =
                path.is_empty() || link.contains("://") || workspace_root().join(folder).join(path).exists();
            assert!(is_here, "{page} links to {link}");
        }
    }
}

#[test]
fn the_readme_names_every_fuzz_target() {
    let readme = read("README.md");
    for entry in std::fs::read_dir(workspace_root().join("fuzz/fuzz_targets")).expect("the folder of targets")
    {
        let path = entry.expect("an entry").path();
        let name = path.file_stem().and_then(|name| name.to_str()).expect("a name in UTF-8");
        assert!(readme.contains(&format!("`{name}`")), "README does not name the fuzz target {name}");
    }
}

#[test]
fn the_scenario_of_the_readme_runs_and_its_expectation_holds() {
    use devicenet_cli::{scenario::Scenario, simulate};
    let readme = read("README.md");
    let text =
        readme.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).expect("a scenario");
    let scenario =
        Scenario::parse("README.md", text, &workspace_root()).unwrap_or_else(|error| panic!("{error}"));
    let outcome = simulate::outcome(&scenario, simulate::Settings::default());
    assert!(outcome.verdict.failures.is_empty(), "{:?}", outcome.verdict);
}

/// What a machine takes on a microcontroller, as the table of results has it.
#[test]
fn the_readme_has_the_sizes_of_the_results() {
    let (readme, results) = (read("README.md"), read("docs/results.md"));
    let readme = readme.split_whitespace().collect::<Vec<_>>().join(" ");
    for (machine, before) in [("bare", "network access takes "), ("small", "fragmented explicit messages ")] {
        let row = results
            .lines()
            .find(|line| line.starts_with(&format!("| `{machine}` |")) && line.ends_with("bytes |"));
        let row = row
            .and_then(|row| row.split('|').nth(2).zip(row.split('|').nth(4)))
            .expect("a row of the machine");
        let [code, ram] = [row.0, row.1].map(|cell| {
            cell.chars()
                .filter(char::is_ascii_digit)
                .collect::<String>()
                .parse::<u32>()
                .expect("a number of bytes")
        });
        let told = readme.split(before).nth(1).expect(before);
        let kilobytes = format!("{:.1} KB", f64::from(code) / 1000.0);
        assert!(told.starts_with(&kilobytes), "{machine}: {kilobytes}, but README has {told:.20}");
        let ram = format!(" and {ram} bytes");
        assert!(
            told.split(';').next().is_some_and(|told| told.replace(" of flash", "").contains(&ram)),
            "{machine}:{ram}"
        );
    }
}
