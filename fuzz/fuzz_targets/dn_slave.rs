//! `cargo fuzz run dn_slave`: see `devicenet_fuzz::dn_slave`.
#![cfg_attr(fuzzing, no_main)]
#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|data: &[u8]| devicenet_fuzz::dn_slave::run(data));
#[cfg(not(fuzzing))]
fn main() {}
