//! The log form of candump (`-l`, `-L`).
//!
//! | part | form |
//! |---|---|
//! | time | `(1700000000.000000)` |
//! | interface | `can0` |
//! | identifier | 3 hexadecimal digits: 11 bits; more: 29 bits; with bit 29 set: the class of an error frame |
//! | data | `#014B03010301`, also with dots between bytes, upper or lower case |
//! | data length code above 8 | `#0001020304050607_9` |
//! | remote frame | `#R`, `#R5`, `#R8_9` |
//! | CAN FD | `##` and a digit (1 bit rate switch, 2 error-passive), then the data |
//! | direction (`-x`) | ` R`, ` T` at the end, ignored |
//!
//! Source: can-utils, `lib.h`.

use link_core::{Frame, Id};

use super::Parsed;
use super::error::Fault;
use super::frame::{Channels, Content, ErrorFrame, FdFrame};
use super::scan::{CanId, Scanner};

/// Reads one line.
#[inline]
pub(super) fn parse(line: &[u8], channels: &mut Channels) -> Result<Parsed, Fault> {
    let mut scan = Scanner::new(line);
    scan.skip_blanks();
    scan.expect(b'(', "\"(\" and a time")?;
    let (at, digits) = scan.seconds()?;
    scan.expect(b')', "\")\" after the time")?;
    scan.skip_blanks();
    let interface = scan;
    let name = scan.word();
    if name.is_empty() {
        return Err(scan.fault("an interface name"));
    }
    scan.skip_blanks();
    let id = scan.can_id()?;
    scan.expect(b'#', "\"#\" after the identifier")?;
    let content = match id {
        CanId::Frame { id, .. } if scan.eat(b'#') => fd(&mut scan, id)?,
        CanId::Frame { id, remote } => classic(&mut scan, id, remote)?,
        CanId::Error { class } => {
            let (data, _) = bytes::<{ Frame::MAX_DATA }>(&mut scan)?;
            Content::Error(ErrorFrame { class, data })
        }
    };
    end(scan)?;
    // Only a whole line may name a channel: what is left of a damaged one is no bus.
    let channel = channels.intern(name).ok_or_else(|| interface.fault(Channels::LIMIT))?;
    Ok(Parsed { at, digits, channel: Some(channel), content })
}

#[inline]
fn classic(scan: &mut Scanner<'_>, id: Id, remote: bool) -> Result<Content, Fault> {
    if remote || matches!(scan.peek(), Some(b'R' | b'r')) {
        return remote_frame(scan, id);
    }
    let start = *scan;
    let (data, length) = bytes::<{ Frame::MAX_DATA }>(scan)?;
    let frame = match scan.peek() {
        Some(b'_') if length == Frame::MAX_DATA => Frame::with_dlc(id, raw_dlc(scan)?, data),
        _ => Frame::new(id, &data[..length]),
    };
    frame.map(Content::Classic).ok_or_else(|| start.fault("at most 8 bytes"))
}

#[cold]
fn remote_frame(scan: &mut Scanner<'_>, id: Id) -> Result<Content, Fault> {
    let start = *scan;
    let _ = scan.eat(b'R') || scan.eat(b'r');
    let mut dlc = scan.hex_digit().unwrap_or(0);
    if dlc == 8 && scan.peek() == Some(b'_') {
        dlc = raw_dlc(scan)?;
    }
    Frame::remote(id, dlc).map(Content::Classic).ok_or_else(|| start.fault("a remote frame"))
}

fn raw_dlc(scan: &mut Scanner<'_>) -> Result<u8, Fault> {
    scan.expect(b'_', "\"_\"")?;
    let start = *scan;
    scan.hex_digit().filter(|dlc| *dlc >= 8).ok_or_else(|| start.fault("a data length code, 8 to F"))
}

#[cold]
fn fd(scan: &mut Scanner<'_>, id: Id) -> Result<Content, Fault> {
    let flags =
        scan.hex_digit().ok_or_else(|| scan.fault("the flags of a CAN FD frame, a hexadecimal digit"))?;
    let start = *scan;
    let (data, length) = bytes::<{ FdFrame::MAX_DATA }>(scan)?;
    let frame = FdFrame::new(id, &data[..length], flags & 1 != 0, flags & 2 != 0);
    let frame = frame.ok_or_else(|| start.fault("0 to 8, 12, 16, 20, 24, 32, 48 or 64 bytes"))?;
    Ok(Content::Fd(Box::new(frame)))
}

/// At most `MAX` bytes in hexadecimal, which may be apart by dots.
#[inline]
fn bytes<const MAX: usize>(scan: &mut Scanner<'_>) -> Result<([u8; MAX], usize), Fault> {
    let mut data = [0; MAX];
    let mut length = 0;
    loop {
        let start = *scan;
        let dot = length > 0 && scan.eat(b'.');
        let Some(byte) = scan.hex_byte() else {
            return match scan.peek() {
                None | Some(b' ' | b'\t' | b'_') if !dot => Ok((data, length)),
                _ => Err(scan.fault("two hexadecimal digits")),
            };
        };
        *data.get_mut(length).ok_or_else(|| start.fault("the end of the data"))? = byte;
        length += 1;
    }
}

