//! What an error frame of the kernel says of a controller: `linux/can/error.h`.

use link_core::wire::Field;
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
        let is_active = (is(PROTOCOL) && data[2] == ACTIVE_AGAIN) || problems & ACTIVE != 0;
        let events = [
            is(COUNTERS).then_some(counters),
            self.is_bus_error().then(|| LinkEvent::BusError(self.kind())),
            (problems & OVERRUN != 0).then_some(LinkEvent::Overrun { lost: 0 }),
            (problems & WARNING != 0).then_some(LinkEvent::ErrorWarning),
            (problems & PASSIVE != 0).then_some(LinkEvent::ErrorPassive),
            is_active.then_some(LinkEvent::ErrorActive),
            is(BUS_OFF).then_some(LinkEvent::BusOff),
            is(RESTARTED).then_some(LinkEvent::Up),
        ];
        events.into_iter().flatten()
    }

    /// The error frame that tells of an event; `None` where none does. `Up` is the restart of a controller that was bus-off. How many
    /// frames an overrun has lost has no place in it.
    pub(crate) fn of_event(event: LinkEvent) -> Option<Self> {
        let controller = |problems| Self { class: CONTROLLER, data: [0, problems, 0, 0, 0, 0, 0, 0] };
        let counter = |value| u8::try_from(value).unwrap_or(u8::MAX);
        match event {
            LinkEvent::BusError(kind) => Some(Self::of_bus_error(kind, None)),
            LinkEvent::Overrun { .. } => Some(controller(OVERRUN)),
            LinkEvent::ErrorWarning => Some(controller(WARNING)),
            LinkEvent::ErrorPassive => Some(controller(PASSIVE)),
            LinkEvent::ErrorActive => Some(controller(ACTIVE)),
            LinkEvent::Counters { tec, rec } => {
                Some(Self { class: COUNTERS, data: [0, 0, 0, 0, 0, 0, counter(tec), counter(rec)] })
            }
            LinkEvent::BusOff => Some(Self { class: BUS_OFF, data: [0; 8] }),
            LinkEvent::Up => Some(Self { class: RESTARTED, data: [0; 8] }),
            LinkEvent::Down | LinkEvent::ModeSet(_) | LinkEvent::FilterSet | LinkEvent::Refused(_) => None,
        }
    }

    /// That of an error on the bus: in data byte 2 what was violated, in byte 3 where.
    pub(crate) fn of_bus_error(kind: BusErrorKind, place: Option<(u32, Field)>) -> Self {
        let mut data = [0; 8];
        let class = match kind {
            BusErrorKind::Ack => ACK | BUS_ERROR,
            BusErrorKind::Bit
            | BusErrorKind::Stuff
            | BusErrorKind::Crc
            | BusErrorKind::Form
            | BusErrorKind::Other => PROTOCOL | BUS_ERROR,
        };
        data[2] = match kind {
            BusErrorKind::Bit => 0x01,
            BusErrorKind::Form => 0x02,
            BusErrorKind::Stuff => 0x04,
            // A CRC error has no bit of its own; its place tells it.
            BusErrorKind::Crc | BusErrorKind::Ack | BusErrorKind::Other => 0x00,
        };
        data[3] = match (kind, place) {
            (BusErrorKind::Crc, _) => 0x08,
            (_, Some((_, field))) => location(field),
            (_, None) => 0x00,
        };
        Self { class, data }
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

/// The location codes of Linux; those of the arbitration and control fields are finer than what is known here, so they
/// are unspecified.
const fn location(field: Field) -> u8 {
    match field {
        Field::StartOfFrame => 0x03,
        Field::Arbitration | Field::Control => 0x00,
        Field::Data => 0x0A,
        Field::Crc => 0x08,
        Field::CrcDelimiter => 0x18,
        Field::AckSlot => 0x19,
        Field::AckDelimiter => 0x1B,
        Field::EndOfFrame => 0x1A,
    }
}

/// The classes, bits of the identifier.
pub(crate) const TX_TIMEOUT: u32 = 0x001;
pub(crate) const CONTROLLER: u32 = 0x004;
const PROTOCOL: u32 = 0x008;
const ACK: u32 = 0x020;
pub(crate) const BUS_OFF: u32 = 0x040;
pub(crate) const BUS_ERROR: u32 = 0x080;
pub(crate) const RESTARTED: u32 = 0x100;
const COUNTERS: u32 = 0x200;
/// Of a controller, in data byte 1; where it matters for receiving and sending, either bit.
const OVERRUN: u8 = 0x01;
const WARNING: u8 = 0x0C;
const PASSIVE: u8 = 0x30;
const ACTIVE: u8 = 0x40;
/// In the byte of protocol violations: alone it is the news that the controller is error-active again.
const ACTIVE_AGAIN: u8 = 0x40;

#[cfg(test)]
mod tests {
    use super::*;

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

    /// A recording tells the same of the controller as the bus did, but for how many frames were lost.
    #[test]
    fn what_was_recorded_comes_back() {
        use BusErrorKind::{Ack, Bit, Crc, Form, Other, Stuff};
        let errors = [Bit, Stuff, Crc, Form, Ack, Other].map(LinkEvent::BusError);
        let of_controller = [
            LinkEvent::Counters { tec: 136, rec: 2 },
            LinkEvent::Overrun { lost: 0 },
            LinkEvent::ErrorWarning,
            LinkEvent::ErrorPassive,
            LinkEvent::ErrorActive,
            LinkEvent::BusOff,
            LinkEvent::Up,
        ];
        for event in errors.into_iter().chain(of_controller) {
            let events: Vec<_> = ErrorFrame::of_event(event).unwrap().link_events().collect();
            assert_eq!(events, [event]);
        }
        let counters = ErrorFrame::of_event(LinkEvent::Counters { tec: 256, rec: 0 }).unwrap();
        assert_eq!(counters.data[6..], [255, 0], "a byte each");
        assert_eq!(ErrorFrame::of_event(LinkEvent::Down), None);
    }
}
