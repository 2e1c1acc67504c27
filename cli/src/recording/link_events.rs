//! What an error frame of a recording tells of the bus and of the controller that has recorded it.

use link_core::{BusErrorKind, LinkEvent};

use super::frame::ErrorFrame;

impl ErrorFrame {
    /// The events, in the order in which a listener is to hear them: the error before the state that it led to. The classes
    /// and bits are those of `linux/can/error.h`.
    pub fn link_events(&self) -> impl Iterator<Item = LinkEvent> + use<> {
        let [_, controller, violation, place, ..] = self.data;
        let has = |class: u32| self.class & class != 0;
        let state = |bits: u8, event| (has(CLASS_CONTROLLER) && controller & bits != 0).then_some(event);
        let is_active = has(CLASS_CONTROLLER) && controller & CONTROLLER_ACTIVE != 0
            || has(CLASS_PROTOCOL) && violation == VIOLATION_ACTIVE;
        let error = if has(CLASS_PROTOCOL) && violation != VIOLATION_ACTIVE {
            Some(kind(violation, place))
        } else if has(CLASS_ACK) {
            Some(BusErrorKind::Ack)
        } else if has(CLASS_BUS_ERROR) {
            Some(BusErrorKind::Other)
        } else {
            None
        };
        [
            state(CONTROLLER_OVERFLOW, LinkEvent::Overrun { lost: 0 }),
            error.map(LinkEvent::BusError),
            state(CONTROLLER_WARNING, LinkEvent::ErrorWarning),
            state(CONTROLLER_PASSIVE, LinkEvent::ErrorPassive),
            is_active.then_some(LinkEvent::ErrorActive),
            has(CLASS_BUS_OFF).then_some(LinkEvent::BusOff),
            has(CLASS_RESTARTED).then_some(LinkEvent::Up),
        ]
        .into_iter()
        .flatten()
    }
}

fn kind(violation: u8, place: u8) -> BusErrorKind {
    match (violation, place) {
        (bits, _) if bits & VIOLATION_BIT != 0 => BusErrorKind::Bit,
        (bits, _) if bits & VIOLATION_STUFF != 0 => BusErrorKind::Stuff,
        // Drivers tell a CRC error by its place, some as a form error.
        (_, PLACE_CRC) => BusErrorKind::Crc,
        (_, PLACE_ACK) => BusErrorKind::Ack,
        (bits, _) if bits & VIOLATION_FORM != 0 => BusErrorKind::Form,
        _ => BusErrorKind::Other,
    }
}

const CLASS_CONTROLLER: u32 = 0x004;
const CLASS_PROTOCOL: u32 = 0x008;
const CLASS_ACK: u32 = 0x020;
const CLASS_BUS_OFF: u32 = 0x040;
const CLASS_BUS_ERROR: u32 = 0x080;
const CLASS_RESTARTED: u32 = 0x100;
/// Receive buffer only: what was not sent is not lost for a listener.
const CONTROLLER_OVERFLOW: u8 = 0x01;
/// Receive or transmit.
const CONTROLLER_WARNING: u8 = 0x0C;
/// Receive or transmit.
const CONTROLLER_PASSIVE: u8 = 0x30;
const CONTROLLER_ACTIVE: u8 = 0x40;
/// A single bit, a dominant one, a recessive one.
const VIOLATION_BIT: u8 = 0x19;
const VIOLATION_FORM: u8 = 0x02;
const VIOLATION_STUFF: u8 = 0x04;
/// Alone it is the news that the controller is error-active again.
const VIOLATION_ACTIVE: u8 = 0x40;
const PLACE_CRC: u8 = 0x08;
const PLACE_ACK: u8 = 0x19;

#[cfg(test)]
mod tests {
    use super::*;
    use LinkEvent as L;

    /// Classes and data as linux/can/error.h has them.
    fn of(class: u32, data: [u8; 8]) -> Vec<LinkEvent> {
        ErrorFrame { class, data }.link_events().collect()
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

    #[test]
    fn every_kind_of_error() {
        let violation = |types, place| of(0x88, [0, 0, types, place, 0, 0, 0, 0]);
        for (types, place, kind) in [
            (0x01, 0, BusErrorKind::Bit),
            (0x90, 0, BusErrorKind::Bit),
            (0x04, 0, BusErrorKind::Stuff),
            (0x02, 0x1A, BusErrorKind::Form),
            (0x02, 0x08, BusErrorKind::Crc),
            (0x00, 0x19, BusErrorKind::Ack),
        ] {
            assert_eq!(violation(types, place), [L::BusError(kind)]);
        }
        assert_eq!(of(0x20, [0; 8]), [L::BusError(BusErrorKind::Ack)]);
        assert_eq!(of(0x80, [0; 8]), [L::BusError(BusErrorKind::Other)]);
    }

    /// As sja1000 sends them.
    #[test]
    fn the_error_comes_before_what_it_led_to() {
        let expected = [L::BusError(BusErrorKind::Other), L::ErrorPassive];
        assert_eq!(of(0x84, [0, 0x20, 0, 0, 0, 0, 128, 3]), expected);
    }
}
