//! Files: recordings in every format that is read, and scenarios. A file can hold anything; what is wrong with it is said
//! with its place, and what was written is read back.

mod recordings;
mod scenarios;

/// Reads `data` as a file of each kind.
pub fn run(data: &[u8]) {
    scenarios::check(data);
    recordings::check(data);
}
