//! The DeviceNet object (class 3).

use cip_core::code::{AttributeId, GeneralStatus, ServiceCode};
use cip_core::codec::Writer;
use cip_core::object::{Call, Failure, exact};
use link_core::{BitRate, BusErrorKind, LinkEvent};

use super::application::{Application, Parts};
use super::bit_rate::{self, BIT_RATES};
use super::config::Options;
use super::departure::Departure;
use super::event::SlaveEvent;
use super::node::Node;
use super::server::Server;
use crate::access::MacIdSource;
use crate::counter::count;
use crate::id::MacId;

/// What the address and bit rate switches of a device show. A device without one of them has 0 there.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Switches {
    /// Attribute 8: as it is read, also above 63.
    pub mac_id: u8,
    /// Attribute 9: as it is read.
    pub bit_rate: u8,
}

/// The errors on the bus that the controller told: attribute 12.
///
/// | Byte | Content |
/// |---|---|
/// | 0-1 | which counters exist: bit n is counter n |
/// | 2-33 | 16 UINT: arbitration loss, overload, bit error, stuff error, ACK error, form error, CRC error, messages lost, warnings, receive errors, transmit errors, 5 reserved |
///
/// Counted are those that a driver can tell: bit, stuff, ACK, form and CRC errors, messages lost and warnings; the last
/// two are the error counters of the controller. Every counter stays at its maximum; setting the attribute to anything
/// clears them. Source: CIP Vol. 3, DeviceNet object.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Diagnostics {
    /// Counters 2 to 10.
    counters: [u16; 9],
}

/// What the DeviceNet object knows of the bus.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Port {
    /// Attribute 2 as stored, for the next start.
    pub(super) stored: BitRate,
    pub(super) active: BitRate,
    pub(super) rate_from_switches: bool,
    pub(super) switches: Option<Switches>,
    pub(super) diagnostics: Diagnostics,
}

/// The object, put together for one request.
pub(super) struct DeviceNetObject<'s, 'a, A: Application, const MESSAGE: usize, const DYNAMIC: usize>(
    pub(super) &'s mut Server<'a, A, MESSAGE, DYNAMIC>,
);

