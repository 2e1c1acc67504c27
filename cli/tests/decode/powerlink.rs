//! Captures of Ethernet POWERLINK.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Cursor;
use std::process::Output;

use devicenet_cli::recording::Opened;
use link_core::codec::Writer;
use powerlink_core::monitor::{Captured, SizedMonitor};
use proptest::prelude::*;
use serde_json::{Value, json};

use super::{assert_exit, capture, devicenet, json_lines, pcapng, run, stderr, stdout, temporary};

pub(super) const BOOT: &str = "powerlink/boot.pcap";

/// The capture on standard input, so that nothing names a folder.
pub(super) fn boot(options: &[&str]) -> Output {
    let mut command = devicenet(&[&["decode", "-"], options].concat());
    command.stdin(File::open(capture(BOOT)).unwrap()).output().unwrap()
}

/// A file with these bytes, decoded.
pub(super) fn decode(name: &str, bytes: &[u8], options: &[&str]) -> Output {
    let path = temporary(name);
    std::fs::write(&path, bytes).unwrap();
    run(&[&["decode", &*path], options].concat())
}

#[test]
fn a_node_is_booted() {
    let all = boot(&["--time", "relative"]);
    assert_exit(&all, 0);
    assert_eq!((stderr(&all), stdout(&all).lines().count()), ("", 640));
    let telling = ["NMTReset", "NMTStart", "NMTEnable", "IdentResponse", "SDO", "PRes", "ER=1"];
    let shown = stdout(&all).lines().filter(|line| telling.iter().any(|words| line.contains(words)));
    let shown: Vec<_> = shown.take(74).collect();
    insta::with_settings!({ omit_expression => true, description => "Every line aligned; SDO requests and responses name the same object." }, {
        insta::assert_snapshot!("boot", shown.join("\n"));
    });
}

#[test]
fn a_summary_tells_cycle_nodes_and_transfers() {
    let summary = boot(&["--summary"]);
    assert_exit(&summary, 0);
    insta::with_settings!({ omit_expression => true, description => "No problem; cycle of 20 ms; node 1 reaches NMT_OPERATIONAL." }, {
        insta::assert_snapshot!("boot_summary", stdout(&summary));
    });
    let rows = json_lines(&boot(&["--summary", "--json"]));
    let of = |summary: &str| rows.iter().filter(|row| row["summary"] == summary).collect::<Vec<_>>();
    let [network] = of("network")[..] else { panic!("{rows:?}") };
    assert_eq!((&network["frames"], &network["verdict"]["state"]), (&json!(640), &json!("healthy")));
    assert_eq!((&network["cycle"]["socs"], &network["cycle"]["nominal"]), (&json!(41), &json!(0.02)));
    let [node, managing_node] = of("node")[..] else { panic!("{rows:?}") };
    assert_eq!((&node["node"], &node["nmt_state"]), (&json!(1), &json!("NMT_OPERATIONAL")));
    assert_eq!(
        node["losses"],
        json!({ "polls": 32, "pres_missing": 0, "pres_late": 0, "answers_missing": 0 })
    );
    assert_eq!(node["pres"]["count"], 31);
    let states: Vec<_> = node["states"].as_array().unwrap().iter().map(|state| state["n"].clone()).collect();
    assert_eq!(states, [113, 508, 518, 548]);
    assert_eq!(
        (&managing_node["node"], &managing_node["mac_address"]),
        (&json!(240), &json!("02-00-00-00-00-F0"))
    );
    let [sdo] = of("sdo")[..] else { panic!("{rows:?}") };
    assert_eq!((&sdo["writes"], &sdo["aborts"], &sdo["client"]), (&json!(17), &json!(2), &json!(240)));
    let objects: Vec<_> = of("sdo_abort").iter().map(|row| row["index"].clone()).collect();
    assert_eq!(objects, [0x1010, 0x1011]);
}

