//! `record`: what led to an event, and what followed.

use std::path::PathBuf;
use std::process::Command;

use crate::{Run, devicenet, tshark};

/// A file of a test's own that is not there yet.
pub(crate) fn file(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_file(&path);
    path
}

fn record(file: &std::path::Path, more: &[&str]) -> Run {
    devicenet(&[&["record", "sim:drop.toml", "--output", file.to_str().unwrap()], more].concat())
}

/// The times of the frames in a recording.
fn times(file: &std::path::Path) -> Vec<f64> {
    let run = devicenet(&["decode", "--json", file.to_str().unwrap()]);
    run.json().iter().map(|frame| frame["t"].as_f64().unwrap()).collect()
}

/// The slave is cut off at 12 s, and missed four times its packet rate of 80 ms later.
#[test]
fn a_slave_that_drops_out_is_caught_with_five_seconds_before_and_after() {
    for name in ["drop.pcapng", "drop.log"] {
        let path = file(name);
        let run = record(&path, &["--trigger", "timeout"]);
        assert_eq!((run.code(), run.out()), (1, String::new()), "{}", run.err());
        assert!(
            run.err().contains("12.326 s: node 10 has not answered polls for 322 ms; recording to"),
            "{}",
            run.err()
        );
        let times = times(&path);
        let (first, last) = (times[0], times[times.len() - 1]);
        assert!((7.325..7.345).contains(&first), "{first}");
        assert!((17.306..17.327).contains(&last), "{last}");
        assert!(times.len() > 2000 && times.is_sorted());
    }
}

/// Another program reads the recording: the same frames at the same times, all of DeviceNet. The slave answers no more, and is polled
/// until its master gives it up.
#[test]
fn tshark_reads_the_recording() {
    if !tshark::is_here("tshark_reads_the_recording") {
        return;
    }
    let path = file("tshark.pcapng");
    assert_eq!(record(&path, &["--trigger", "timeout"]).code(), 1);
    let tshark = Command::new("tshark")
        .args(["-n", "-d", "can.subdissector,devicenet", "-Y", "devicenet && !_ws.malformed", "-T", "fields"])
        .args(["-e", "frame.time_epoch", "-e", "devicenet.can_id", "-r"])
        .arg(&path)
        .output()
        .unwrap();
    let theirs: Vec<String> = String::from_utf8(tshark.stdout).unwrap().lines().map(str::to_owned).collect();
    let ours: Vec<String> = devicenet(&["decode", "--json", path.to_str().unwrap()])
        .json()
        .iter()
        .map(|frame| format!("{:.9}\t0x{:04x}", frame["t"].as_f64().unwrap(), frame["id"].as_u64().unwrap()))
        .collect();
    assert_eq!(theirs, ours);
    let last = |id: &str| -> f64 {
        theirs.iter().rev().find_map(|line| line.strip_suffix(id)?.trim_end().parse().ok()).unwrap()
    };
    let (response, poll) = (last("0x03ca"), last("0x0455"));
    assert!(response < 12.0 && (12.3..12.4).contains(&poll), "{response} {poll}");
}

/// As objects: what it waits for, what has happened, what was written, how it ended.
#[test]
fn a_recorder_tells_of_its_work_in_objects() {
    let path = file("told.log");
    let run = record(&path, &["--trigger", "timeout", "--trigger", "id=0x3ca,data=??ff", "--json"]);
    assert_eq!((run.code(), run.err().as_str()), (1, ""));
    let [start, trigger, written, end] = &run.json()[..] else { panic!("{}", run.out()) };
    let name = path.to_str().unwrap();
    assert_eq!(
        *start,
        serde_json::json!({ "event": "start", "t": 0.0, "endpoint": "sim:drop.toml", "before": 5.0, "after": 5.0, "count": 1,
            "triggers": ["timeout", "id=0x3ca,data=??ff"] })
    );
    assert_eq!(
        (&trigger["event"], &trigger["n"], &trigger["file"]),
        (&"trigger".into(), &1.into(), &name.into())
    );
    assert_eq!(trigger["text"], "node 10 has not answered polls for 322 ms");
    let times = times(&path);
    let (first, last) = (times[0], times[times.len() - 1]);
    assert_eq!(
        (&written["event"], &written["frames"], &written["dropped"]),
        (&"written".into(), &times.len().into(), &0.into())
    );
    assert_eq!((written["first"].as_f64(), written["last"].as_f64()), (Some(first), Some(last)));
    assert_eq!(
        (&end["event"], &end["recordings"], &end["cause"]),
        (&"end".into(), &1.into(), &"complete".into())
    );
    for (more, cause) in [(&["--for", "3s"][..], "time_over"), (&[], "endpoint_over")] {
        let path = file("told-nothing.log");
        let run = record(&path, &[&["--trigger", "silence=30s", "--json"], more].concat());
        let last = run.json().pop().unwrap();
        assert_eq!((&last["recordings"], &last["cause"], run.code()), (&0.into(), &cause.into(), 0));
    }
    let run = devicenet(&["record", "sim:drop.toml", "--json", "--output", "-"]);
    assert_eq!((run.code(), run.out().as_str()), (2, ""));
    assert!(run.error().contains("both want standard output"), "{}", run.err());
}

