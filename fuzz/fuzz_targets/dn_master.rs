//! `cargo fuzz run dn_master`: see `devicenet_fuzz::dn_master`.
#![cfg_attr(fuzzing, no_main)]
#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|data: &[u8]| devicenet_fuzz::dn_master::run(data));
#[cfg(not(fuzzing))]
fn main() {}