#[test]
fn every_frame_has_its_kind_and_none_a_problem() {
    let objects = json_lines(&boot(&["--json"]));
    let mut kinds = BTreeMap::new();
    for (object, n) in objects.iter().zip(1..) {
        *kinds.entry(object["kind"].as_str().unwrap()).or_insert(0) += 1;
        assert_eq!((&object["n"], &object["protocol"]), (&json!(n), &json!("powerlink")));
        assert_eq!(object.get("problem"), None, "{object}");
        assert_eq!(json!(object["data"].as_str().unwrap().len() / 2 + 14), object["length"]);
    }
    let expected = [
        ("asnd_ident_response", 2),
        ("asnd_nmt_command", 4),
        ("asnd_sdo", 56),
        ("asnd_status_response", 59),
        ("preq", 32),
        ("pres", 31),
        ("soa", 415),
        ("soc", 41),
    ];
    assert_eq!(kinds.into_iter().collect::<Vec<_>>(), expected);
    // Abort of the first write: 0x1011/1 "load".
    let (request, abort) = (&objects[137], &objects[142]);
    assert_eq!(request["value"], "6c6f6164");
    assert_eq!((&abort["request"]["n"], &abort["src"], &abort["dst"]), (&json!(138), &json!(1), &json!(240)));
    assert_eq!(
        abort["sdo"],
        json!({ "command": "WriteByIndex", "response": true, "transaction": 0, "index": 0x1011, "subindex": 1,
            "abort": 0x0602_0000, "abort_name": "object does not exist" })
    );
    let pres = &objects[547];
    assert_eq!((&pres["nmt_state"], &pres["flags"]), (&json!("NMT_OPERATIONAL"), &json!(["RD"])));
    assert_eq!((&pres["value"], &pres["request"]["n"]), (&json!("01"), &json!(547)));
    let command = &objects[387];
    assert_eq!((&command["nmt_command"], &command["dst"]), (&json!("NMTResetConfiguration"), &json!(1)));
}

#[test]
fn filters_take_node_ids_and_kinds() {
    let count = |options: &[&str]| stdout(&boot(options)).lines().count();
    assert_eq!(count(&["--kind", "preq,pres"]), 63);
    assert_eq!(count(&["--node", "1", "--kind", "asnd_nmt_command"]), 4, "to it and to all");
    assert_eq!(count(&["--mac", "0xF0", "--kind", "pres"]), 0);
    assert_eq!(count(&["--protocol", "powerlink", "--mac", "253", "--kind", "soa"]), {
        stdout(&boot(&[])).matches("IdentRequest for diagnostic device").count()
    });
    assert_eq!(count(&["--from", "1743ms", "--kind", "pres"]), 31);
}

#[test]
fn what_means_nothing_for_ethernet_is_refused() {
    for (options, told) in [
        (
            &["--bit-rate", "500k", "--summary"][..],
            "--bit-rate is for DeviceNet, and the frames are Ethernet POWERLINK",
        ),
        (&["--scanlist"], "--scanlist is for DeviceNet, and the frames are Ethernet POWERLINK"),
        (&["--record", "copy.pcapng"], "--record writes CAN frames, and these are Ethernet"),
        (
            &["--kind", "poll_command"],
            "--kind poll_command is for DeviceNet; those of Ethernet POWERLINK are soc, preq",
        ),
        (
            &["--protocol", "devicenet"],
            "link type 1 (Ethernet) instead of 227 (CAN_SOCKETCAN): capture on a CAN",
        ),
    ] {
        let output = boot(options);
        assert_exit(&output, 2);
        assert!(stderr(&output).contains(told), "{}", stderr(&output));
        assert_eq!(stdout(&output), "");
    }
    let log = run(&["decode", "--protocol", "powerlink", &capture("bei-mhk5-cos.log")]);
    assert_exit(&log, 2);
    assert!(
        stderr(&log).contains("a candump log: Ethernet frames are in pcap and pcapng"),
        "{}",
        stderr(&log)
    );
    let can = run(&["decode", "--protocol", "powerlink", &capture("socketcan.pcapng")]);
    assert!(
        stderr(&can).contains("link type 227 (CAN_SOCKETCAN) instead of 1 (Ethernet)"),
        "{}",
        stderr(&can)
    );
}

