//! The command line, its help, and defects of the scenario.

use super::{Scratch, devicenet, stderr, stdout};

#[test]
fn the_help_tells_how_to_write_a_scenario() {
    let help = devicenet(&["simulate", "--help"]);
    for words in ["docs/scenarios.md", "--print-plant", "`-` for standard input"] {
        assert!(stdout(&help).contains(words), "{words} is missing");
    }
}

#[test]
fn what_makes_no_sense_on_the_command_line_is_told() {
    for (arguments, told) in [
        (["--record", "-"], "--record -: standard output has the trace"),
        (["--svg", "-"], "--svg -: standard output has the trace"),
        (["--until", "-2s"], "`-2s` must not be negative"),
        (["--until", "9000h"], "more than 0s expected, at most 86400s"),
        (["--seed", "ten"], "a number from 0 to 18446744073709551615 expected, such as 7 or 0x2A"),
    ] {
        let output = devicenet(&[&["simulate"][..], &arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(stderr(&output).contains(told), "{}", stderr(&output));
    }
}

#[test]
fn a_defect_of_the_scenario_exits_2_and_shows_the_line() {
    let scenario = Scratch::new("defect.toml", "[bus]\n[[node]]\nname = \"a\"\nrole = \"spy\"\n");
    let output = devicenet(&["simulate", scenario.path()]);
    assert_eq!(output.status.code(), Some(2));
    let told = stderr(&output);
    assert!(told.contains("4:8: there is no role `spy`; expected `access`"), "{told}");
    assert!(told.contains("4 | role = \"spy\"\n  |        ^^^^^"), "{told}");
    assert_eq!(devicenet(&["simulate", "no/such.toml"]).status.code(), Some(2));
    assert_eq!(devicenet(&["simulate", "--until", "10"]).status.code(), Some(2));
}
