//! `cargo fuzz run net_nx`: see `devicenet_fuzz::net_nx`.
#![cfg_attr(fuzzing, no_main)]
#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|data: &[u8]| devicenet_fuzz::net_nx::run(data));
#[cfg(not(fuzzing))]
fn main() {}
