//! Documents that would drift if nobody looked.

use devicenet_tests::read;

#[test]
fn every_public_crate_is_in_the_picture_of_the_architecture() {
    let page = read("docs/architecture.md");
    for folder in
        ["link-core/", "cip-core/", "devicenet-core/", "transport-mock/", "cli/", "tests/", "fuzz/", "docs/"]
    {
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
    for member in ["link-core", "cip-core", "devicenet-core", "transport-mock", "cli", "tests", "fuzz"] {
        let member = read(&format!("{member}/Cargo.toml"));
        assert!(member.contains("rust-version.workspace = true"));
    }
}
