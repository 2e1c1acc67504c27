//! `cargo fuzz run bus_paths`: see `devicenet_fuzz::bus_paths`.
#![cfg_attr(fuzzing, no_main)]
#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|data: &[u8]| devicenet_fuzz::bus_paths::run(data));
#[cfg(not(fuzzing))]
fn main() {}
