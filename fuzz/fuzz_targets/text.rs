//! `cargo fuzz run text`: see `devicenet_fuzz::text`.
#![cfg_attr(fuzzing, no_main)]
#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|data: &[u8]| devicenet_fuzz::text::run(data));
#[cfg(not(fuzzing))]
fn main() {}