/// There is room for a million frames before a trigger.
#[test]
fn frames_that_there_is_no_room_for_are_counted_and_told() {
    let recording = file("many.log");
    let mut log = String::new();
    for n in 0..1_000_500_u32 {
        log += &format!("({}.{:06}) can0 40A#00\n", n / 5_000, n % 5_000 * 200);
    }
    std::fs::write(&recording, log).unwrap();
    let path = file("of-many.log");
    let endpoint = format!("log:{}", recording.display());
    let arguments =
        ["--trigger", "silence=1s", "--before", "10min", "--json", "--output", path.to_str().unwrap()];
    let end = "(300.000000) can0 40A#00\n";
    std::io::Write::write_all(
        &mut std::fs::OpenOptions::new().append(true).open(&recording).unwrap(),
        end.as_bytes(),
    )
    .unwrap();
    let run = devicenet(&[&["record", &endpoint][..], &arguments].concat());
    let written = run.json().into_iter().find(|object| object["event"] == "written").unwrap();
    assert_eq!((&written["frames"], &written["dropped"]), (&1_000_000.into(), &500.into()));
    assert!(
        run.err().contains(
            "there is room for 1000000 frames before a trigger: 500 frames of the 600s before it were dropped"
        ),
        "{}",
        run.err()
    );
}

/// Classes and data as linux/can/error.h has them: a warning with counters, error-passive, bus-off, the restart, error-active again, and
/// frames that the controller had no time to hand over.
#[test]
fn what_the_controller_tells_is_recorded_and_lost_frames_are_told() {
    let recording = file("controller.log");
    let errors = [
        "20000204#0008000000006000",
        "20000004#0020000000000000",
        "20000040#0000000000000000",
        "20000100#0000000000000000",
        "20000004#0040000000000000",
        "20000004#0001000000000000",
        "20000004#0001000000000000",
    ];
    let log: String = (1..).zip(errors).map(|(n, error)| format!("({n}.000000) can0 {error}\n")).collect();
    std::fs::write(&recording, format!("(0.500000) can0 40A#00\n{log}(8.500000) can0 40A#00\n")).unwrap();
    let path = file("of-controller.log");
    let endpoint = format!("log:{}", recording.display());
    let arguments = ["--trigger", "silence=800ms", "--after", "20s", "--json", "-o", path.to_str().unwrap()];
    let run = devicenet(&[&["record", &endpoint][..], &arguments].concat());
    assert_eq!(run.code(), 1, "{}", run.err());
    let written = run.json().into_iter().find(|object| object["event"] == "written").unwrap();
    assert_eq!((&written["frames"], &written["lost"]), (&10.into(), &2.into()), "{written}");
    assert!(run.err().contains("2 frames or more came faster than they were read"), "{}", run.err());
    let words = |file: &std::path::Path| {
        let events = devicenet(&["monitor", &format!("log:{}", file.display()), "--json"]).json();
        let told = events.into_iter().filter(|event| event["event"] == "link" || event["event"] == "lost");
        let told: Vec<String> = told.map(|event| format!("{} {}", event["state"], event["frames"])).collect();
        assert_eq!(told.len(), 7, "{told:?}");
        told
    };
    assert_eq!(words(&path), words(&recording));
}

#[test]
fn another_slave_is_none_of_its_business() {
    let path = file("other.log");
    let run = record(&path, &["--trigger", "timeout=11", "--for", "25s"]);
    assert_eq!((run.code(), path.exists()), (0, false), "{}", run.err());
    assert!(run.err().contains("nothing happened that starts a recording"));
}

#[test]
fn several_recordings_are_numbered() {
    let path = file("checks.log");
    let numbered = ["checks-1.log", "checks-2.log"].map(file);
    let trigger = "kind=dup_mac_request,mac=10,data=00??12";
    let run = record(&path, &["--trigger", trigger, "--count", "2", "--before", "100ms", "--after", "500ms"]);
    assert_eq!((run.code(), path.exists()), (1, false), "{}", run.err());
    assert_eq!(numbered.map(|path| times(&path).len()), [3, 3], "the checks of three nodes");
}

#[test]
fn a_bus_that_falls_silent_is_noticed() {
    let path = file("silence.log");
    let capture = "../../../tests/captures/slave-01-startup-poll.log";
    let run = devicenet(&[
        "record",
        &format!("log:{capture}"),
        "--trigger",
        "silence=2s",
        "-o",
        path.to_str().unwrap(),
    ]);
    assert_eq!(run.code(), 1, "{}", run.err());
    assert!(run.err().contains("nothing was heard for 2s"), "{}", run.err());
}

