//! Which protocol a recording is decoded as, where the command line leaves it open.
//!
//! Both protocols share the bus format and neither names itself, so the first frames are held back until one of them tells:
//! a Hello, Mini-who or ROAM, a request for a connection and a connectionless Get_Attribute_Single are DeviceNeX's; a duplicate
//! MAC ID check, an allocation and an opening of a connection are DeviceNet's. I/O alone tells nothing: without more in the first
//! frames it is DeviceNeX if all identifiers have 29 bits and none is reserved there, else DeviceNet. What comes on standard
//! input may be live, and every frame is shown when it comes: there the first frame decides.

use core::fmt;

use devicenet_core::id::Purpose;
use devicenex_core::id::{Direction, Framing, Layout};
use devicenex_core::message::{ConnectionRequest, ConnectionlessRequest, Hello, MiniWho, Roam, Wire as _};
use link_core::Frame;

use crate::args::{DecodeArgs, Protocol};
use crate::recording::{Content, RecordedFrame};

/// A protocol that is decoded.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Spoken {
    /// DeviceNet.
    #[default]
    DeviceNet,
    /// DeviceNeX.
    DeviceNex,
}

/// Listens to the first frames of a recording, and keeps them.
pub(super) struct Ear {
    held: Vec<RecordedFrame>,
    /// Frames that are held back at most.
    most: usize,
    extended: usize,
    /// Of them, those that DeviceNeX does not use.
    reserved: usize,
    standard: usize,
}

/// What was heard, and why it is taken for that.
pub(super) struct Heard {
    pub(super) spoken: Spoken,
    pub(super) why: Why,
    /// The frames so far.
    pub(super) held: Vec<RecordedFrame>,
}

/// What tells the protocol.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Why {
    /// A frame that only this protocol has.
    Frame(u64, &'static str),
    /// How long the identifiers of the first frames are.
    Identifiers,
}

impl Spoken {
    /// What the command line says; `None` if the recording has to.
    pub(super) fn of(args: &DecodeArgs) -> Option<Self> {
        match args.protocol {
            Protocol::Devicenet => Some(Self::DeviceNet),
            Protocol::Devicenex => Some(Self::DeviceNex),
            // A number that only an operational address can be, and options that are for DeviceNet only.
            Protocol::Auto if args.mac.is_some_and(|mac| mac > LAST_MAC_ID) => Some(Self::DeviceNex),
            Protocol::Auto if args.scanlist || args.expect.is_some() || !args.eds.is_empty() => {
                Some(Self::DeviceNet)
            }
            Protocol::Auto | Protocol::Powerlink => None,
        }
    }
}

impl fmt::Display for Spoken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::DeviceNet => "DeviceNet",
            Self::DeviceNex => "DeviceNeX",
        })
    }
}

impl Ear {
    pub(super) fn new(is_live: bool) -> Self {
        let most = if is_live { 1 } else { MOST };
        Self { held: Vec::new(), most, extended: 0, reserved: 0, standard: 0 }
    }

    /// Takes a frame; afterwards whether it is clear what is spoken.
    pub(super) fn hear(&mut self, frame: RecordedFrame) -> Option<(Spoken, Why)> {
        let n = frame.n;
        let told = match &frame.content {
            Content::Classic(classic) => self.told_by(classic),
            Content::Error(_) | Content::Fd(_) => None,
        };
        self.held.push(frame);
        if let Some((spoken, what)) = told {
            return Some((spoken, Why::Frame(n, what)));
        }
        (self.held.len() >= self.most).then(|| self.guess())
    }

    /// What is most likely.
    pub(super) fn guess(&self) -> (Spoken, Why) {
        let is_nex = self.extended > 0 && self.reserved == 0 && self.standard == 0;
        (if is_nex { Spoken::DeviceNex } else { Spoken::DeviceNet }, Why::Identifiers)
    }

    /// What was heard, as it is decided.
    pub(super) fn decided(self, (spoken, why): (Spoken, Why)) -> Heard {
        Heard { spoken, why, held: self.held }
    }

    fn told_by(&mut self, frame: &Frame) -> Option<(Spoken, &'static str)> {
        if frame.is_extended() {
            self.extended += 1;
            let layout = devicenex_core::Identifier::of_frame(frame).layout();
            self.reserved += usize::from(matches!(layout, Layout::Reserved(_)));
            return Some((Spoken::DeviceNex, nex(frame, layout)?));
        }
        self.standard += 1;
        Some((Spoken::DeviceNet, net(frame)?))
    }
}

