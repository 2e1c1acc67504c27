//! `cargo fuzz run frame_decode`: see `devicenet_fuzz::frame_decode`.
#![cfg_attr(fuzzing, no_main)]
#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|data: &[u8]| devicenet_fuzz::frame_decode::run(data));
#[cfg(not(fuzzing))]
fn main() {}
