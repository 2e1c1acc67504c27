//! `cargo fuzz run eds`: see `devicenet_fuzz::eds`.
#![cfg_attr(fuzzing, no_main)]
#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|data: &[u8]| devicenet_fuzz::eds::run(data));
#[cfg(not(fuzzing))]
fn main() {}
