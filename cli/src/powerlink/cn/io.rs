//! Inputs and outputs after CiA 401.

use link_core::codec::Writer;
use powerlink_core::dictionary::{Access, Entry, Mappable, ObjectAddress, ObjectSet, ObjectType};
use powerlink_core::pdo::MappingEntry;
use powerlink_core::wire::AbortCode;

/// The objects of the node.
///
/// | Object | Content |
/// |---|---|
/// | 0x6000/1 to /16 | digital inputs, 8 each |
/// | 0x6200/1 to /16 | digital outputs, 8 each |
/// | 0x6401/1 to /8 | analog inputs of 16 bits |
/// | 0x6411/1 to /8 | analog outputs of 16 bits |
///
/// Sub-index 0 is their number.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
pub(super) struct Io {
    digital_inputs: [u8; DIGITAL],
    digital_outputs: [u8; DIGITAL],
    analog_inputs: [[u8; 2]; ANALOG],
    analog_outputs: [[u8; 2]; ANALOG],
    /// The inputs of the beginning.
    first: ([u8; DIGITAL], [[u8; 2]; ANALOG]),
    /// Inputs follow outputs.
    pub(super) mirror: bool,
}

impl Io {
    /// Sets the first inputs: so many digital bytes, then analog ones.
    pub(super) fn set_inputs(&mut self, data: &[u8], digital: usize) {
        let (bytes, words) = data.split_at(digital.min(data.len()));
        self.digital_inputs.iter_mut().zip(bytes).for_each(|(input, byte)| *input = *byte);
        for (input, word) in self.analog_inputs.as_flattened_mut().iter_mut().zip(words) {
            *input = *word;
        }
        self.first = (self.digital_inputs, self.analog_inputs);
    }

    /// The first outputs, in the same order.
    pub(super) fn outputs(&self, digital: usize, analog: usize) -> Vec<u8> {
        let words = self.analog_outputs.iter().take(analog).flatten();
        self.digital_outputs.iter().take(digital).chain(words).copied().collect()
    }

    fn value(&self, at: ObjectAddress) -> Option<&[u8]> {
        let index = usize::from(at.sub).checked_sub(1)?;
        match at.index {
            DIGITAL_INPUTS => self.digital_inputs.get(index).map(core::slice::from_ref),
            DIGITAL_OUTPUTS => self.digital_outputs.get(index).map(core::slice::from_ref),
            ANALOG_INPUTS => self.analog_inputs.get(index).map(<[u8; 2]>::as_slice),
            ANALOG_OUTPUTS => self.analog_outputs.get(index).map(<[u8; 2]>::as_slice),
            _ => None,
        }
    }
}

impl ObjectSet for Io {
    const ENTRIES: &'static [Entry] = &[
        count(DIGITAL_INPUTS, "number of digital inputs"),
        byte(DIGITAL_INPUTS, "digital inputs", Access::ReadOnly, Mappable::Transmit),
        count(DIGITAL_OUTPUTS, "number of digital outputs"),
        byte(DIGITAL_OUTPUTS, "digital outputs", Access::ReadWrite, Mappable::Receive),
        count(ANALOG_INPUTS, "number of analog inputs"),
        word(ANALOG_INPUTS, "analog input", Access::ReadOnly, Mappable::Transmit),
        count(ANALOG_OUTPUTS, "number of analog outputs"),
        word(ANALOG_OUTPUTS, "analog output", Access::ReadWrite, Mappable::Receive),
    ];

    fn read(&self, at: ObjectAddress, out: &mut Writer<'_>) -> Result<(), AbortCode> {
        let written = match (at.sub, at.index) {
            (0, DIGITAL_INPUTS | DIGITAL_OUTPUTS) => out.u8(DIGITAL as u8),
            (0, _) => out.u8(ANALOG as u8),
            _ => out.bytes(self.value(at).ok_or(AbortCode::NO_SUB_INDEX)?),
        };
        written.map_err(|_| AbortCode::OUT_OF_MEMORY)
    }

    fn write(&mut self, at: ObjectAddress, data: &[u8]) -> Result<(), AbortCode> {
        let index = usize::from(at.sub).checked_sub(1).ok_or(AbortCode::READ_ONLY)?;
        let (output, input) = match at.index {
            DIGITAL_OUTPUTS => (
                self.digital_outputs.get_mut(index).map(core::slice::from_mut),
                self.digital_inputs.get_mut(index).map(core::slice::from_mut),
            ),
            ANALOG_OUTPUTS => (
                self.analog_outputs.get_mut(index).map(<[u8; 2]>::as_mut_slice),
                self.analog_inputs.get_mut(index).map(<[u8; 2]>::as_mut_slice),
            ),
            _ => return Err(AbortCode::READ_ONLY),
        };
        for value in [output, input.filter(|_| self.mirror)].into_iter().flatten() {
            if value.len() != data.len() {
                return Err(AbortCode::LENGTH);
            }
            value.copy_from_slice(data);
        }
        Ok(())
    }

    /// Nothing that was written is left, in inputs that follow outputs neither.
    fn restore(&mut self) {
        (self.digital_inputs, self.analog_inputs) = self.first;
        self.digital_outputs = [0; DIGITAL];
        self.analog_outputs = [[0; 2]; ANALOG];
    }
}

