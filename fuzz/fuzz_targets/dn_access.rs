//! `cargo fuzz run dn_access`: see `devicenet_fuzz::dn_access`.
#![cfg_attr(fuzzing, no_main)]
#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|data: &[u8]| devicenet_fuzz::dn_access::run(data));
#[cfg(not(fuzzing))]
fn main() {}