/// Nothing but the direction flags of `candump -x`.
#[inline]
fn end(mut scan: Scanner<'_>) -> Result<(), Fault> {
    while scan.peek().is_some() {
        scan.skip_blanks();
        let start = scan;
        if !scan.word().iter().all(|byte| matches!(byte, b'R' | b'T' | b'B' | b'E' | b'-')) {
            return Err(start.fault("the end of the line"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use link_core::Instant;
    use link_core::frame::{extended_id, standard_id};

    fn read(line: &str) -> Content {
        parse(format!("(1700000000.000100) can0 {line}").as_bytes(), &mut Channels::default())
            .unwrap()
            .content
    }

    fn fault(line: &str) -> (usize, &'static str) {
        let Err(fault) = parse(line.as_bytes(), &mut Channels::default()) else { panic!("{line} is read") };
        (fault.at + 1, fault.expected)
    }

    #[test]
    fn reads_every_form_of_a_frame() {
        let poll = standard_id(0x455);
        let data = |id, bytes: &[u8]| Content::Classic(Frame::new(id, bytes).unwrap());
        assert_eq!(read("455#"), data(Id::Standard(poll), &[]));
        assert_eq!(read("455#0a1B"), data(Id::Standard(poll), &[0x0A, 0x1B]));
        assert_eq!(read("455#0a.1B R"), data(Id::Standard(poll), &[0x0A, 0x1B]));
        assert_eq!(read("00000455#11"), data(Id::Extended(extended_id(0x455)), &[0x11]));
        assert_eq!(read("98FEF1FE#11"), data(Id::Extended(extended_id(0x18FE_F1FE)), &[0x11]));
        let remote = |dlc| Content::Classic(Frame::remote(poll, dlc).unwrap());
        assert_eq!(read("455#R"), remote(0));
        assert_eq!(read("455#R5"), remote(5));
        assert_eq!(read("455#RA"), remote(10));
        assert_eq!(read("455#R8_E"), remote(14));
        let eight = [0, 1, 2, 3, 4, 5, 6, 7];
        let long = Frame::with_dlc(poll, 9, eight).unwrap();
        assert_eq!(read("455#0001020304050607_9"), Content::Classic(long));
        let error = ErrorFrame { class: 4, data: [0, 4, 0, 0, 0, 0, 0, 0] };
        assert_eq!(read("20000004#0004000000000000"), Content::Error(error));
        let fd = FdFrame::new(Id::Standard(poll), &[7; 12], true, false).unwrap();
        assert_eq!(read("455##1070707070707070707070707"), Content::Fd(Box::new(fd)));
    }

    #[test]
    fn keeps_the_time_to_the_last_digit() {
        let mut channels = Channels::default();
        let parsed = parse(b"(1700000000.123456789) vcan12 123#", &mut channels).unwrap();
        assert_eq!((parsed.at, parsed.digits), (Instant::from_nanos(1_700_000_000_123_456_789), 9));
        assert_eq!(channels.name(parsed.channel.unwrap()), "vcan12");
    }

    #[test]
    fn says_where_a_line_goes_wrong() {
        assert_eq!(fault("hello"), (1, "\"(\" and a time"));
        assert_eq!(fault("(abc) can0 123#"), (2, "a time in seconds"));
        assert_eq!(fault("(99999999999.0) can0 123#"), (2, "a time in seconds"));
        assert_eq!(fault("(1.0"), (5, "\")\" after the time"));
        assert_eq!(fault("(1.0) "), (7, "an interface name"));
        assert_eq!(fault("(1.0) can0 XYZ#"), (12, "an identifier in hexadecimal"));
        assert_eq!(fault("(1.0) can0 800#"), (12, "an 11-bit identifier, 000 to 7FF"));
        assert_eq!(fault("(1.0) can0 123"), (15, "\"#\" after the identifier"));
        assert_eq!(fault("(1.0) can0 123#0"), (16, "two hexadecimal digits"));
        assert_eq!(fault("(1.0) can0 123#00.G1"), (19, "two hexadecimal digits"));
        assert_eq!(fault("(1.0) can0 123#000102030405060708"), (32, "the end of the data"));
        assert_eq!(fault("(1.0) can0 123#00_9"), (18, "the end of the line"));
        assert_eq!(fault("(1.0) can0 123#R5_E"), (18, "the end of the line"));
        assert_eq!(fault("(1.0) can0 123#0001020304050607_7"), (33, "a data length code, 8 to F"));
        assert_eq!(fault("(1.0) can0 123##"), (17, "the flags of a CAN FD frame, a hexadecimal digit"));
        assert_eq!(
            fault("(1.0) can0 123##0000102030405060708"),
            (18, "0 to 8, 12, 16, 20, 24, 32, 48 or 64 bytes")
        );
    }
}
