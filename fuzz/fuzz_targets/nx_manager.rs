//! `cargo fuzz run nx_manager`: see `devicenet_fuzz::nx_manager`.
#![cfg_attr(fuzzing, no_main)]
#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|data: &[u8]| devicenet_fuzz::nx_manager::run(data));
#[cfg(not(fuzzing))]
fn main() {}
