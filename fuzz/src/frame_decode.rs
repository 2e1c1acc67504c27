//! Any single frame: its identifier, and a decoder that has seen nothing before it.

use arbitrary::Unstructured;
use devicenet_core::id::MessageGroup;
use devicenet_core::monitor::{Monitor, MonitorConfig};
use devicenet_core::{Identifier, MacId};
use link_core::{Frame, Instant};

use crate::{input, readings};

/// Decodes one frame.
pub fn run(data: &[u8]) {
    let Ok(frame) = input::frame(&mut Unstructured::new(data)) else { return };
    assert!(!frame.to_string().is_empty());
    if let Some(id) = Identifier::of_frame(&frame) {
        identifier(id, &frame);
    }
    let mut monitor = Monitor::new(MonitorConfig::default());
    let reading = monitor.observe(Instant::ZERO, 1, &frame);
    readings::judge(&reading, &frame);
    assert!(reading.request.is_none() && reading.message.is_none(), "nothing came before {reading}");
    assert!(monitor.nodes().count() <= MacId::COUNT);
    assert!(monitor.connections().all(|connection| connection.frames <= 1));
}

/// An identifier is rebuilt from its parts, and is used as they say.
fn identifier(id: Identifier, frame: &Frame) {
    assert_eq!(u32::from(id.raw()), frame.raw_id());
    let rebuilt = match (id.group(), id.mac_id()) {
        (MessageGroup::Group1, Some(mac)) => Identifier::group1(id.message_id(), mac),
        (MessageGroup::Group2, Some(mac)) => Identifier::group2(mac, id.message_id()),
        (MessageGroup::Group3, Some(mac)) => Identifier::group3(id.message_id(), mac),
        (MessageGroup::Group4, None) => Identifier::group4(id.message_id()),
        (MessageGroup::Invalid, None) => Identifier::new(0x7F0 | u16::from(id.message_id())),
        parts => panic!("{parts:?} of {id:?}"),
    };
    assert_eq!(rebuilt, Some(id));
    assert_eq!(id.purpose().mac_id_role().is_some(), id.mac_id().is_some(), "{id}");
    assert!(!id.to_string().is_empty() && !id.purpose().to_string().is_empty());
    // A frame keeps its DLC only up to eight.
    if frame.dlc() <= 8 {
        assert_eq!(id.frame(frame.data()), Some(*frame));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use link_core::frame::{extended_id, standard_id};

    #[test]
    fn frames_of_all_kinds_are_decoded() {
        for frame in [
            Frame::new(standard_id(0x40F), &[0x00, 0x08, 0x00, 0x06, 0xF5, 0x89, 0x12]).unwrap(),
            Frame::with_dlc(standard_id(0x44C), 15, [0x0A, 0x10, 5, 4, 9, 0x0A, 0x0E, 0]).unwrap(),
            Frame::remote(standard_id(0x3C5), 3).unwrap(),
            Frame::new(extended_id(0x1234), &[1]).unwrap(),
            Frame::new(standard_id(0x7F3), &[]).unwrap(),
        ] {
            run(&input::frame_bytes(&frame));
        }
    }
}
