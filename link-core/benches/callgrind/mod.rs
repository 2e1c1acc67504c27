//! Counting instructions with callgrind, for the benchmarks of the cores. Each is a program that calls itself under valgrind:
//! `PROGRAM CASE COUNT` is one run.

use std::process::Command;
use std::str::FromStr;

/// What was asked of the program: one run of a case, or nothing, for the table.
pub(crate) fn asked() -> Option<(String, u64)> {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let [case, count] = &arguments[..] else { return None };
    Some((case.clone(), u64::from_str(count).expect("a number")))
}

/// Instructions in functions of that name for one repetition of a case: the difference of two runs, divided by that of their
/// repetitions.
pub(crate) fn collected(case: &str, function: &str) -> u64 {
    let run = |count: u64| {
        let this = std::env::current_exe().expect("this program");
        let run = Command::new("valgrind")
            .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
            .arg(format!("--toggle-collect={function}"))
            .arg(this)
            .args([case, &count.to_string()])
            .output()
            .expect("valgrind: install Debian's package of that name");
        let text = String::from_utf8_lossy(&run.stderr);
        assert!(run.status.success(), "{text}");
        let line = text.lines().find_map(|line| line.split_once("Collected : ")).map(|(_, number)| number);
        line.and_then(|number| u64::from_str(number.trim()).ok()).unwrap_or_else(|| panic!("{text}"))
    };
    (run(2 * COUNT) - run(COUNT)) / COUNT
}

/// Repetitions of the shorter run.
const COUNT: u64 = 1000;
