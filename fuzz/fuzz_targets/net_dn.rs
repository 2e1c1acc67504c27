//! `cargo fuzz run net_dn`: see `devicenet_fuzz::net_dn`.
#![cfg_attr(fuzzing, no_main)]
#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|data: &[u8]| devicenet_fuzz::net_dn::run(data));
#[cfg(not(fuzzing))]
fn main() {}
