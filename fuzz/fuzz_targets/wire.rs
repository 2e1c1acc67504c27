//! `cargo fuzz run wire`: see `devicenet_fuzz::wire`.
#![cfg_attr(fuzzing, no_main)]
#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|data: &[u8]| devicenet_fuzz::wire::run(data));
#[cfg(not(fuzzing))]
fn main() {}
