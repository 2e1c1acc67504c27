//! The directions of `docs/architecture.md`, held against what cargo knows.

use std::collections::{BTreeMap, BTreeSet};

use cargo_metadata::{DependencyKind, MetadataCommand};
use devicenet_tests::workspace_root;

/// Each crate, and the crates of this workspace that it may depend on.
const MAY_SEE: [(&str, &[&str]); 11] = [
    ("link-core", &[]),
    ("cip-core", &["link-core"]),
    ("devicenet-core", &["link-core", "cip-core"]),
    ("devicenex-core", &["link-core", "cip-core"]),
    ("powerlink-core", &["link-core"]),
    ("transport-mock", &["link-core"]),
    ("transport-socketcan", &["link-core"]),
    ("transport-ethernet", &["link-core"]),
    (
        "devicenet-cli",
        &[
            "link-core",
            "cip-core",
            "devicenet-core",
            "devicenex-core",
            "powerlink-core",
            "transport-mock",
            "transport-socketcan",
            "transport-ethernet",
        ],
    ),
    (
        "devicenet-tests",
        &[
            "link-core",
            "cip-core",
            "devicenet-core",
            "devicenex-core",
            "powerlink-core",
            "transport-mock",
            "transport-ethernet",
            "devicenet-cli",
        ],
    ),
    (
        "devicenet-fuzz",
        &[
            "link-core",
            "cip-core",
            "devicenet-core",
            "devicenex-core",
            "powerlink-core",
            "transport-mock",
            "devicenet-cli",
            "devicenet-tests",
        ],
    ),
];

/// A transport whose benchmark, and nothing else, runs a node of a protocol.
const BENCHED: (&str, &str) = ("transport-ethernet", "powerlink-core");

const CORES: [&str; 5] = ["link-core", "cip-core", "devicenet-core", "devicenex-core", "powerlink-core"];

#[test]
fn dependencies_point_one_way() {
    let allowed = BTreeMap::from(MAY_SEE);
    let members: BTreeSet<&str> = allowed.keys().copied().collect();
    for package in metadata().workspace_packages() {
        let name = package.name.as_str();
        let may_see = allowed.get(name).unwrap_or_else(|| panic!("{name} is not in the table of this test"));
        for dependency in
            package.dependencies.iter().filter(|dependency| members.contains(dependency.name.as_str()))
        {
            let itself = dependency.name == name;
            let is_benched =
                dependency.kind == DependencyKind::Development && BENCHED == (name, dependency.name.as_str());
            assert!(
                itself || is_benched || may_see.contains(&dependency.name.as_str()),
                "{name} must not depend on {}",
                dependency.name
            );
        }
    }
}

#[test]
fn cores_use_no_crate_that_needs_the_standard_library() {
    for package in
        metadata().workspace_packages().iter().filter(|package| CORES.contains(&package.name.as_str()))
    {
        for dependency in &package.dependencies {
            if dependency.kind == DependencyKind::Normal && !dependency.optional {
                assert!(
                    !dependency.uses_default_features,
                    "{} takes {} with its default features",
                    package.name, dependency.name
                );
            }
        }
    }
}

#[test]
fn cores_forbid_std_and_unsafe_code_and_relax_no_lint() {
    for core in CORES {
        let source = devicenet_tests::read(&format!("{core}/src/lib.rs"));
        for line in ["#![no_std]", "#![forbid(unsafe_code)]"] {
            assert!(source.contains(line), "{core} lacks {line}");
        }
        for (path, text) in rust_sources(core) {
            for (number, line) in text.lines().enumerate() {
                let is_attribute = line.trim_start().starts_with('#');
                let relaxes =
                    is_attribute && line.contains("allow(") && !line.contains("cfg_attr(test, allow(");
                assert!(!relaxes, "{path}:{}: a core relaxes a lint: {line}", number + 1);
            }
        }
    }
}

fn rust_sources(package: &str) -> Vec<(String, String)> {
    let mut folders = vec![workspace_root().join(package).join("src")];
    let mut sources = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a source folder can be listed") {
            let path = entry.expect("an entry can be read").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = std::fs::read_to_string(&path).expect("a source file can be read");
                sources.push((path.display().to_string(), text));
            }
        }
    }
    sources
}

fn metadata() -> cargo_metadata::Metadata {
    MetadataCommand::new()
        .manifest_path(workspace_root().join("Cargo.toml"))
        .no_deps()
        .exec()
        .expect("cargo metadata runs")
}
