//! `cargo fuzz run nx_node`: see `devicenet_fuzz::nx_node`.
#![cfg_attr(fuzzing, no_main)]
#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|data: &[u8]| devicenet_fuzz::nx_node::run(data));
#[cfg(not(fuzzing))]
fn main() {}
