#![allow(clippy::expect_used, clippy::panic, missing_docs, reason = "tests panic to fail")]
//! The workspace itself: which crate may see which, and documents that must not drift from the code.

mod dependencies;
mod documents;