#[test]
fn a_recording_goes_to_standard_output() {
    let path = file("as-on-standard-output.log");
    assert_eq!(record(&path, &["--trigger", "timeout"]).code(), 1);
    let run = devicenet(&["record", "sim:drop.toml", "--trigger", "timeout", "--output", "-"]);
    assert_eq!(run.code(), 1, "{}", run.err());
    assert_eq!(run.out(), std::fs::read_to_string(&path).unwrap());
    assert!(run.err().contains("recording to <stdout>\n"), "{}", run.err());
}

/// A frame that nobody but the recorder could acknowledge is not acknowledged: its sender ends it with an error flag.
#[test]
fn who_records_changes_nothing_on_the_bus() {
    let path = file("lone.log");
    let arguments = ["--trigger", "error", "--for", "20s", "-o", path.to_str().unwrap()];
    let run = devicenet(&[&["record", "sim:late.toml"][..], &arguments].concat());
    assert_eq!(run.code(), 1, "{}", run.err());
    assert!(run.err().contains("note: 15.000 s: form error; recording to"), "{}", run.err());
}

/// Not only when there is a next frame, and as soon after a long time with frames as after a short one.
#[test]
fn a_bus_that_stays_silent_is_noticed_in_time() {
    let path = file("stays-silent.log");
    let arguments =
        ["--trigger", "silence=2s", "--before", "1s", "--after", "1s", "-o", path.to_str().unwrap()];
    let run = devicenet(&[&["record", "sim:silence.toml"][..], &arguments].concat());
    assert_eq!(run.code(), 1, "{}", run.err());
    let at: f64 = run
        .err()
        .lines()
        .find_map(|line| {
            line.strip_prefix("note: ")?.split_once(" s: nothing was heard for 2s")?.0.parse().ok()
        })
        .unwrap();
    assert!((11.9..12.02).contains(&at), "{at}");
}

#[test]
fn nothing_is_overwritten() {
    let path = file("kept.log");
    std::fs::write(&path, "what was there\n").unwrap();
    let run = record(&path, &[]);
    assert_eq!(run.code(), 2);
    assert!(run.error().contains("exists already"), "{}", run.err());
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "what was there\n");
    let run = record(&file("x.log"), &["--trigger", "never"]);
    assert_eq!(run.code(), 2);
    assert!(run.err().contains("expected timeout, timeout=MAC, duplicate"), "{}", run.err());
}

/// A file that is created when something happens has a folder before that.
#[test]
fn a_folder_that_is_not_there_is_told_at_once() {
    for output in ["no/such/x.log", "drop.toml/x.log"] {
        let run = devicenet(&["record", "sim:drop.toml", "--for", "1s", "-o", output]);
        assert_eq!(run.code(), 2, "{}", run.err());
        assert!(run.error().contains("there is no folder"), "{}", run.err());
    }
}

/// Nobody can create a file there, root neither.
#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_cannot_be_written_to_is_told_at_once() {
    let run = devicenet(&["record", "sim:two.toml", "--for", "1s", "-o", "/proc/x.log"]);
    assert_eq!((run.code(), run.out().as_str()), (2, ""), "{}", run.err());
    assert!(run.error().starts_with("/proc/x.log cannot be created: "), "{}", run.err());
}

/// What was to be recorded is lost, and was not recorded.
#[cfg(target_os = "linux")]
#[test]
fn a_recording_that_cannot_be_written_is_a_failure() {
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_devicenet"))
        .args(["record", concat!("sim:", env!("CARGO_MANIFEST_DIR"), "/tests/live/drop.toml"), "-o", "-"])
        .stdout(full)
        .output()
        .unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("error: cannot write: "), "{told}");
    assert!(!told.contains("1 recording") && !told.contains("nothing happened"), "{told}");
}

/// Of a silence of decades the rest is passed over, but not before the silence that is waited for.
#[test]
fn a_recording_whose_clock_was_set() {
    let recording = file("clock-set.log");
    std::fs::write(&recording, "(1.000000) can0 40A#00\n(1700000000.000000) can0 40A#00\n").unwrap();
    let path = file("clock-set-silence.log");
    let endpoint = format!("log:{}", recording.display());
    let run = devicenet(&["record", &endpoint, "--trigger", "silence=5min", "-o", path.to_str().unwrap()]);
    assert_eq!(run.code(), 1, "{}", run.err());
    assert!(run.err().contains("note: 300.000 s: nothing was heard for 300s; recording to"), "{}", run.err());
    let run = devicenet(&[
        "record",
        &endpoint,
        "--trigger",
        "timeout",
        "-o",
        path.with_extension("x").to_str().unwrap(),
    ]);
    assert_eq!(run.code(), 0, "{}", run.err());
    assert!(run.err().contains("nothing was heard for 1699999999.000 s after 0.000 s"), "{}", run.err());
}
