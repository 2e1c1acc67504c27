//! The committed seeds: each runs through its target, and each is what its recipe makes.
//!
//! Seeds whose name begins with `found-` are inputs that once showed a defect; they have no recipe. The others are
//! written by
//!
//! ```sh
//! UPDATE_SEEDS=1 cargo test -p devicenet-fuzz --test seeds
//! ```

#![allow(
    clippy::arithmetic_side_effects,
    clippy::as_conversions,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used
)] // A test of constants.

mod recipes;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::{env, fs};

use devicenet_fuzz::TARGETS;

#[test]
fn every_seed_runs() {
    for target in TARGETS {
        let seeds = committed(target.name);
        assert!(!seeds.is_empty(), "no seeds for {}", target.name);
        for (name, bytes) in seeds {
            eprintln!("{}/{name}", target.name);
            (target.run)(&bytes);
        }
    }
}

#[test]
fn every_folder_and_every_program_has_a_target() {
    let targets: BTreeSet<_> = TARGETS.iter().map(|target| target.name.to_owned()).collect();
    let names = |folder: &str| -> BTreeSet<String> {
        let entries = fs::read_dir(root().join(folder)).unwrap();
        entries.map(|entry| entry.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned()).collect()
    };
    assert_eq!(names("seeds"), targets);
    assert_eq!(names("fuzz_targets"), targets);
    let manifest = fs::read_to_string(root().join("Cargo.toml")).unwrap();
    for target in &targets {
        assert!(manifest.contains(&format!("path = \"fuzz_targets/{target}.rs\"")), "{target} is no program");
    }
}

#[test]
fn every_seed_is_what_its_recipe_makes() {
    for target in TARGETS {
        let made: BTreeMap<_, _> = recipes::of(target.name).into_iter().collect();
        if env::var_os("UPDATE_SEEDS").is_some() {
            update(target.name, &made);
        }
        let mut committed = committed(target.name);
        committed.retain(|name, _| !name.starts_with("found-"));
        assert_eq!(
            committed.keys().collect::<Vec<_>>(),
            made.keys().collect::<Vec<_>>(),
            "names of {}",
            target.name
        );
        for (name, bytes) in &made {
            assert!(bytes.len() <= LONGEST, "{}/{name}: {} bytes", target.name, bytes.len());
            assert_eq!(&committed[name], bytes, "{}/{name}", target.name);
        }
    }
}

fn update(target: &str, made: &BTreeMap<String, Vec<u8>>) {
    let folder = root().join("seeds").join(target);
    fs::create_dir_all(&folder).unwrap();
    for name in
        committed(target).keys().filter(|name| !name.starts_with("found-") && !made.contains_key(*name))
    {
        fs::remove_file(folder.join(name)).unwrap();
    }
    for (name, bytes) in made {
        fs::write(folder.join(name), bytes).unwrap();
    }
}

fn committed(target: &str) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(root().join("seeds").join(target)).into_iter().flatten();
    entries
        .map(|entry| entry.unwrap().path())
        .map(|path| (path.file_name().unwrap().to_str().unwrap().to_owned(), fs::read(&path).unwrap()))
        .collect()
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()
}

/// As in the campaigns, which would cut a longer seed.
const LONGEST: usize = 512;
