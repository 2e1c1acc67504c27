//! The identifiers that a node must receive.
//!
//! A filter may let through more than is needed, never less; every machine looks at the identifier again.

use link_core::frame::extended_id;
use link_core::{Filter, FilterSet};

use super::OperationalAddress;

/// A device without an address, paper figure 5: `1111 X 1111111 0` and 16 bits that do not count, mask 0x1EFF0000, value
/// 0x1EFE0000 **\[P\]**. Mini-who and ROAM pass, and the Hello requests of other devices without an address. The
/// controller may wake a sleeping device by it.
#[must_use]
pub fn standby() -> FilterSet {
    FilterSet::of([Filter::extended(extended_id(0x1EFE_0000), 0x1EFF_0000)])
}

/// A node that has or wants an address: Hello requests and responses of that address.
#[must_use]
pub fn hello(own: OperationalAddress) -> FilterSet {
    FilterSet::of([with_address(0x1F00_0000, own, 0x1F00_0000)])
}

/// A node on line: [`hello`], connection requests, connectionless and explicit messages to its address. What its
/// connections consume is to be added.
#[must_use]
pub fn node(own: OperationalAddress) -> FilterSet {
    let mut filters = hello(own);
    // Classes 11100 and 11101, then 10mmm.
    filters.add(with_address(0x1C00_0000, own, 0x1E00_0000));
    filters.add(with_address(0x1000_0000, own, 0x1800_0000));
    filters
}

/// A network manager: the same, every Hello, and every Mini-who and ROAM, by which another manager shows.
#[must_use]
pub fn network_manager(own: OperationalAddress) -> FilterSet {
    let mut filters = node(own);
    // Classes 11110 and 11111.
    filters.add(Filter::extended(extended_id(0x1E00_0000), 0x1E00_0000));
    filters
}

/// All implicit messages with 29 bits: class 0mmmm.
#[must_use]
pub fn implicit() -> Filter {
    Filter::extended(extended_id(0), 0x1000_0000)
}

fn with_address(class: u32, address: OperationalAddress, class_mask: u32) -> Filter {
    Filter::extended(extended_id(class | u32::from(address.number()) << 17), class_mask | 0x00FE_0000)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::id::{Direction, Framing, Identifier, Layout, MessageId, Route};
    use cip_core::code::InstanceId;
    use link_core::{Frame, Id};
    use proptest::prelude::*;

    fn oa(number: u8) -> OperationalAddress {
        OperationalAddress::new(number).unwrap()
    }

    fn passes(filters: &FilterSet, id: Identifier) -> bool {
        filters.accepts(&Frame::new(id.id(), &[]).unwrap())
    }

    #[test]
    fn the_standby_filter_is_that_of_figure_5() {
        let filters = standby();
        let [filter] = filters.as_slice() else { panic!("{filters:?}") };
        assert!(filter.is_extended());
        assert_eq!((filter.value(), filter.mask()), (0x1EFE_0000, 0x1EFF_0000));
    }

    #[test]
    fn a_device_without_an_address_hears_what_is_for_such_devices() {
        let filters = standby();
        assert!(passes(&filters, Identifier::roam(0x1234)));
        assert!(passes(&filters, Identifier::hello(OperationalAddress::NONE, Direction::Request, 0x1234)));
        assert!(!passes(&filters, Identifier::hello(oa(126), Direction::Request, 0x1234)));
        assert!(!passes(&filters, Identifier::hello(OperationalAddress::NONE, Direction::Response, 0)));
        let route =
            Route { destination: OperationalAddress::NONE, direction: Direction::Request, source: oa(1) };
        assert!(!passes(&filters, Identifier::connection(route, 0)));
        assert!(
            (0..=0x7FF).all(|raw| {
                !filters.accepts(&Frame::new(link_core::frame::standard_id(raw), &[]).unwrap())
            })
        );
    }

    proptest! {
        /// The filter of a node on line lets through what is for it, and nothing else.
        #[test]
        fn a_node_hears_what_is_for_it(own in 0_u8..127, raw in 0_u32..0x2000_0000) {
            let own = oa(own);
            let id = Identifier::from(Id::Extended(extended_id(raw)));
            let meant = match id.layout() {
                Layout::Hello { source, .. } => source == own,
                Layout::Connection { route, .. }
                | Layout::Connectionless { route, .. }
                | Layout::Explicit { route, .. } => route.destination == own,
                Layout::Roam { .. } | Layout::Implicit { .. } | Layout::Standard { .. } => false,
                // A fragment of class 11101 is not told apart.
                Layout::Reserved(_) => return Ok(()),
            };
            prop_assert_eq!(passes(&node(own), id), meant, "{}", id.layout());
        }
    }

    #[test]
    fn a_manager_hears_every_hello_and_what_is_for_it() {
        let filters = network_manager(oa(1));
        assert!(passes(&filters, Identifier::hello(oa(67), Direction::Request, 7)));
        assert!(passes(&filters, Identifier::roam(7)));
        let route = |destination| Route {
            destination: oa(destination),
            direction: Direction::Response,
            source: oa(67),
        };
        assert!(passes(&filters, Identifier::connection(route(1), 3)));
        assert!(!passes(&filters, Identifier::connection(route(2), 3)));
        let framing = Framing::Complete { transaction: 0 };
        assert!(passes(&filters, Identifier::connectionless(route(1), framing)));
        assert!(!passes(&filters, Identifier::implicit(MessageId::default(), oa(1), InstanceId(3))));
    }
}
