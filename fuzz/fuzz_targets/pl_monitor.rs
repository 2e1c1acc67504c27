//! `cargo fuzz run pl_monitor`: see `devicenet_fuzz::pl_monitor`.
#![cfg_attr(fuzzing, no_main)]
#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|data: &[u8]| devicenet_fuzz::pl_monitor::run(data));
#[cfg(not(fuzzing))]
fn main() {}