/// As `tshark -i any` makes them.
#[test]
fn a_capture_of_any_interface_is_told_how_to_be_made() {
    let mut bytes = std::fs::read(capture(BOOT)).unwrap();
    bytes[20] = 113;
    for options in [&[][..], &["--protocol", "powerlink"], &["--protocol", "devicenet"]] {
        let cooked = decode("cooked.pcap", &bytes, options);
        assert_exit(&cooked, 2);
        let told = "link type 113 (Linux cooked capture) instead of 227 (CAN_SOCKETCAN) or 1 (Ethernet): capture on the \
                    interface itself, for instance `tshark -i can0 -w FILE` or `tshark -i eth0 -w FILE`\n";
        assert!(stderr(&cooked).ends_with(told), "{}", stderr(&cooked));
    }
}

/// `tcpdump -s 40`: states and polls are followed, and what is missing is no problem.
#[test]
fn a_capture_of_the_beginnings_of_frames_is_healthy() {
    let bytes = std::fs::read(capture(BOOT)).unwrap();
    let (header, mut rest) = bytes.split_at(24);
    let mut cut = header.to_vec();
    while let Some((record, packets)) = rest.split_first_chunk::<16>() {
        let length = u32::from_le_bytes(record[8..12].try_into().unwrap());
        let kept = length.min(40);
        let (packet, others) = packets.split_at(length.try_into().unwrap());
        let kept_of = &packet[..kept.try_into().unwrap()];
        cut.extend([&record[..8], &kept.to_le_bytes(), &record[12..], kept_of].concat());
        rest = others;
    }
    let objects = json_lines(&decode("snap.pcap", &cut, &["--json"]));
    assert!(objects.iter().all(|object| object["kind"] != "invalid" && object.get("problem").is_none()));
    let status = objects.iter().find(|object| object["kind"] == "asnd_status_response").unwrap();
    assert_eq!(
        (&status["captured"], &status["length"], &status["nmt_state"], &status["note"]),
        (
            &json!(40),
            &json!(72),
            &json!("NMT_PRE_OPERATIONAL_1"),
            &json!("cut: the capture has 40 of its 72 bytes")
        )
    );
    assert_eq!(status["text"], "1 -> all  StatusResponse (cut: the capture has 40 of its 72 bytes)");
    let [short, whole] =
        [decode("snap.pcap", &cut, &["--summary", "--json"]), boot(&["--summary", "--json"])];
    let states = |output: &Output| -> Vec<Value> {
        json_lines(output)
            .into_iter()
            .filter(|row| row["summary"] == "node")
            .map(|row| row["states"].clone())
            .collect()
    };
    assert_eq!(states(&short), states(&whole));
}

/// What precedes the damage is decoded.
#[test]
fn a_damaged_capture_is_read_as_far_as_it_goes() {
    let bytes = std::fs::read(capture(BOOT)).unwrap();
    let cut = decode("cut.pcap", &bytes[..bytes.len() - 5], &[]);
    assert_exit(&cut, 2);
    assert_eq!(stdout(&cut).lines().count(), 639);
    assert!(
        stderr(&cut)
            .ends_with("cut off, or a length in it is wrong: it ends within the record after frame 639\n")
    );
    let garbage = decode("garbage.pcap", &[&bytes[..], &[0xFF; 16]].concat(), &[]);
    assert_exit(&garbage, 2);
    assert_eq!(stdout(&garbage).lines().count(), 640);
    assert!(stderr(&garbage).contains("damaged after frame 640: a record says that it has 4294967295 bytes"));
    // The length of the first packet: its end is taken for the next record.
    let mut wrong = bytes.clone();
    wrong[24 + 8] = 40;
    let wrong = decode("wrong.pcap", &wrong, &[]);
    assert!(stdout(&wrong).contains("(cut: the capture has 40 of its") || wrong.status.code() == Some(2));
}

