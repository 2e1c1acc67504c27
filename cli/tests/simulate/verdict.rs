//! Expectations are judged and told.

use super::{Scratch, VALVE, devicenet, lines_of_json, stdout};

#[test]
fn an_expectation_that_fails_is_told_and_exits_1() {
    let text = format!("{VALVE}\n[[expect]]\nby = \"1ms\"\nnode = \"valve\"\nstate = \"comm_fault\"\n");
    let scenario = Scratch::new("fails.toml", &text);
    let output = devicenet(&["simulate", scenario.path()]);
    assert_eq!(output.status.code(), Some(1));
    let told = format!(
        "expectation failed: {}, line 15: valve: expected comm_fault by 1ms; found online since 936us; it never came \
         after\n0 of 1 expectation held\n",
        scenario.path()
    );
    assert!(stdout(&output).ends_with(&told), "{}", stdout(&output));

    let json = devicenet(&["simulate", "--json", scenario.path()]);
    assert_eq!(json.status.code(), Some(1));
    let lines = lines_of_json(&json);
    let failed = lines.iter().find(|line| line["event"] == "expectation").expect("the expectation");
    assert_eq!(
        (failed["line"].as_u64(), failed["found"].as_str().map(|text| &text[..6])),
        (Some(15), Some("online"))
    );
    let summary = lines.last().expect("the summary");
    assert_eq!((summary["event"].as_str(), summary["failed"].as_u64()), (Some("summary"), Some(1)));
}

#[test]
fn a_run_that_is_cut_short_judges_what_it_can() {
    let text = format!("{VALVE}\n[[expect]]\nat = \"2s\"\nnode = \"valve\"\nstate = \"online\"\n");
    let scenario = Scratch::new("short.toml", &text);
    let output = devicenet(&["simulate", "--until", "10ms", scenario.path()]);
    assert_eq!(output.status.code(), Some(0));
    assert!(stdout(&output).ends_with("0 of 0 expectations held, 1 lies after the end of the run\n"));
}
