//! Every recording in `tests/captures`, decoded: a snapshot of the words, and the complete list of its problems.

use std::collections::BTreeSet;

use devicenet_core::doctor::{Doctor, DoctorConfig, Rule};
use devicenet_core::monitor::{Monitor, MonitorConfig};

use crate::harness::{Line, capture, decode, trace};

/// Frame number and code of a problem.
type Found = (u64, &'static str);

/// File, what it shows, and all of its problems. `captures/README.md` says where they come from.
const CAPTURES: &[(&str, &str, &[Found])] = &[
    (
        "session-two-slaves-on-vcan.log",
        "two slaves, by hand: an acknowledge without the FRAG bit, then a twin of MAC ID 10",
        &[(9, "response_bit_on_request"), (29, "two_identities"), (30, "duplicate_mac_id")],
    ),
    ("slave-01-startup-poll.log", "start, poll, release; a poll and a request after the release", &[]),
    (
        "slave-04-fragmented-response.log",
        "a fragmented response with every variation of the acknowledges",
        &[
            // The master acknowledges a fragment that is not waited for.
            (22, "unknown_acknowledge"),
            // It says "too much data", and then acknowledges all the same: the slave sends a stray fragment.
            (30, "fragment_refused"),
            (32, "no_first_fragment"),
            // It does not acknowledge; after the slave has given up, it does: another stray fragment.
            (35, "fragment_unacknowledged"),
            (36, "late_acknowledge"),
            (37, "no_first_fragment"),
            // It asks something else in the middle, and then acknowledges the abandoned response.
            (44, "unknown_acknowledge"),
            // It sets the transaction ID in one acknowledge; the slave copies it from there.
            (47, "transaction_mismatch"),
            (48, "transaction_changed"),
            (49, "transaction_mismatch"),
        ],
    ),
    ("icpdas-can8124-poll.log", "the device rounds the expected packet rate", &[]),
    ("icpdas-i7242d-cyclic.log", "starts after the allocation: assumed", &[]),
    ("bei-mhk5-cos.log", "requests only", &[]),
    ("inficon-get-set-assembly-path.log", "a path, read in one frame and written in two fragments", &[]),
    ("mks-baratron-explicit.log", "responses only", &[]),
    (
        "candump-L-mixed.log",
        "frames that are not DeviceNet, in several forms",
        &[
            (3, "extended_identifier"),
            (4, "remote_frame"),
            (5, "remote_frame"),
            (7, "invalid_identifier"),
            (8, "extended_identifier"),
        ],
    ),
    ("candump-ta.txt", "as the start of slave-01-startup-poll", &[]),
    (
        "socketcan-le-usec.pcap",
        "the same, and two frames that are not DeviceNet",
        &[(21, "extended_identifier"), (22, "remote_frame")],
    ),
    (
        "socketcan.pcapng",
        "the same, and two frames that are not DeviceNet",
        &[(21, "extended_identifier"), (22, "remote_frame")],
    ),
];

#[test]
fn every_capture_has_its_problems_and_no_others() {
    for (name, _, allowed) in CAPTURES {
        let found = problems(&decode(name));
        assert_eq!(found, *allowed, "{name}");
    }
}

#[test]
fn every_capture_in_words() {
    for (name, description, _) in CAPTURES {
        let lines = decode(name);
        insta::with_settings!({ omit_expression => true, description => *description }, {
            insta::assert_snapshot!(format!("capture__{}", name.replace('.', "-")), trace(&lines));
        });
    }
}

/// A capture that is added must be listed here.
#[test]
fn every_capture_is_listed() {
    let directory = devicenet_tests::workspace_root().join("tests/captures");
    let files = std::fs::read_dir(&directory).expect("the captures are there");
    let files = files.map(|entry| entry.expect("a readable entry"));
    // The folders hold one recording in many forms, for the readers of recordings.
    let files = files.filter(|entry| entry.file_type().expect("a file type").is_file());
    let files = files.map(|entry| entry.file_name().into_string().expect("UTF-8"));
    // What was sent, without times of a bus; and the README.
    let recordings: BTreeSet<String> =
        files.filter(|name| !name.ends_with(".stim") && !name.ends_with(".md")).collect();
    let listed: BTreeSet<String> = CAPTURES.iter().map(|(name, ..)| (*name).to_owned()).collect();
    assert_eq!(recordings, listed);
}

/// A recording that starts in the middle has no problems that the whole recording does not have.
#[test]
fn a_late_start_makes_no_problems() {
    for (name, _, allowed) in CAPTURES {
        let frames = crate::harness::capture(name);
        for skipped in 1..frames.len() {
            let mut observer = crate::harness::Observer::new();
            observer.n = u64::try_from(skipped).expect("a small number");
            let lines: Vec<Line> =
                frames[skipped..].iter().map(|(at, frame)| observer.observe(*at, frame)).collect();
            for problem in problems(&lines) {
                assert!(allowed.contains(&problem), "{name} from frame {}: {problem:?}", skipped + 1);
            }
        }
    }
}

/// What a doctor finds in them; in all others, nothing.
const FINDINGS: &[(&str, &[Rule])] = &[
    // A twin of MAC ID 10.
    ("session-two-slaves-on-vcan.log", &[Rule::DuplicateMacId]),
    // Frames that are not DeviceNet.
    ("candump-L-mixed.log", &[Rule::ForeignTraffic]),
    ("socketcan-le-usec.pcap", &[Rule::ForeignTraffic]),
    ("socketcan.pcapng", &[Rule::ForeignTraffic]),
];

#[test]
fn no_false_alarms_in_captures() {
    for (name, ..) in CAPTURES {
        let mut monitor = Box::new(Monitor::new(MonitorConfig::default()));
        let mut doctor = Box::new(Doctor::new(DoctorConfig::default()));
        for (n, (at, frame)) in (1..).zip(capture(name)) {
            doctor.observe(&mut monitor, at, n, &frame);
        }
        let found: Vec<Rule> = doctor.findings().map(|finding| finding.rule).collect();
        let expected = FINDINGS.iter().find(|(listed, _)| listed == name).map_or(&[][..], |(_, rules)| rules);
        assert_eq!(found, expected, "{name}");
    }
}

fn problems(lines: &[Line]) -> Vec<Found> {
    lines.iter().filter_map(|line| line.problem.map(|problem| (line.n, problem.code()))).collect()
}
