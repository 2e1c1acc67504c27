//! python-can, another program that speaks CAN.

use std::process::Command;

/// The Python that has python-can (`pip install python-can`): the `python3` of the path, or what `DEVICENET_PYTHON` says. Without it a
/// test is skipped, unless `DEVICENET_REQUIRE_PYTHON_CAN` is set.
pub(crate) fn with_python_can(test: &str) -> Option<String> {
    let python = std::env::var("DEVICENET_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let import = Command::new(&python).args(["-c", "import can"]).output();
    if import.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    assert!(
        std::env::var_os("DEVICENET_REQUIRE_PYTHON_CAN").is_none(),
        "DEVICENET_REQUIRE_PYTHON_CAN is set, and {python} has no python-can"
    );
    eprintln!("SKIPPED {test}: {python} has no python-can");
    None
}
