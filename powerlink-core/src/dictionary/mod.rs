//! The object dictionary: what a managing node reads and writes.
//!
//! [`STANDARD_ENTRIES`] are the objects of every node. The application adds its own as an [`ObjectSet`]. A [`Dictionary`] holds
//! the values of the standard objects, [`Objects`] joins it with those of the application.
//!
//! Storing parameters over a power cycle (0x1010, 0x1011) is not offered: the objects do not exist, and a managing node downloads
//! its configuration at each start. An application that keeps values gives them as power-on values.

mod device;
mod entry;
mod objects;
mod read;
mod table;
#[cfg(test)]
mod tests;
mod values;
mod write;

pub use device::{Device, FEATURES};
pub use entry::{Access, Entry, Mappable, ObjectAddress, ObjectType};
pub use objects::{NoObjects, ObjectSet};
pub use table::{HISTORY, STANDARD_ENTRIES};
pub use values::Values;
pub use write::Effect;

use link_core::Queue;
use link_core::codec::Writer;

use crate::error::ErrorCounters;
use crate::nmt::NmtState;
use crate::pdo::Mappings;
use crate::wire::{AbortCode, ErrorEntry};
use crate::{MacAddress, NodeId};

/// The standard objects with their values.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Dictionary {
    /// What never changes.
    pub device: Device,
    /// 0x1F93/1
    pub node: NodeId,
    /// 0x1030/5
    pub mac: MacAddress,
    /// What can be written.
    pub values: Values,
    /// 0x1400 to 0x1A00
    pub mappings: Mappings,
    /// 0x1C0A to 0x1C10
    pub counters: ErrorCounters,
    /// 0x1001
    pub error_register: u8,
    /// 0x1F8C
    pub state: NmtState,
    /// 0x1F98/1
    pub max_pres_payload: u16,
    /// 0x1003, the oldest first.
    history: Queue<ErrorEntry, { HISTORY_LENGTH }>,
}

impl Dictionary {
    /// A dictionary with given values, and errors yet to come.
    #[must_use]
    pub fn new(
        device: Device,
        node: NodeId,
        mac: MacAddress,
        values: Values,
        mappings: Mappings,
        max_pres_payload: u16,
    ) -> Self {
        Self {
            device,
            node,
            mac,
            values,
            mappings,
            counters: ErrorCounters::new(),
            error_register: 0,
            state: NmtState::Off,
            max_pres_payload,
            history: Queue::new(),
        }
    }

    /// Puts an error into the history, instead of the oldest if there are too many.
    pub fn log(&mut self, entry: ErrorEntry) {
        if self.history.is_full() {
            self.history.pop();
        }
        // There is room by now.
        let _ = self.history.push(entry);
    }

    /// The error history, the newest first.
    pub fn history(&self) -> impl Iterator<Item = &ErrorEntry> {
        (0..self.history.len()).rev().filter_map(|index| self.history.iter().nth(index))
    }
}

/// All objects of a node.
#[derive(Debug)]
pub struct Objects<'a, O> {
    /// 0x1000 to 0x1FFF
    pub standard: &'a mut Dictionary,
    /// 0x2000 to 0x9FFF
    pub application: &'a mut O,
}

impl<O: ObjectSet> Objects<'_, O> {
    /// Writes the value of an object to `out`.
    ///
    /// # Errors
    /// Why it cannot be read.
    pub fn read(&self, at: ObjectAddress, out: &mut Writer<'_>) -> Result<(), AbortCode> {
        if is_standard(at) {
            Entry::find(STANDARD_ENTRIES, at)?.check_read()?;
            return self.standard.read(at, out);
        }
        Entry::find(O::ENTRIES, at)?.check_read()?;
        self.application.read(at, out)
    }

    /// Takes a value, and says what has to follow.
    ///
    /// # Errors
    /// Why it is not taken.
    pub fn write(&mut self, at: ObjectAddress, data: &[u8]) -> Result<Effect, AbortCode> {
        if is_standard(at) {
            Entry::find(STANDARD_ENTRIES, at)?.check_write(data)?;
            return self.standard.write::<O>(at, data);
        }
        Entry::find(O::ENTRIES, at)?.check_write(data)?;
        self.application.write(at, data).map(|()| Effect::None)
    }
}

const fn is_standard(at: ObjectAddress) -> bool {
    at.index < FIRST_OF_APPLICATION
}

const FIRST_OF_APPLICATION: u16 = 0x2000;
const HISTORY_LENGTH: usize = 8;
const _: () = assert!(HISTORY == 8 && HISTORY_LENGTH == 8);
