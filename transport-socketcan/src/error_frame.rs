//! Error frames of the kernel as link events.

use link_core::{BusErrorKind, LinkEvent};
use socketcan::errors::{ControllerProblems, ErrorCause, Location, ViolationTypes};
use socketcan::{CanError, CanErrorFrame};

/// What an error frame tells, in the order in which a machine is to hear it: the counters before the state to which they
/// led, the error before the state that it led to.
///
/// What DeviceNet has no use for is left out: arbitration lost, transceiver faults, a transmit time-out of the driver.
pub(crate) fn events(raw: libc::can_frame) -> impl Iterator<Item = LinkEvent> {
    let causes = CanErrorFrame::try_from(raw).ok().map(CanError::from);
    let mut events = Vec::new();
    for cause in causes.iter().flat_map(CanError::causes) {
        note(cause, &mut events);
    }
    events.sort_by_key(rank);
    // A driver may say the same in two classes: a bus error, and which one.
    if events.iter().any(|event| matches!(event, LinkEvent::BusError(kind) if *kind != BusErrorKind::Other)) {
        events.retain(|event| *event != LinkEvent::BusError(BusErrorKind::Other));
    }
    events.dedup();
    events.into_iter()
}

fn note(cause: &ErrorCause, events: &mut Vec<LinkEvent>) {
    match *cause {
        ErrorCause::Counters { tx, rx } => {
            events.push(LinkEvent::Counters { tec: tx.into(), rec: rx.into() })
        }
        ErrorCause::NoAck => events.push(LinkEvent::BusError(BusErrorKind::Ack)),
        ErrorCause::Protocol { types, location } => {
            // Alone it is the news that the controller is error-active again.
            if types != ViolationTypes::ACTIVE {
                events.push(LinkEvent::BusError(kind(types, location)));
            } else {
                events.push(LinkEvent::ErrorActive);
            }
        }
        ErrorCause::BusError => events.push(LinkEvent::BusError(BusErrorKind::Other)),
        ErrorCause::BusOff => events.push(LinkEvent::BusOff),
        ErrorCause::Restarted => events.push(LinkEvent::Up),
        ErrorCause::Controller(problems) => controller(problems, events),
        _ => {}
    }
}

fn controller(problems: ControllerProblems, events: &mut Vec<LinkEvent>) {
    use ControllerProblems as P;
    for (any_of, event) in [
        (P::RX_OVERFLOW, LinkEvent::Overrun { lost: 0 }),
        (P::RX_WARNING.union(P::TX_WARNING), LinkEvent::ErrorWarning),
        (P::RX_PASSIVE.union(P::TX_PASSIVE), LinkEvent::ErrorPassive),
        (P::ACTIVE, LinkEvent::ErrorActive),
    ] {
        if problems.intersects(any_of) {
            events.push(event);
        }
    }
}

fn kind(types: ViolationTypes, location: Location) -> BusErrorKind {
    use ViolationTypes as V;
    if types.intersects(V::BIT.union(V::BIT0).union(V::BIT1)) {
        BusErrorKind::Bit
    } else if types.contains(V::STUFF) {
        BusErrorKind::Stuff
    } else if matches!(location, Location::CrcSequence) {
        // Drivers tell a CRC error by its place, some as a form error.
        BusErrorKind::Crc
    } else if matches!(location, Location::AckSlot) {
        BusErrorKind::Ack
    } else if types.contains(V::FORM) {
        BusErrorKind::Form
    } else {
        BusErrorKind::Other
    }
}

const fn rank(event: &LinkEvent) -> u8 {
    match event {
        LinkEvent::Counters { .. } => 0,
        LinkEvent::Overrun { .. } | LinkEvent::BusError(_) => 1,
        LinkEvent::ErrorWarning | LinkEvent::ErrorPassive | LinkEvent::ErrorActive => 2,
        LinkEvent::BusOff => 3,
        LinkEvent::Up
        | LinkEvent::Down
        | LinkEvent::ModeSet(_)
        | LinkEvent::FilterSet
        | LinkEvent::Refused(_) => 4,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use LinkEvent as L;

    /// Classes and data as linux/can/error.h has them.
    fn of(classes: u32, data: [u8; 8]) -> Vec<LinkEvent> {
        let mut raw = socketcan::frame::can_frame_default();
        (raw.can_id, raw.can_dlc, raw.data) = (0x2000_0000 | classes, 8, data);
        events(raw).collect()
    }

    #[test]
    fn the_states_of_a_controller() {
        assert_eq!(of(0x40, [0; 8]), [L::BusOff]);
        assert_eq!(of(0x100, [0; 8]), [L::Up]);
        assert_eq!(of(0x4, [0, 0x04, 0, 0, 0, 0, 0, 0]), [L::ErrorWarning]);
        assert_eq!(of(0x4, [0, 0x30, 0, 0, 0, 0, 0, 0]), [L::ErrorPassive]);
        assert_eq!(of(0x4, [0, 0x40, 0, 0, 0, 0, 0, 0]), [L::ErrorActive]);
        assert_eq!(of(0x4, [0, 0x01, 0, 0, 0, 0, 0, 0]), [L::Overrun { lost: 0 }]);
        assert_eq!(of(0x8, [0, 0, 0x40, 0, 0, 0, 0, 0]), [L::ErrorActive]);
    }

    // CAN_ERR_CRTL | CAN_ERR_BUSERROR | CAN_ERR_CNT, as sja1000 sends them.
    #[test]
    fn counters_come_before_what_they_led_to() {
        assert_eq!(
            of(0x284, [0, 0x20, 0, 0, 0, 0, 128, 3]),
            [L::Counters { tec: 128, rec: 3 }, L::BusError(BusErrorKind::Other), L::ErrorPassive]
        );
    }

    #[test]
    fn every_kind_of_error() {
        let violation = |types, place| of(0x88, [0, 0, types, place, 0, 0, 0, 0]);
        assert_eq!(violation(0x01, 0), [L::BusError(BusErrorKind::Bit)]);
        assert_eq!(
            violation(0x90, 0),
            [L::BusError(BusErrorKind::Bit)],
            "a recessive bit was not seen, sending"
        );
        assert_eq!(violation(0x04, 0), [L::BusError(BusErrorKind::Stuff)]);
        assert_eq!(violation(0x02, 0x1A), [L::BusError(BusErrorKind::Form)], "in the end of frame");
        assert_eq!(violation(0x02, 0x08), [L::BusError(BusErrorKind::Crc)]);
        assert_eq!(violation(0x00, 0x19), [L::BusError(BusErrorKind::Ack)]);
        assert_eq!(of(0x20, [0; 8]), [L::BusError(BusErrorKind::Ack)]);
        assert_eq!(of(0x80, [0; 8]), [L::BusError(BusErrorKind::Other)]);
    }

    #[test]
    fn what_is_no_news_says_nothing() {
        assert_eq!(of(0x2, [11, 0, 0, 0, 0, 0, 0, 0]), [], "arbitration lost");
        assert_eq!(of(0, [0; 8]), []);
    }
}
