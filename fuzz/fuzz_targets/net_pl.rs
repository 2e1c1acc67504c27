//! `cargo fuzz run net_pl`: see `devicenet_fuzz::net_pl`.
#![cfg_attr(fuzzing, no_main)]
#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|data: &[u8]| devicenet_fuzz::net_pl::run(data));
#[cfg(not(fuzzing))]
fn main() {}
