//! Two recordings of a Group 2 only slave published in 1998: what it was sent goes to ours, and ours answers the same, byte
//! for byte, but for the differences that are listed here. Times are those at which a frame was asked for, in whole milliseconds; they
//! were measured to 0.3 ms.

use core::time::Duration;

use cip_core::code::{DeviceType, VendorId};
use cip_core::identity::{DeviceIdentity, ProductName, Revision};
use devicenet_cli::recording::{Content, Recording};
use devicenet_core::MacId;
use devicenet_core::slave::{Config, Options, Slave};
use devicenet_tests::block::Block;
use devicenet_tests::notation::frame;
use link_core::{BitRate, Instant};

use crate::bus::Bus;
use crate::host::Host;

/// What it sent, and what ours sends instead.
struct Difference {
    recorded: &'static str,
    ours: &'static str,
    #[expect(dead_code, reason = "for who reads this")]
    why: &'static str,
}

#[test]
fn a_start_up_and_poll() {
    assert_eq!(differences("slave-01-startup-poll"), Vec::<(String, String)>::new());
}

#[test]
fn a_name_in_fragments() {
    let listed: Vec<_> = FRAGMENTS.iter().map(|one| (one.recorded.to_owned(), one.ours.to_owned())).collect();
    assert_eq!(differences("slave-04-fragmented-response"), listed);
}

const FRAGMENTS: [Difference; 4] = [
    Difference {
        recorded: "6880 453: 81 41 01 8E 0F 57 45 41",
        ours: "",
        why: "it was told \"too much data\", and goes on at the next acknowledge: its mistake",
    },
    Difference {
        recorded: "8050 453: 81 00 8E 0F 57 45 41 54",
        ours: "8080 453: 81 00 8E 0F 57 45 41 54",
        why: "it measures the second in steps of 50 ms",
    },
    Difference {
        recorded: "11080 453: 81 41 01 8E 0F 57 45 41",
        ours: "",
        why: "it had given up the response, and goes on at a late acknowledge: its mistake",
    },
    Difference {
        recorded: "11560 453: C1 41 48 45 52 20 53 54",
        ours: "11560 453: 81 41 48 45 52 20 53 54",
        why: "it copies the transaction ID of an acknowledge; ours keeps that of the request",
    },
];

/// Frames that only one of the two sends, in pairs of one moment.
fn differences(name: &str) -> Vec<(String, String)> {
    let path = |kind: &str| format!("{}/captures/{name}.{kind}", env!("CARGO_MANIFEST_DIR"));
    let recording = Recording::open(path("log").as_ref()).expect("the recording is there");
    let mut recorded = Vec::new();
    for frame in recording.map(|frame| frame.expect("it is whole")) {
        let Content::Classic(content) = frame.content else { continue };
        // Requests of the master are in the other file too.
        if [0x457, 0x453, 0x3CA].contains(&content.raw_id()) {
            let since = frame.at.saturating_since(Instant::from_millis(1_700_000_000_000));
            recorded.push(line(since, &content.to_string()));
        }
    }
    let ours = answers(&std::fs::read_to_string(path("stim")).expect("what it was sent"));
    let mut differences = Vec::new();
    let mut rest = ours.iter().peekable();
    for theirs in recorded {
        if rest.next_if_eq(&&theirs).is_some() {
            continue;
        }
        let similar = rest.next_if(|ours| ours[ours.len() - 8..] == theirs[theirs.len() - 8..]);
        differences.push((theirs, similar.cloned().unwrap_or_default()));
    }
    differences.extend(rest.map(|ours| (String::new(), ours.clone())));
    differences
}

/// What our slave sends. It has power when the other one had ended its self-test.
fn answers(stimulus: &str) -> Vec<String> {
    let device = DeviceIdentity {
        vendor: VendorId(0x1234),
        device_type: DeviceType::GENERIC,
        product_code: 1,
        revision: Revision::new(1, 1).expect("not zero"),
        serial: 0x2345,
        name: ProductName::new("WEATHER STATION").expect("short"),
    };
    let mut config = Config::new(&device, MacId::new(10).expect("a MAC ID"));
    config.options.insert(Options::READ_NON_EXISTENT_STATE);
    let slave =
        Slave::<_, 64, 0>::new(config, Block::<3, 0>::new(device, [0x03, 0x6B, 0x00])).expect("valid sizes");
    let mut bus = Bus::new(BitRate::K500, Host::new(slave), ["1".to_owned()]);
    bus.run_until(Instant::from_millis(2500));
    bus.up();
    for line in stimulus.lines().filter(|line| !line.starts_with('#')) {
        let (millis, what) = line.split_once(' ').expect("a time and a frame");
        let end = Instant::from_millis(millis.parse().expect("milliseconds"));
        let Some((id, data)) = what.split_once('#') else {
            bus.run_until(end);
            continue;
        };
        let data: Vec<_> = data.as_bytes().chunks(2).map(String::from_utf8_lossy).collect();
        let heard = frame(&format!("{id}: {}", data.join(" ")));
        bus.run_until(bus.begin_of(&heard, end));
        bus.sends("1", heard);
    }
    bus.all_sent()
        .iter()
        .map(|sent| line(sent.asked.saturating_since(Instant::ZERO), &sent.frame.to_string()))
        .collect()
}

/// Milliseconds since power-up, then the frame.
fn line(since: Duration, frame: &str) -> String {
    let (id, rest) = frame.split_once(" [").expect("an identifier");
    let data = rest.split_once(']').map_or("", |(_, data)| data);
    format!("{} {id}:{data}", since.as_millis())
}
