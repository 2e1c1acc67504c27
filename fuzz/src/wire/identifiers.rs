//! The identifiers of DeviceNeX: taken apart and built again, and what is told in identifier and data.

use devicenex_core::Identifier;
use devicenex_core::message::{Hello, MiniWho, Roam};
use link_core::Frame;
use link_core::frame::{extended_id, standard_id};

/// Takes the first four bytes for an identifier and the rest for data.
pub(super) fn check(data: &[u8]) {
    let Some((head, rest)) = data.split_first_chunk::<4>() else { return };
    let raw = u32::from_be_bytes(*head);
    let rest = &rest[..rest.len().min(Frame::MAX_DATA)];
    frame(&Frame::new(extended_id(raw), rest).unwrap());
    frame(&Frame::new(standard_id(raw as u16), rest).unwrap());
    frame(&Frame::remote(extended_id(raw), (raw >> 29) as u8).unwrap());
}

fn frame(frame: &Frame) {
    let id = Identifier::of_frame(frame);
    assert_eq!(id.layout().identifier(), Some(id), "{:?}", id.layout());
    assert!(!id.layout().to_string().is_empty());
    let kinds = [
        Hello::of_frame(frame).is_some(),
        Roam::of_frame(frame).is_some(),
        MiniWho::of_frame(frame).is_some(),
    ];
    assert!(kinds.iter().filter(|&&kind| kind).count() <= 1, "{frame} is {kinds:?}");
    if let Some(Ok(hello)) = Hello::of_frame(frame) {
        assert_eq!(hello.frame().as_ref(), Some(frame), "{hello}");
    }
    if let Some(Ok(roam)) = Roam::of_frame(frame) {
        assert_eq!(roam.frame().as_ref(), Some(frame), "{roam}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of the paper's figure 3 and of figure 6.
    #[test]
    fn a_hello_and_a_roam_are_what_they_were() {
        for id in [0x1FFE_4433_u32, 0x1EFE_4433] {
            let data = [&id.to_be_bytes()[..], &[0x22, 0x11, 0x23, 0x01, 0x56, 0x04, 0x02, 0x43]].concat();
            check(&data);
        }
        check(&[]);
    }
}
