//! What an error frame of the kernel says of a controller: `linux/can/error.h`.

use link_core::{BusErrorKind, LinkEvent};

use super::frame::ErrorFrame;

impl ErrorFrame {
    /// The events in it, in the order in which a listener is to hear them: the counters before the error, the error before the state
    /// to which it led. Lost arbitration, a time-out of the driver and the transceiver are no events of a bus.
    pub(crate) fn link_events(&self) -> impl Iterator<Item = LinkEvent> + use<> {
        let Self { class, data } = *self;
        let is = |bits: u32| class & bits != 0;
        let counters = LinkEvent::Counters { tec: data[6].into(), rec: data[7].into() };
        let problems = if is(CONTROLLER) { data[1] } else { 0 };
        let is_active = (is(PROTOCOL) && data[2] == ACTIVE_AGAIN) || problems & 0x40 != 0;
        let events = [
            is(COUNTERS).then_some(counters),
            self.is_bus_error().then(|| LinkEvent::BusError(self.kind())),
            (problems & 0x01 != 0).then_some(LinkEvent::Overrun { lost: 0 }),
            (problems & 0x0C != 0).then_some(LinkEvent::ErrorWarning),
            (problems & 0x30 != 0).then_some(LinkEvent::ErrorPassive),
            is_active.then_some(LinkEvent::ErrorActive),
            is(BUS_OFF).then_some(LinkEvent::BusOff),
            is(RESTARTED).then_some(LinkEvent::Up),
        ];
        events.into_iter().flatten()
    }

    /// Whether it tells of a frame that was destroyed, and not of the controller alone.
    pub(crate) const fn is_bus_error(&self) -> bool {
        let Self { class, data } = *self;
        class & (BUS_ERROR | ACK) != 0 || (class & PROTOCOL != 0 && data[2] != ACTIVE_AGAIN)
    }

    const fn kind(&self) -> BusErrorKind {
        let Self { class, data } = *self;
        match (data[2], data[3]) {
            _ if class & ACK != 0 => BusErrorKind::Ack,
            _ if class & PROTOCOL == 0 => BusErrorKind::Other,
            // Bit, bit 0, bit 1.
            (types, _) if types & 0x19 != 0 => BusErrorKind::Bit,
            (types, _) if types & 0x04 != 0 => BusErrorKind::Stuff,
            // Drivers tell a CRC error by its place, some as a form error.
            (_, 0x08) => BusErrorKind::Crc,
            (_, 0x19) => BusErrorKind::Ack,
            (types, _) if types & 0x02 != 0 => BusErrorKind::Form,
            _ => BusErrorKind::Other,
        }
    }
}

const CONTROLLER: u32 = 0x004;
const PROTOCOL: u32 = 0x008;
const ACK: u32 = 0x020;
const BUS_OFF: u32 = 0x040;
const BUS_ERROR: u32 = 0x080;
const RESTARTED: u32 = 0x100;
const COUNTERS: u32 = 0x200;
/// In the byte of protocol violations: alone it is the news that the controller is error-active again.
const ACTIVE_AGAIN: u8 = 0x40;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate;

    /// `CAN_ERR_*` of linux/can/error.h.
    #[test]
    fn error_frames_as_the_kernel_writes_them() {
        let events = |class, data| ErrorFrame { class, data }.link_events().collect::<Vec<_>>();
        for (class, data, expected) in [
            (0x040, [0; 8], vec![LinkEvent::BusOff]),
            (0x100, [0; 8], vec![LinkEvent::Up]),
            (0x004, [0, 0x01, 0, 0, 0, 0, 0, 0], vec![LinkEvent::Overrun { lost: 0 }]),
            (0x004, [0, 0x08, 0, 0, 0, 0, 0, 0], vec![LinkEvent::ErrorWarning]),
            (
                0x204,
                [0, 0x30, 0, 0, 0, 0, 136, 2],
                vec![LinkEvent::Counters { tec: 136, rec: 2 }, LinkEvent::ErrorPassive],
            ),
            (0x008, [0, 0, 0x40, 0, 0, 0, 0, 0], vec![LinkEvent::ErrorActive]),
            (0x088, [0, 0, 0x04, 0x0A, 0, 0, 0, 0], vec![LinkEvent::BusError(BusErrorKind::Stuff)]),
            (0x080, [0; 8], vec![LinkEvent::BusError(BusErrorKind::Other)]),
            // Lost arbitration, transmit time-out, transceiver.
            (0x013, [0; 8], vec![]),
        ] {
            assert_eq!(events(class, data), expected, "{class:03X} {data:?}");
        }
    }

    /// A recording of the simulated bus tells the same kinds of error as the bus.
    #[test]
    fn kinds_that_were_recorded_come_back() {
        use BusErrorKind::{Ack, Bit, Crc, Form, Other, Stuff};
        for kind in [Bit, Stuff, Crc, Form, Ack, Other] {
            let events: Vec<_> = simulate::error_frame(kind, None).link_events().collect();
            assert_eq!(events, [LinkEvent::BusError(kind)]);
        }
    }
}
