//! `cargo fuzz run monitor`: see `devicenet_fuzz::monitor`.
#![cfg_attr(fuzzing, no_main)]
#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|data: &[u8]| devicenet_fuzz::monitor::run(data));
#[cfg(not(fuzzing))]
fn main() {}
