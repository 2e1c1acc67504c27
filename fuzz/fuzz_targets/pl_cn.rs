//! `cargo fuzz run pl_cn`: see `devicenet_fuzz::pl_cn`.
#![cfg_attr(fuzzing, no_main)]
#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|data: &[u8]| devicenet_fuzz::pl_cn::run(data));
#[cfg(not(fuzzing))]
fn main() {}
