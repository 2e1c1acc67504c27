//! Recordings: every capture is read, formats agree, what is written is read back, bad files give typed errors.
#![allow(
    clippy::arithmetic_side_effects,
    clippy::as_conversions,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test may panic"
)]

mod binary;
mod captures;
mod text;
mod written;

use std::path::PathBuf;

use devicenet_cli::recording::{Format, RecordedFrame, Recording, RecordingError};

fn capture(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../tests/captures").join(name)
}

/// Format and frames of a capture that has no bad line.
fn read(name: &str) -> (Format, Vec<RecordedFrame>) {
    let recording = Recording::open(&capture(name)).unwrap();
    (
        recording.format(),
        recording.map(|frame| frame.unwrap_or_else(|error| panic!("{name}: {error}"))).collect(),
    )
}

fn read_bytes(bytes: &[u8]) -> Result<Vec<Result<RecordedFrame, RecordingError>>, RecordingError> {
    Ok(Recording::from_reader(std::io::Cursor::new(bytes.to_vec()))?.collect())
}
