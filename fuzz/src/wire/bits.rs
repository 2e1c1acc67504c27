//! A frame and its bits, against a receiver of our own that knows nothing of how `link-core` sends.

use arbitrary::{Result, Unstructured};
use link_core::frame::{extended_id, standard_id};
use link_core::{Frame, wire};

use crate::input;

/// Reads two frames and checks the bits of each, and which of the two wins arbitration.
pub(super) fn check(input: &mut Unstructured<'_>) -> Result<()> {
    let (one, other) = (input::frame(input)?, input::frame(input)?);
    let (one_sent, other_sent) = (sent(&one), sent(&other));
    check_frame(&one, &one_sent);
    check_frame(&other, &other_sent);
    check_arbitration((&one, &one_sent), (&other, &other_sent));
    Ok(())
}

fn sent(frame: &Frame) -> Vec<bool> {
    wire::bits(frame).map(|bit| bit.recessive).collect()
}

fn check_frame(frame: &Frame, sent: &[bool]) {
    assert_eq!(frame.bit_len() as usize, sent.len(), "bit_len of {frame}");
    assert_eq!(received(sent), Ok(*frame), "{frame} as received");
    assert!(wire::bits(frame).is_sorted_by_key(|bit| bit.field), "the fields of {frame} are in order");
}

/// The first bit in which two senders differ decides: the dominant one goes on.
fn check_arbitration((one, one_sent): (&Frame, &[bool]), (other, other_sent): (&Frame, &[bool])) {
    let Some(at) = one_sent.iter().zip(other_sent).position(|(one, other)| one != other) else {
        assert_eq!(one, other, "different frames differ in a bit");
        return;
    };
    let arbitration_end = wire::bits(one).position(|bit| bit.field > wire::Field::Arbitration).unwrap();
    if at < arbitration_end {
        assert_eq!(
            one.arbitration_key() < other.arbitration_key(),
            other_sent[at],
            "bit {at} decides between {one} and {other}"
        );
    } else {
        assert_eq!(
            one.arbitration_key(),
            other.arbitration_key(),
            "nothing decides between {one} and {other}"
        );
    }
}

/// Receives a frame from its bits: destuffing, fields, CRC and the fixed bits at the end (Bosch CAN 2.0, 3.1).
fn received(sent: &[bool]) -> Result<Frame, &'static str> {
    let mut line = Line { bits: sent.iter().copied(), crc: 0, run: 0, last: true };
    if line.number(1)? != 0 {
        return Err("start of frame");
    }
    let base = line.number(11)?;
    let (mut remote, extended) = (line.number(1)? == 1, line.number(1)? == 1);
    let id = if extended {
        if !remote {
            return Err("SRR");
        }
        let extension = line.number(18)?;
        remote = line.number(1)? == 1;
        if line.number(1)? != 0 {
            return Err("r1");
        }
        link_core::Id::Extended(extended_id(base << 18 | extension))
    } else {
        link_core::Id::Standard(standard_id(base as u16))
    };
    if line.number(1)? != 0 {
        return Err("r0");
    }
    let dlc = line.number(4)? as u8;
    let mut data = [0; 8];
    let len = if remote { 0 } else { usize::from(dlc).min(8) };
    for byte in &mut data[..len] {
        *byte = line.number(8)? as u8;
    }
    let expected = line.crc;
    if line.number(15)? != u32::from(expected) {
        return Err("CRC");
    }
    line.stuff_bit()?;
    if line.bits.len() != 10 || line.bits.any(|recessive| !recessive) {
        return Err("delimiters and end of frame");
    }
    let frame = if remote {
        Frame::remote(id, dlc)
    } else if dlc > 8 {
        Frame::with_dlc(id, dlc, data)
    } else {
        Frame::new(id, &data[..len])
    };
    frame.ok_or("frame")
}

/// The line as a receiver samples it: stuff bits taken out, the CRC of what came so far.
struct Line<I> {
    bits: I,
    crc: u16,
    run: u32,
    last: bool,
}

impl<I: Iterator<Item = bool>> Line<I> {
    fn number(&mut self, len: u32) -> Result<u32, &'static str> {
        (0..len).try_fold(0, |number, _| Ok(number << 1 | u32::from(self.bit()?)))
    }

    fn bit(&mut self) -> Result<bool, &'static str> {
        self.stuff_bit()?;
        let bit = self.sample()?;
        let feedback = bit != (self.crc >> 14 & 1 == 1);
        self.crc = (self.crc << 1 & 0x7FFF) ^ if feedback { 0x4599 } else { 0 };
        Ok(bit)
    }

    /// Takes the bit that follows five equal ones, and must differ.
    fn stuff_bit(&mut self) -> Result<(), &'static str> {
        let before = self.last;
        if self.run == 5 && self.sample()? == before { Err("stuff error") } else { Ok(()) }
    }

    fn sample(&mut self) -> Result<bool, &'static str> {
        let bit = self.bits.next().ok_or("the bits end")?;
        self.run = if bit == self.last && self.run > 0 { self.run + 1 } else { 1 };
        self.last = bit;
        Ok(bit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flipped_bit_is_an_error_or_another_frame() {
        let frame = Frame::new(standard_id(0x52F), &[0x00, 0x34, 0x12, 0, 0, 0, 1]).unwrap();
        let sent = sent(&frame);
        assert_eq!(received(&sent), Ok(frame));
        for at in 0..sent.len() {
            let mut damaged = sent.clone();
            damaged[at] = !damaged[at];
            assert_ne!(received(&damaged), Ok(frame), "bit {at}");
        }
    }
}