/// What is wrong with the nodes is said of the network, too.
#[test]
fn a_summary_tells_which_errors_nodes_report() {
    let status = |entries: &[u8]| {
        let mut frame = hex("01111e00000402000000000188ab06ff010210005d000000");
        frame.extend([&[0; 8][..], entries, &[0; 40]].concat());
        frame.truncate(72);
        frame
    };
    // Loss of SoC occurred, loss of link is over.
    let lost =
        status(&[&[0x02, 0x30, 0x45, 0x82][..], &[0; 16], &[0x02, 0x20, 0x65, 0x81], &[0; 16]].concat());
    // NMTResetNode to node 1, reason 0x8243: frame 1017 of example.pcapng of thk1/powerlink_analyzer.
    let mut reset = hex("01111e000004ec086b1c248188ab0601f004280043820000");
    reset.resize(60, 0);
    let file = capture_of(&[&lost, &reset, &lost]);
    let summary = decode("reports.pcap", &file, &["--summary"]);
    assert_exit(&summary, 1);
    let table = "\
node  error                         told by              times  first frame  first time
   1  0x8245 loss of SoC threshold   the node                 2            1    0.000000 s
   1  0x8243 loss of PRes threshold  MN, which resets it      1            2    0.000000 s
";
    let squeezed = |text: &str| {
        text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ")).collect::<Vec<_>>()
    };
    let shown = squeezed(stdout(&summary));
    assert!(squeezed(table).iter().all(|row| shown.contains(row)), "{}", stdout(&summary));
    assert!(stdout(&summary).contains("verdict: 2 findings over\n"), "{}", stdout(&summary));
    let rows = json_lines(&decode("reports.pcap", &file, &["--summary", "--json"]));
    let errors: Vec<_> = rows.iter().filter(|row| row["summary"] == "error").collect();
    assert_eq!((&errors[0]["by"], &errors[0]["error"]), (&json!("node"), &json!(0x8245)));
    assert_eq!(
        (&errors[1]["by"], &errors[1]["error_name"], &errors[1]["count"], &errors[1]["first"]["n"]),
        (&json!("managing_node"), &json!("loss of PRes threshold"), &json!(1), &json!(2))
    );
}

/// pcap in microseconds, little-endian, link type 1, all at 0.
fn capture_of(frames: &[&[u8]]) -> Vec<u8> {
    let mut file = vec![0xD4, 0xC3, 0xB2, 0xA1, 2, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 4, 0, 1, 0, 0, 0];
    for frame in frames {
        let length = u32::try_from(frame.len()).unwrap().to_le_bytes();
        file.extend([&[0; 8][..], &length, &length, frame].concat());
    }
    file
}

fn hex(text: &str) -> Vec<u8> {
    (0..text.len()).step_by(2).map(|at| u8::from_str_radix(&text[at..at + 2], 16).unwrap()).collect()
}

