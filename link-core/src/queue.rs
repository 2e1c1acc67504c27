//! First in, first out, for a few small things.

use core::hash::{Hash, Hasher};

/// A queue of at most `N` elements in a ring: nothing moves when one is taken.
///
/// Two queues are equal when they hold the same elements in the same order, wherever in the ring they are.
///
/// ```
/// use link_core::Queue;
///
/// let mut queue = Queue::<u8, 2>::new();
/// assert_eq!((queue.push(1), queue.push(2)), (Ok(()), Ok(())));
/// assert_eq!(queue.push(3), Err(3), "full");
/// assert_eq!((queue.pop(), queue.pop(), queue.pop()), (Some(1), Some(2), None));
/// ```
#[derive(Clone, Debug)]
pub struct Queue<T, const N: usize> {
    slots: [Option<T>; N],
    /// Where the first element is, below `N`.
    first: u8,
    len: u8,
}

impl<T, const N: usize> Queue<T, N> {
    /// An empty queue.
    #[must_use]
    pub const fn new() -> Self {
        // Found when the program is compiled: where places without an element are zeros, no loop is left.
        const {
            assert!(N < 128, "places are counted in a byte");
            Self { slots: [const { None }; N], first: 0, len: 0 }
        }
    }

    /// Appends an element.
    ///
    /// # Errors
    /// The element, if the queue is full.
    pub fn push(&mut self, element: T) -> Result<(), T> {
        if self.is_full() {
            return Err(element);
        }
        let place = self.place(self.len);
        let Some(slot) = self.slots.get_mut(place) else { return Err(element) };
        *slot = Some(element);
        // There was room, so that it is at most `N`.
        self.len = self.len.wrapping_add(1);
        Ok(())
    }

    /// Takes the first element.
    pub fn pop(&mut self) -> Option<T> {
        let element = self.slots.get_mut(usize::from(self.first))?.take()?;
        self.advance();
        Some(element)
    }

    /// The first element, which stays.
    pub fn first(&self) -> Option<&T> {
        self.slots.get(usize::from(self.first))?.as_ref()
    }

    /// Drops the first element, if there is one.
    pub fn drop_first(&mut self) {
        if let Some(slot @ Some(_)) = self.slots.get_mut(usize::from(self.first)) {
            *slot = None;
            self.advance();
        }
    }

    fn advance(&mut self) {
        self.first = u8::try_from(self.place(1)).unwrap_or(0);
        self.len = self.len.saturating_sub(1);
    }

    /// Takes the first element that `is_wanted`; the others stay in their order.
    pub fn pop_where(&mut self, is_wanted: impl Fn(&T) -> bool) -> Option<T> {
        let mut found = None;
        for _ in 0..self.len {
            let element = self.pop()?;
            if found.is_none() && is_wanted(&element) {
                found = Some(element);
            } else {
                // There is room: one was just taken.
                let _ = self.push(element);
            }
        }
        found
    }

    /// The first element that `is_wanted`, to change it where it is.
    pub fn find_mut(&mut self, is_wanted: impl Fn(&T) -> bool) -> Option<&mut T> {
        let is_wanted_at =
            |place: &usize| self.slots.get(*place).and_then(Option::as_ref).is_some_and(&is_wanted);
        let place = (0..self.len).map(|index| self.place(index)).find(is_wanted_at)?;
        self.slots.get_mut(place)?.as_mut()
    }

    /// The elements in their order.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        (0..self.len).filter_map(|index| self.slots.get(self.place(index))?.as_ref())
    }

    /// How many elements there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len.into()
    }

    /// Whether there is none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Whether there is room for none.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.len() >= N
    }

    /// Drops all elements.
    pub fn clear(&mut self) {
        *self = Self::new();
    }

    /// Where the element `index` after the first is. By comparison: a small processor has no division.
    fn place(&self, index: u8) -> usize {
        let place = usize::from(self.first).saturating_add(usize::from(index));
        place.checked_sub(N).unwrap_or(place)
    }
}

impl<T: PartialEq, const N: usize> PartialEq for Queue<T, N> {
    fn eq(&self, other: &Self) -> bool {
        self.iter().eq(other.iter())
    }
}

impl<T: Eq, const N: usize> Eq for Queue<T, N> {}

impl<T: Hash, const N: usize> Hash for Queue<T, N> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.len.hash(state);
        self.iter().for_each(|element| element.hash(state));
    }
}

impl<T, const N: usize> Default for Queue<T, N> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    extern crate std;
    use std::collections::VecDeque;
    use std::hash::DefaultHasher;
    use std::vec::Vec;

    fn hash(queue: &Queue<u8, 3>) -> u64 {
        let mut hasher = DefaultHasher::new();
        queue.hash(&mut hasher);
        hasher.finish()
    }

    #[test]
    fn where_it_is_in_the_ring_does_not_matter() {
        let mut turned = Queue::<u8, 3>::new();
        for element in 0..5 {
            turned.push(element).unwrap();
            turned.pop().unwrap();
        }
        let mut fresh = Queue::new();
        for queue in [&mut turned, &mut fresh] {
            queue.push(7).unwrap();
            queue.push(8).unwrap();
        }
        assert_eq!(turned, fresh);
        assert_eq!(hash(&turned), hash(&fresh));
        fresh.pop();
        assert_ne!(turned, fresh);
    }

    #[test]
    fn without_room_nothing_is_taken() {
        let mut queue = Queue::<u8, 0>::new();
        assert_eq!(queue.push(1), Err(1));
        queue.drop_first();
        assert_eq!((queue.pop(), queue.first(), queue.len()), (None, None, 0));
    }

    proptest! {
        /// Against the queue of the standard library: `None` takes the first, one more than a multiple of 5 drops it, multiples of
        /// 50 are looked for, and all other numbers are pushed.
        #[test]
        fn it_is_a_queue(steps in prop::collection::vec(prop::option::of(0..200_u8), 0..40)) {
            let mut queue = Queue::<u8, 3>::new();
            let mut model = VecDeque::new();
            for step in steps {
                match step {
                    Some(wanted) if wanted % 50 == 0 => {
                        let found = model.iter().position(|element| *element > wanted);
                        let found = found.and_then(|index| model.remove(index));
                        prop_assert_eq!(queue.pop_where(|element| *element > wanted), found);
                    }
                    Some(drop) if drop % 5 == 1 => {
                        queue.drop_first();
                        model.pop_front();
                    }
                    Some(element) if model.len() < 3 => {
                        model.push_back(element);
                        prop_assert_eq!(queue.push(element), Ok(()));
                    }
                    Some(element) => prop_assert_eq!(queue.push(element), Err(element)),
                    None if model.len() == 3 => {
                        let wanted = |element: &u8| *element > 100;
                        let change = |element: &mut u8| { *element -= 100; *element };
                        let found = model.iter_mut().find(|element| wanted(element)).map(change);
                        prop_assert_eq!(queue.find_mut(wanted).map(change), found);
                        prop_assert_eq!(queue.pop(), model.pop_front());
                    }
                    None => prop_assert_eq!(queue.pop(), model.pop_front()),
                }
                prop_assert_eq!(queue.first(), model.front());
                prop_assert_eq!(queue.iter().copied().collect::<Vec<_>>(), Vec::from(model.clone()));
                prop_assert_eq!((queue.len(), queue.is_empty(), queue.is_full()), (model.len(), model.is_empty(), model.len() == 3));
            }
        }
    }
}