/// | Attribute | Value | Access |
/// |---|---|---|
/// | 1 | MAC ID, USINT 0-63 | Get; Set with [`Parts::SETTINGS`] unless switches set it |
/// | 2 | bit rate, USINT 0-2 | Get; Set with [`Parts::SETTINGS`] unless switches set it |
/// | 3 | BOI, BOOL | Get; Set with [`Parts::SETTINGS`] |
/// | 4 | bus-off counter, USINT | Get; Set with [`Parts::SETTINGS`] |
/// | 5 | allocation information: choice, MAC ID of the master or 255 | Get |
/// | 6, 7 | switches differ from what is in use, BOOL | Get, with switches |
/// | 8, 9 | what the switches show, USINT | Get, with switches |
/// | 10 | Quick Connect, BOOL | Get, Set |
/// | 12 | diagnostic counters | Get, Set clears them |
///
/// The attributes from 6 on are there with [`Parts::OPTIONAL_ATTRIBUTES`].
/// Services besides Get and Set: 0x4B Allocate, 0x4C Release. Class attribute 1 is [`REVISION`].
impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize>
    DeviceNetObject<'_, '_, A, MESSAGE, DYNAMIC>
{
    pub(super) fn get(&self, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        let node = &*self.0.node;
        let (access, port) = (&node.access, &node.port);
        let byte = match attribute.0 {
            ..=5 => return node.emit_mandatory(attribute, out),
            _ if !A::PARTS.contains(Parts::OPTIONAL_ATTRIBUTES) => return Err(ABSENT),
            6..=9 if port.switches.is_none() => return Err(ABSENT),
            6 => port.switches.is_some_and(|read| read.mac_id != access.mac_id().number()).into(),
            7 => port.switches.is_some_and(|read| read.bit_rate != bit_rate::number(port.active)).into(),
            8 => port.switches.map_or(0, |read| read.mac_id),
            9 => port.switches.map_or(0, |read| read.bit_rate),
            10 => access.quick_connect().into(),
            12 => return port.diagnostics.emit(out),
            _ => return Err(ABSENT),
        };
        Ok(out.u8(byte)?)
    }

    pub(super) fn set(&mut self, attribute: AttributeId, value: &[u8]) -> Result<(), Failure> {
        let invalid = Failure::new(GeneralStatus::INVALID_ATTRIBUTE_VALUE);
        match attribute.0 {
            ..=5 if !A::PARTS.contains(Parts::SETTINGS) => return Err(NOT_SETTABLE),
            1 if self.0.node.access.config().mac_id_source == MacIdSource::Switches => {
                return Err(NOT_SETTABLE);
            }
            1 => {
                let [mac] = exact(value)?;
                let mac = MacId::new(mac).ok_or(invalid)?;
                self.0.node.events.raise::<A>(SlaveEvent::StoreMacId(mac));
                self.0.node.departure = Some(Departure::mac_id(mac, self.0.requester.door));
            }
            2 if self.0.node.port.rate_from_switches => return Err(NOT_SETTABLE),
            2 => {
                let [number] = exact(value)?;
                let rate = *BIT_RATES.get(usize::from(number)).ok_or(invalid)?;
                self.0.node.port.stored = rate;
                self.0.node.events.raise::<A>(SlaveEvent::StoreBitRate(rate));
            }
            3 => self.0.node.access.set_bus_off_interrupt(boolean(value)?),
            4 => {
                let [count] = exact(value)?;
                if A::PARTS.contains(Parts::CHOICES) {
                    self.0.node.access.set_bus_off_counter(count).map_err(|_| invalid)?;
                } else {
                    self.0.node.access.clear_bus_off_counter();
                }
            }
            _ if !A::PARTS.contains(Parts::OPTIONAL_ATTRIBUTES) => {
                return Err(NOT_SETTABLE);
            }
            10 => {
                let enabled = boolean(value)?;
                self.0.node.access.set_quick_connect(enabled);
                self.0.node.events.raise::<A>(SlaveEvent::StoreQuickConnect(enabled));
            }
            12 => self.0.node.port.diagnostics = Diagnostics::default(),
            _ => return Err(NOT_SETTABLE),
        }
        Ok(())
    }

    pub(super) fn service(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Result<(), Failure> {
        match call.service {
            ServiceCode::ALLOCATE if !call.instance.is_class() => {
                self.0.node.allocate(self.0.offer(), self.0.requester, call.data, out)?;
            }
            ServiceCode::RELEASE if !call.instance.is_class() => {
                self.0.node.release(self.0.offer(), self.0.requester, call.data)?;
            }
            _ => return Err(GeneralStatus::SERVICE_NOT_SUPPORTED.into()),
        }
        Ok(())
    }
}

impl Diagnostics {
    /// Takes note of what the controller tells.
    pub(super) fn note(&mut self, event: LinkEvent) {
        let [bit, stuff, ack, form, crc, lost, warning, receive, transmit] = &mut self.counters;
        match event {
            LinkEvent::BusError(BusErrorKind::Bit) => count(bit),
            LinkEvent::BusError(BusErrorKind::Stuff) => count(stuff),
            LinkEvent::BusError(BusErrorKind::Ack) => count(ack),
            LinkEvent::BusError(BusErrorKind::Form) => count(form),
            LinkEvent::BusError(BusErrorKind::Crc) => count(crc),
            LinkEvent::Overrun { lost: frames } => {
                *lost = lost.saturating_add(u16::try_from(frames.max(1)).unwrap_or(u16::MAX));
            }
            LinkEvent::ErrorWarning => count(warning),
            LinkEvent::Counters { tec, rec } => (*transmit, *receive) = (tec, rec),
            LinkEvent::Up
            | LinkEvent::Down
            | LinkEvent::ErrorPassive
            | LinkEvent::ErrorActive
            | LinkEvent::BusOff
            | LinkEvent::BusError(BusErrorKind::Other)
            | LinkEvent::ModeSet(_)
            | LinkEvent::FilterSet
            | LinkEvent::Refused(_) => {}
        }
    }

    /// Writes attribute 12.
    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Failure> {
        let absent = [0_u16; 2];
        let reserved = [0; 5];
        let words = [DESCRIPTOR].into_iter().chain(absent).chain(self.counters).chain(reserved);
        for word in words {
            out.u16(word)?;
        }
        Ok(())
    }
}

impl<A: Application, const DYNAMIC: usize> Node<A, DYNAMIC> {
    /// Writes an attribute of the DeviceNet object that every device has: 1 to 5.
    #[inline]
    pub(super) fn emit_mandatory(&self, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        let byte = match attribute.0 {
            1 => self.access.mac_id().number(),
            2 if self.options.contains(Options::READ_ACTIVE_BIT_RATE) => bit_rate::number(self.port.active),
            2 => bit_rate::number(self.port.stored),
            3 => self.access.bus_off_interrupt().into(),
            4 => self.access.bus_off_counter(),
            5 => {
                let master = self.master.map_or(NOT_ALLOCATED, MacId::number);
                return Ok(out.bytes(&[self.choice().bits(), master])?);
            }
            _ => return Err(ABSENT),
        };
        Ok(out.u8(byte)?)
    }
}

/// A BOOL: 0 or 1.
fn boolean(value: &[u8]) -> Result<bool, Failure> {
    match exact(value)? {
        [0] => Ok(false),
        [1] => Ok(true),
        [_] => Err(GeneralStatus::INVALID_ATTRIBUTE_VALUE.into()),
    }
}

/// Class attribute 1.
pub(super) const REVISION: u16 = 2;
const ABSENT: Failure = Failure::new(GeneralStatus::ATTRIBUTE_NOT_SUPPORTED);
const NOT_SETTABLE: Failure = Failure::new(GeneralStatus::ATTRIBUTE_NOT_SETTABLE);
/// The MAC ID of the master while there is none.
const NOT_ALLOCATED: u8 = 255;
/// Counters 2 to 10.
const DESCRIPTOR: u16 = 0x07FC;