/// The first objects of a direction in process data: digital ones, then analog ones.
pub(super) fn mapping(direction: Direction, digital: u8, analog: u8) -> Vec<MappingEntry> {
    let (bytes, words) = match direction {
        Direction::Inputs => (DIGITAL_INPUTS, ANALOG_INPUTS),
        Direction::Outputs => (DIGITAL_OUTPUTS, ANALOG_OUTPUTS),
    };
    let bytes = (1..=digital).map(|sub| (ObjectAddress::new(bytes, sub), 8));
    let words = (1..=analog).map(|sub| (ObjectAddress::new(words, sub), 16));
    let mut offset = 0;
    bytes
        .chain(words)
        .map(|(object, length)| {
            let entry = MappingEntry { object, offset, length };
            offset += length;
            entry
        })
        .collect()
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Direction {
    Inputs,
    Outputs,
}

/// 0x1000: profile 401, and which kinds of inputs and outputs there are.
pub(super) const DEVICE_TYPE: u32 = 0x000F_0191;

const fn count(index: u16, name: &'static str) -> Entry {
    Entry::new(index, 0, name, ObjectType::Unsigned(1), Access::Constant)
}

const fn byte(index: u16, name: &'static str, access: Access, mappable: Mappable) -> Entry {
    Entry::new(index, 1, name, ObjectType::Unsigned(1), access).up_to_sub(DIGITAL as u8).mapped(mappable)
}

const fn word(index: u16, name: &'static str, access: Access, mappable: Mappable) -> Entry {
    Entry::new(index, 1, name, ObjectType::Signed(2), access).up_to_sub(ANALOG as u8).mapped(mappable)
}

const DIGITAL_INPUTS: u16 = 0x6000;
const DIGITAL_OUTPUTS: u16 = 0x6200;
const ANALOG_INPUTS: u16 = 0x6401;
const ANALOG_OUTPUTS: u16 = 0x6411;
/// In bytes.
const DIGITAL: usize = 16;
const ANALOG: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;

    fn read(io: &Io, index: u16, sub: u8) -> Vec<u8> {
        let mut buffer = [0xA5; 8];
        let mut out = Writer::new(&mut buffer);
        io.read(ObjectAddress::new(index, sub), &mut out).unwrap();
        out.written().to_vec()
    }

    #[test]
    fn inputs_are_set_digital_first() {
        let mut io = Io::default();
        io.set_inputs(&[1, 2, 0x34, 0x12], 2);
        assert_eq!(
            [read(&io, 0x6000, 1), read(&io, 0x6000, 2), read(&io, 0x6401, 1)],
            [vec![1], vec![2], vec![0x34, 0x12]]
        );
        assert_eq!([read(&io, 0x6000, 0), read(&io, 0x6411, 0)], [vec![16], vec![8]]);
    }

    #[test]
    fn mirrored_inputs_follow_outputs() {
        let mut io = Io::default();
        io.set_inputs(&[9, 1, 2], 1);
        io.write(ObjectAddress::new(0x6200, 1), &[5]).unwrap();
        assert_eq!((read(&io, 0x6000, 1), io.outputs(1, 1)), (vec![9], vec![5, 0, 0]));
        io.mirror = true;
        io.write(ObjectAddress::new(0x6411, 1), &[7, 8]).unwrap();
        assert_eq!((read(&io, 0x6401, 1), io.outputs(1, 1)), (vec![7, 8], vec![5, 7, 8]));
        assert_eq!(io.write(ObjectAddress::new(0x6411, 1), &[7]), Err(AbortCode::LENGTH));
        assert_eq!(io.write(ObjectAddress::new(0x6000, 1), &[7]), Err(AbortCode::READ_ONLY));
        io.restore();
        assert_eq!(io.outputs(1, 1), [0, 0, 0]);
        assert_eq!([read(&io, 0x6000, 1), read(&io, 0x6401, 1)], [vec![9], vec![1, 2]]);
    }

    #[test]
    fn what_is_mapped_follows_without_a_gap() {
        let entries = mapping(Direction::Outputs, 2, 1);
        let places: Vec<_> =
            entries.iter().map(|entry| (entry.object.to_string(), entry.offset, entry.length)).collect();
        assert_eq!(
            places,
            [("0x6200/1".into(), 0, 8), ("0x6200/2".into(), 8, 8), ("0x6411/1".into(), 16, 16)]
        );
    }
}
