//! What the views of a run share with whoever runs it.

use std::cell::RefCell;
use std::io;
use std::rc::Rc;

/// Text that views append and the run loop writes out.
#[derive(Clone, Debug, Default)]
pub(super) struct SharedBuffer(Rc<RefCell<Vec<u8>>>);

impl SharedBuffer {
    /// Appends.
    pub(super) fn write(&self, append: impl FnOnce(&mut Vec<u8>)) {
        append(&mut self.0.borrow_mut());
    }

    /// Moves everything to the end of `out`.
    pub(super) fn drain_into(&self, out: &mut Vec<u8>) {
        out.append(&mut self.0.borrow_mut());
    }
}

/// Keeps the first error; clones keep it together.
#[derive(Clone, Debug, Default)]
pub(super) struct FirstError(Rc<RefCell<Option<io::Error>>>);

impl FirstError {
    /// Keeps the error of a result, if it is the first.
    pub(super) fn note(&self, result: io::Result<()>) {
        if let Err(error) = result {
            self.0.borrow_mut().get_or_insert(error);
        }
    }

    /// The error, if there was one.
    pub(super) fn take(&self) -> io::Result<()> {
        self.0.borrow_mut().take().map_or(Ok(()), Err)
    }
}
