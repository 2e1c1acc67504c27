#![allow(
    clippy::arithmetic_side_effects,
    clippy::as_conversions,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a harness may panic: that is how it tells"
)]
//! What the suites share. The suites themselves are in `tests/tests`, one binary a subject:
//!
//! | suite | what it holds |
//! |---|---|
//! | `workspace` | dependency directions, documents that must not drift |
//! | `devicenet` | golden vectors, captures, traces of networks |
//! | `exchanges` | a slave and the rest of the bus, frame by frame; the fault matrix and the table of conformance topics |
//! | `powerlink` | a recording of independent nodes, whole networks with faults |
//! | `scenarios` | the scenario files: expectations, traces, published results |
//!
//! Recordings are in `captures`, scenario files in `scenarios`, each with its source or purpose.

pub mod block;
pub mod line;
pub mod notation;
pub mod outcomes;
pub mod powerlink;

use std::path::{Path, PathBuf};

/// The root of the workspace.
#[must_use]
pub fn workspace_root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("the tests crate lies in the workspace")
        .to_path_buf()
}

/// A text file of the workspace, by its path from the root.
///
/// # Panics
/// When it cannot be read.
#[must_use]
#[track_caller]
pub fn read(path: &str) -> String {
    let full = workspace_root().join(path);
    std::fs::read_to_string(&full).unwrap_or_else(|error| panic!("{}: {error}", full.display()))
}

/// The Rust of the README, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
pub struct Readme;