/// A frame that ends too early, or has more than its fields say.
#[test]
fn damaged_frames_are_problems_with_their_place() {
    let mut buffer = [0; 64];
    let mut out = Writer::new(&mut buffer);
    // PReq to node 1 whose Size, 99, is more than the frame has.
    out.bytes(&[2, 0, 0, 0, 0, 1, 2, 0, 0, 0, 0, 0xF0, 0x88, 0xAB, 3, 1, 0xF0, 0, 0, 0, 0, 0, 99, 0])
        .unwrap();
    let file = capture_of(&[&buffer[..60], &buffer[..10], &buffer[..14], &buffer[..22]]);
    let output = decode("frames.pcap", &file, &[]);
    assert_exit(&output, 1);
    let lines: Vec<_> = stdout(&output).lines().map(|line| line.split_once(" | ").unwrap().1).collect();
    assert_eq!(
        lines,
        [
            "MN -> 1  POWERLINK, 46 bytes  ! process data at offset 24: 99 bytes expected, 36 found",
            "? -> ?  frame, 10 bytes  ! source MAC at offset 6: 6 bytes expected, 4 found",
            "02-00-00-00-00-F0 -> 02-00-00-00-00-01  frame, 14 bytes  ! POWERLINK header at offset 14: 3 bytes expected, 0 found",
            "MN -> 1  POWERLINK, 8 bytes  ! Size at offset 22: 2 bytes expected, 0 found",
        ]
    );
    let objects = json_lines(&decode("frames.pcap", &file, &["--json"]));
    assert!(
        objects.iter().all(|object| object["kind"] == "invalid" && object["problem_code"] == "malformed")
    );
    let summary = decode("frames.pcap", &file, &["--summary"]);
    assert_exit(&summary, 1);
    assert!(stdout(&summary).contains("verdict: 4 faulty frames\n"), "{}", stdout(&summary));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Whatever becomes of the bytes of a capture, all that can be read is read, and said in words.
    #[test]
    fn no_bytes_are_too_bad(
        changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..40),
        length in any::<prop::sample::Index>(),
    ) {
        let mut bytes = std::fs::read(capture(BOOT)).unwrap();
        let kept = length.index(bytes.len() + 1);
        changes.iter().for_each(|(at, byte)| { let at = at.index(bytes.len()); bytes[at] = *byte; });
        bytes.truncate(kept);
        let Ok(Opened::Ethernet(frames)) = Opened::from_reader(Cursor::new(bytes), None) else { return Ok(()) };
        let mut monitor = Box::new(SizedMonitor::<4, 64>::new());
        let (mut read, mut fatal) = (0, 0);
        for entry in frames {
            match entry {
                Ok(frame) => {
                    let captured = Captured { bytes: &frame.content.bytes, length: frame.content.length };
                    let reading = monitor.observe(frame.at, frame.n, captured);
                    prop_assert!(serde_json::to_string(&reading).unwrap().contains(r#""text":"#));
                    read += 1;
                }
                Err(error) => fatal += u64::from(error.is_fatal()),
            }
        }
        prop_assert!(read <= 640 && fatal <= 1);
    }
}

/// A pcapng file with a SoC on one interface and a CAN frame on another: which part is read is told, and how the other is.
#[test]
fn a_capture_of_ethernet_and_can_is_read_in_two_goes() {
    let mut soc = vec![1, 0x11, 0x1E, 0, 0, 1, 2, 0, 0, 0, 0, 0xF0, 0x88, 0xAB, 1, 255, 240];
    soc.resize(36, 0);
    let can = [0, 0, 4, 0x55, 0, 0, 0, 0];
    let bytes = pcapng::file(&[(1, &[]), (0xE3, &[])], &[(0, &soc), (1, &can)]);
    let left_out = "1 packet is of other interfaces than";
    let of_can = decode("both.pcapng", &bytes, &[]);
    assert_exit(&of_can, 0);
    let advice = "CAN, and left out; `devicenet decode --protocol powerlink` reads those of Ethernet";
    let file = temporary("both.pcapng");
    assert_eq!(stderr(&of_can), format!("note: {file}: {left_out} {advice}\n"));
    assert!(stdout(&of_can).contains("455") && !stdout(&of_can).contains("SoC"), "{}", stdout(&of_can));
    let of_ethernet = decode("both.pcapng", &bytes, &["--protocol", "powerlink"]);
    assert_exit(&of_ethernet, 0);
    let advice = "Ethernet, and left out; `devicenet decode --protocol devicenet` reads those of CAN";
    assert_eq!(stderr(&of_ethernet), format!("note: {file}: {left_out} {advice}\n"));
    assert!(stdout(&of_ethernet).contains("SoC") && stdout(&of_ethernet).lines().count() == 1);
}
