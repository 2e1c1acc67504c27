//! `cargo fuzz run dn_tool`: see `devicenet_fuzz::dn_tool`.
#![cfg_attr(fuzzing, no_main)]
#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|data: &[u8]| devicenet_fuzz::dn_tool::run(data));
#[cfg(not(fuzzing))]
fn main() {}
