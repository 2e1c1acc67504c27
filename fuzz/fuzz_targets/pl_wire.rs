//! `cargo fuzz run pl_wire`: see `devicenet_fuzz::pl_wire`.
#![cfg_attr(fuzzing, no_main)]
#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|data: &[u8]| devicenet_fuzz::pl_wire::run(data));
#[cfg(not(fuzzing))]
fn main() {}
