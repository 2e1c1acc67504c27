//! Faults, by kind.

use std::path::Path;

use devicenet_cli::scenario::Scenario;

use crate::{VALVE, refused};

#[test]
fn faults() {
    refused(
        VALVE,
        r#"[[fault]]
kind = "gremlin""#,
        "9:8: there is no fault `gremlin`; expected `bit_error`, `lost_frame`, `noise`, `babble`, `clock` or `segment`",
    );
    refused(
        VALVE,
        r#"[[fault]]
kind = "bit_error""#,
        "8:1: `rate` per bit, or `bit` of one frame, is missing",
    );
    refused(
        VALVE,
        r#"[[fault]]
kind = "bit_error"
rate = 2.0"#,
        "10:8: `rate` is 2; expected a probability, 0 to 1",
    );
    refused(
        VALVE,
        r#"[[fault]]
kind = "noise"
rate = 0.5"#,
        "10:8: `rate` means nothing for the fault `noise`; expected `from`, `to`, `kind`, `gap`, `length`, `node` or `nodes`",
    );
    refused(
        VALVE,
        r#"[[fault]]
from = "3s"
to = "2s"
kind = "noise""#,
        "10:6: `to` is not after `from`; expected a later time",
    );
    refused(
        VALVE,
        r#"[[fault]]
kind = "segment""#,
        "8:1: the fault has neither `node` nor `nodes`; expected whom it is about",
    );
    refused(
        VALVE,
        r#"[[fault]]
kind = "segment"
nodes = ["valve", "pump"]"#,
        "10:19: there is no node `pump`; expected `valve`",
    );
}

#[test]
fn whom_a_fault_is_about() {
    refused(
        VALVE,
        r#"[[fault]]
kind = "noise"
gap = "1ms"
length = "1ms"
nodes = []"#,
        r#"12:9: `nodes` is empty; expected one or more, or no `nodes`"#,
    );
    refused(
        VALVE,
        r#"[[fault]]
kind = "segment"
nodes = []"#,
        r#"10:9: `nodes` is empty; expected one or more, or no `nodes`"#,
    );
    refused(
        VALVE,
        r#"[[fault]]
kind = "segment"
node = "valve"
nodes = ["valve"]"#,
        r#"11:9: there are both `node` and `nodes`; expected one of them"#,
    );
}

#[test]
fn times_that_make_no_fault() {
    refused(
        VALVE,
        r#"[[fault]]
kind = "noise"
gap = "0s"
length = "1ms""#,
        r#"10:7: `gap` is 0s, and without a gap the bursts never end; expected a longer time"#,
    );
    refused(
        VALVE,
        r#"[[fault]]
kind = "noise"
gap = "1ms"
length = "0s""#,
        r#"11:10: `length` is 0s, and a burst of no length disturbs nothing; expected a longer time"#,
    );
    refused(
        VALVE,
        r#"[[fault]]
kind = "babble"
pull = "0s"
every = "1ms""#,
        r#"10:8: `pull` is 0s, and a pull of no length disturbs nothing; expected a longer time"#,
    );
    refused(
        VALVE,
        r#"[[fault]]
kind = "babble"
pull = "1ms"
every = "0s""#,
        r#"11:9: `every` is not longer than `pull`; expected a longer time, or neither of them for a bus that is dominant for good"#,
    );
    refused(
        VALVE,
        r#"[[fault]]
kind = "babble"
pull = "1ms""#,
        r#"10:8: there is only one of `pull` and `every`; expected both, or neither for a bus that is dominant for good"#,
    );
    refused(
        VALVE,
        r#"[[fault]]
kind = "babble"
every = "1ms""#,
        r#"10:9: there is only one of `pull` and `every`; expected both, or neither for a bus that is dominant for good"#,
    );
}

#[test]
fn one_bit_or_a_rate() {
    refused(
        VALVE,
        r#"[[fault]]
kind = "bit_error"
rate = 0.1
bit = 3"#,
        r#"10:8: there are both `rate`, of every bit, and `bit` or `frame`, of one; expected one of them"#,
    );
    refused(
        VALVE,
        r#"[[fault]]
kind = "bit_error"
rate = 0.1
frame = 3"#,
        r#"10:8: there are both `rate`, of every bit, and `bit` or `frame`, of one; expected one of them"#,
    );
    refused(
        VALVE,
        r#"[[fault]]
kind = "bit_error"
frame = 3"#,
        r#"8:1: `rate` per bit, or `bit` of one frame, is missing"#,
    );
}

#[test]
fn faults_that_cannot_be_at_one_time() {
    refused(
        VALVE,
        r#"[[fault]]
kind = "clock"
from = "1s"
to = "3s"
ppm = 100
node = "valve"
[[fault]]
kind = "clock"
from = "2s"
ppm = 50
nodes = ["valve"]"#,
        r#"14:1: the clock of `valve` has another fault at this time; expected one after the other"#,
    );
    refused(
        VALVE,
        r#"[[fault]]
kind = "segment"
node = "valve"
[[fault]]
kind = "segment"
from = "2s"
to = "3s"
nodes = ["valve"]"#,
        r#"11:1: there is another segment at this time; expected one after the other, with all its nodes in one"#,
    );
    refused(
        VALVE,
        r#"[[fault]]
kind = "segment"
node = "valve"
[[fault]]
kind = "segment"
from = "10s"
nodes = ["valve"]"#,
        r#"11:1: there is another segment at this time; expected one after the other, with all its nodes in one"#,
    );
}

#[test]
fn one_fault_after_the_other_is_no_defect() {
    let clock = |from, to, ppm| {
        format!(
            "[[fault]]\nkind = \"clock\"\nfrom = \"{from}s\"\nto = \"{to}s\"\nppm = {ppm}\nnode = \"valve\"\n"
        )
    };
    let text = format!("{VALVE}{}{}", clock(2, 3, 100), clock(1, 2, 50));
    assert!(Scenario::parse("s.toml", &text, Path::new("")).is_ok());
}

#[test]
fn a_key_that_nobody_knows_is_told_with_those_of_its_kind() {
    refused(
        VALVE,
        r#"[[fault]]
kind = "noise"
lenght = "1ms""#,
        r#"10:1: there is no key `lenght` for the fault `noise`, did you mean `length`? expected `from`, `to`, `kind`, `gap`, `length`, `node` or `nodes`"#,
    );
    refused(
        VALVE,
        r#"[[fault]]
gab = 1
kind = "babble""#,
        r#"9:1: there is no key `gab` for the fault `babble`; expected `from`, `to`, `kind`, `pull` or `every`"#,
    );
    refused(
        VALVE,
        r#"[[fault]]
gab = 1"#,
        r#"9:1: there is no key `gab`, did you mean `gap`? expected `from`, `to`, `kind`, `node`, `nodes`, `rate`, `frame`, `bit`, `id`, `overrun`, `gap`, `length`, `pull`, `every` or `ppm`"#,
    );
}

#[test]
fn more_faults_than_anybody_can_mean() {
    let many = "[[fault]]\nkind = \"babble\"\n".repeat(4_097);
    refused(VALVE, &many, &format!("{}:1: there are too many faults; expected at most 4096", 8 + 2 * 4_096));
}
