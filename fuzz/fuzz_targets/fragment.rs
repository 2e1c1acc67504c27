//! `cargo fuzz run fragment`: see `devicenet_fuzz::fragment`.
#![cfg_attr(fuzzing, no_main)]
#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|data: &[u8]| devicenet_fuzz::fragment::run(data));
#[cfg(not(fuzzing))]
fn main() {}
