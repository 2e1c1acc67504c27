//! Another program that reads recordings.

use std::process::Command;

/// Whether it is here; where it must be, it is an error if it is not.
pub(crate) fn is_here(test: &str) -> bool {
    let is_here = Command::new("tshark").arg("--version").output().is_ok();
    if !is_here {
        assert!(
            std::env::var_os("DEVICENET_REQUIRE_TSHARK").is_none(),
            "DEVICENET_REQUIRE_TSHARK is set, and there is no tshark"
        );
        eprintln!("SKIPPED {test}: there is no tshark");
    }
    is_here
}