/// What only DeviceNeX has.
fn nex(frame: &Frame, layout: Layout) -> Option<&'static str> {
    let data = frame.data();
    if MiniWho::of_frame(frame).is_some() {
        return Some("a Mini-who");
    }
    if matches!(Hello::of_frame(frame), Some(Ok(_))) {
        return Some("a Hello");
    }
    if matches!(Roam::of_frame(frame), Some(Ok(roam)) if !roam.requested.is_none()) {
        return Some("a ROAM");
    }
    match layout {
        Layout::Connection { route, .. } if route.direction == Direction::Request => {
            ConnectionRequest::parse(data).is_ok().then_some("a connection request")
        }
        Layout::Connectionless { route, framing: Framing::Complete { .. } }
            if route.direction == Direction::Request =>
        {
            ConnectionlessRequest::parse(data).is_ok().then_some("a connectionless request")
        }
        _ => None,
    }
}

/// What only DeviceNet has.
fn net(frame: &Frame) -> Option<&'static str> {
    let purpose = devicenet_core::Identifier::of_frame(frame)?.purpose();
    match (purpose, frame.data()) {
        (Purpose::DuplicateMacCheck, [direction, _, _, _, _, _, _]) if direction & 0x7F <= 1 => {
            Some("a duplicate MAC ID check")
        }
        (Purpose::Group2UnconnectedRequest, [_, 0x4B | 0x4C, 0x03, 0x01, ..]) => {
            Some("an allocation or release")
        }
        (Purpose::UnconnectedRequest, [_, 0x4B | 0x4C, ..]) => {
            Some("the opening or closing of a connection by UCMM")
        }
        _ => None,
    }
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Frame(n, what) => write!(f, "frame {n} is {what}"),
            Self::Identifiers => f.write_str("the first frames have 29-bit identifiers"),
        }
    }
}

/// Frames of a file that are held back at most.
const MOST: usize = 64;
/// Of DeviceNet.
const LAST_MAC_ID: u8 = 63;

#[cfg(test)]
mod tests {
    use super::*;
    use link_core::Instant;
    use link_core::frame::{extended_id, standard_id};

    /// The protocol of a recording with a frame every 10 ms, and how many frames it took.
    fn heard(frames: &[Frame]) -> (Spoken, Why, usize) {
        let mut ear = Ear::new(false);
        for (n, frame) in (1..).zip(frames) {
            let content = Content::Classic(*frame);
            let at = Instant::from_millis(10 * n);
            if let Some((spoken, why)) = ear.hear(RecordedFrame { n, at, digits: 6, channel: None, content })
            {
                return (spoken, why, ear.held.len());
            }
        }
        let (spoken, why) = ear.guess();
        (spoken, why, ear.held.len())
    }

    fn extended(id: u32, data: &[u8]) -> Frame {
        Frame::new(extended_id(id), data).unwrap()
    }

    fn standard(id: u16, data: &[u8]) -> Frame {
        Frame::new(standard_id(id), data).unwrap()
    }

    #[test]
    fn a_frame_that_one_protocol_has_decides() {
        let io = standard(0x3C5, &[1, 2]);
        let hello = extended(0x1FFE_4433, &[0x22, 0x11, 0x23, 0x01, 0x56, 0x04, 0x02, 0x00]);
        for (frame, spoken, what) in [
            (hello, Spoken::DeviceNex, "a Hello"),
            (Frame::remote(extended_id(0x1FFE_0100), 8).unwrap(), Spoken::DeviceNex, "a Mini-who"),
            (
                extended(0x1EFE_4433, &[0x22, 0x11, 0x23, 0x01, 0x56, 0x04, 0x02, 0x43]),
                Spoken::DeviceNex,
                "a ROAM",
            ),
            (
                extended(0x1D86_0209, &[0x4B, 0xC0, 0x07, 0, 0xF4, 1, 2]),
                Spoken::DeviceNex,
                "a connection request",
            ),
            (extended(0x1C86_0209, &[0x0E, 1, 1, 1]), Spoken::DeviceNex, "a connectionless request"),
            (standard(0x457, &[0, 0x34, 0x12, 1, 0, 0, 0]), Spoken::DeviceNet, "a duplicate MAC ID check"),
            (standard(0x456, &[1, 0x4B, 3, 1, 3, 1]), Spoken::DeviceNet, "an allocation or release"),
            (
                standard(0x782, &[10, 0x4B, 0, 0x31]),
                Spoken::DeviceNet,
                "the opening or closing of a connection by UCMM",
            ),
        ] {
            assert_eq!(heard(&[io, frame, io]), (spoken, Why::Frame(2, what), 2));
        }
    }

    #[test]
    fn without_one_the_identifiers_do() {
        let (own, other) = (extended(0x0286_0007, &[1]), extended(0x18FE_F1FE, &[1]));
        let io = standard(0x3C5, &[1, 2]);
        for (frames, spoken) in [
            (&[own, own][..], Spoken::DeviceNex),
            (&[own, other], Spoken::DeviceNet),
            (&[own, io], Spoken::DeviceNet),
            (&[io], Spoken::DeviceNet),
            (&[], Spoken::DeviceNet),
        ] {
            assert_eq!(heard(frames), (spoken, Why::Identifiers, frames.len()), "{frames:?}");
        }
        // Not for ever.
        assert_eq!(heard(&[io; 100]).2, MOST);
    }
}
