//! Captures of Ethernet POWERLINK in which frames are missing, or time is.

use serde_json::json;

use super::powerlink::{BOOT, boot, decode};
use super::{assert_exit, capture, json_lines, stdout};

/// The header of the capture, and its records with theirs.
fn records() -> (Vec<u8>, Vec<Vec<u8>>) {
    let bytes = std::fs::read(capture(BOOT)).unwrap();
    let (header, mut rest) = bytes.split_at(24);
    let mut records = Vec::new();
    while let Some(length) = rest.get(8..12) {
        let length = u32::from_le_bytes(length.try_into().unwrap());
        let (record, others) = rest.split_at(16 + usize::try_from(length).unwrap());
        records.push(record.to_vec());
        rest = others;
    }
    (header.to_vec(), records)
}

/// A PRes that is lost in the cycle is another thing than a request for a status that is not answered.
#[test]
fn lost_pres_and_unanswered_requests_are_counted_apart() {
    let (mut file, records) = records();
    let kinds: Vec<_> = json_lines(&boot(&["--json"])).iter().map(|object| object["kind"].clone()).collect();
    let lost = |kind: &str, which: &[usize]| {
        let frames = (0..kinds.len()).filter(|&at| kinds[at] == kind).collect::<Vec<_>>();
        which.iter().map(|&at| frames[at]).collect::<Vec<_>>()
    };
    let lost = [lost("pres", &[10, 12, 14]), lost("asnd_status_response", &[40])].concat();
    (0..records.len()).filter(|at| !lost.contains(at)).for_each(|at| file.extend(&records[at]));
    let summary = decode("losses.pcap", &file, &["--summary"]);
    assert_exit(&summary, 1);
    let row = |first: &str| {
        let line = stdout(&summary).lines().find(|line| line.trim_start().starts_with(first));
        line.unwrap().split_whitespace().collect::<Vec<_>>()
    };
    let titles = "node frames bytes problems polls PRes lost late p50 p99 max unanswered MAC device";
    assert_eq!(row("node").join(" "), titles);
    let node = row("1 ");
    assert_eq!((node[5], node[6], node[13]), ("3", "0", "1"), "{node:?}");
    let rows = json_lines(&decode("losses.pcap", &file, &["--summary", "--json"]));
    let node = rows.iter().find(|row| row["summary"] == "node" && row["node"] == 1).unwrap();
    assert_eq!(
        node["losses"],
        json!({ "polls": 32, "pres_missing": 3, "pres_late": 0, "answers_missing": 1 })
    );
}

/// The clock of the computer was set while it captured.
#[test]
fn a_clock_that_goes_back_is_told() {
    let (mut file, mut records) = records();
    for record in &mut records[300..] {
        let seconds = u32::from_le_bytes(record[..4].try_into().unwrap()) - 3600;
        record[..4].copy_from_slice(&seconds.to_le_bytes());
    }
    records.iter().for_each(|record| file.extend(record));
    let objects = json_lines(&decode("back.pcap", &file, &["--json"]));
    let told: Vec<_> = objects.iter().filter(|object| object.get("note").is_some()).collect();
    assert!(told.len() == 1 && told[0]["n"] == 301, "{told:?}");
    let note = told[0]["note"].as_str().unwrap();
    assert!(note.starts_with("the clock of the capture goes back by 3599"), "{note}");
    let summary = decode("back.pcap", &file, &["--summary"]);
    assert!(
        stdout(&summary).contains(
            "\nthe clock of the capture goes back 1 time: what is measured across that means nothing\n"
        ),
        "{}",
        stdout(&summary)
    );
    assert_eq!(json_lines(&decode("back.pcap", &file, &["--summary", "--json"]))[0]["clock_back"], 1);
}
