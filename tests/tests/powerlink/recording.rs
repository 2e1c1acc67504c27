//! A recording of Ethernet frames.

use std::fs::File;

use link_core::Instant;
use pcap_file::pcap::PcapReader;

/// Every frame of a recording in `tests/captures/powerlink`, with its time since the first.
pub(crate) fn frames(name: &str) -> Vec<(Instant, Vec<u8>)> {
    let path = devicenet_tests::workspace_root().join("tests/captures/powerlink").join(name);
    let mut reader = PcapReader::new(File::open(path).unwrap()).unwrap();
    let mut first = None;
    let mut frames = Vec::new();
    while let Some(packet) = reader.next_packet() {
        let packet = packet.unwrap();
        let begin = *first.get_or_insert(packet.timestamp);
        frames.push((Instant::ZERO + (packet.timestamp - begin), packet.data.into_owned()));
    }
    frames
}
