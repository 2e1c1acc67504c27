//! What there is one of for each channel: every channel is a network of its own.

/// What there is one of for each bus, begun with the first frame of that bus.
pub(super) fn of_bus<T>(all: &mut Vec<Box<T>>, bus: usize, begin: impl Fn() -> Box<T>) -> &mut T {
    if all.len() <= bus {
        begin_buses(all, bus, begin);
    }
    &mut all[bus]
}

/// Apart from what is done for every frame: a machine is made on the stack, and a function with hundreds of kilobytes there touches
/// each of their pages whenever it is called.
#[cold]
#[inline(never)]
fn begin_buses<T>(all: &mut Vec<Box<T>>, bus: usize, begin: impl Fn() -> Box<T>) {
    while all.len() <= bus {
        all.push(begin());
    }
}
