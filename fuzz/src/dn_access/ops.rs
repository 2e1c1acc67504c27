//! What can happen to a node, read from bytes.
//!
//! The first two bytes are the [`Config`]; then each operation is one byte, modulo 12, with its arguments behind it:
//!
//! | Byte | Operation | Arguments |
//! |---|---|---|
//! | 0 | time passes and a tick comes | [span](crate::input::span) |
//! | 1 | time passes unnoticed | span |
//! | 2 | a tick with a time that has passed | span |
//! | 3 | a frame | [frame](crate::input::frame) |
//! | 4 | a check message on the own identifier | length, then byte 0 |
//! | 5 | a message to faulted nodes, 0x7ED | which, then byte 0 |
//! | 6 | the frame in flight was sent | |
//! | 7 | the frame in flight is given back | |
//! | 8 | something below the frame | which |
//! | 9 | a command | which, then its value |
//! | 10 | the time of the next deadline comes, with a tick | |
//! | 11 | one nanosecond before the next deadline, a tick | |

use core::time::Duration;

use arbitrary::{Result, Unstructured};
use cip_core::code::VendorId;
use devicenet_core::access::{BusOffWhileChecking, Config, CounterSetMode, MacIdSource, MaskPredicate};
use devicenet_core::message::{DeviceIdentity, PortNumber};
use devicenet_core::{Identifier, MacId};
use link_core::link::LinkCommandKind;
use link_core::{BitRate, BusErrorKind, Frame, LinkEvent, Mode};

use crate::input;

/// Something that happens to a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Op {
    Tick(Duration),
    Elapse(Duration),
    TickInThePast(Duration),
    Frame(Frame),
    OwnCheck { len: u8, head: u8 },
    Faulted { message: u8, head: u8 },
    Sent,
    GivenBack,
    Link(LinkEvent),
    Command(Command),
    TickAtDeadline,
    TickBeforeDeadline,
}

/// A command of the application.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Command {
    Reset,
    ResetWithSwitches(MacId),
    SetMacId(MacId),
    SetBusOffInterrupt(bool),
    SetBusOffCounter(u8),
    ClearBusOffCounter,
    SetQuickConnect(bool),
}

/// Byte 0: the MAC ID in bits 5-0, bit 6 offline set off, bit 7 the predicate `intersects`. Byte 1: one choice each.
pub(super) fn config(input: &mut Unstructured<'_>) -> Result<Config> {
    let (first, choices): (u8, u8) = (input.arbitrary()?, input.arbitrary()?);
    let choice = |bit: u8| choices >> bit & 1 == 1;
    let mut config = Config::new(DEVICE, PORT, mac(first));
    config.offline_set = first & 0x40 == 0;
    config.mask_predicate = if first & 0x80 == 0 { MaskPredicate::Subset } else { MaskPredicate::Intersects };
    config.bus_off_interrupt = choice(0);
    config.quick_connect = choice(1);
    config.accept_bad_dlc = !choice(2);
    config.mac_id_source = if choice(3) { MacIdSource::Switches } else { MacIdSource::Software };
    config.same_mac_id_restarts = !choice(4);
    config.counter_set_mode =
        if choice(5) { CounterSetMode::OnlyZero } else { CounterSetMode::AnyValueClears };
    config.bus_off_while_checking =
        if choice(6) { BusOffWhileChecking::FollowInterrupt } else { BusOffWhileChecking::Fault };
    if choice(7) {
        config.bus_off_back_off = 0;
    }
    Ok(config)
}

pub(super) fn op(input: &mut Unstructured<'_>) -> Result<Op> {
    let code: u8 = input.arbitrary()?;
    Ok(match code % 12 {
        0 => Op::Tick(input::span(input.arbitrary()?)),
        1 => Op::Elapse(input::span(input.arbitrary()?)),
        2 => Op::TickInThePast(input::span(input.arbitrary()?)),
        3 => Op::Frame(input::frame(input)?),
        4 => Op::OwnCheck { len: input.arbitrary()?, head: input.arbitrary()? },
        5 => Op::Faulted { message: input.arbitrary()?, head: input.arbitrary()? },
        6 => Op::Sent,
        7 => Op::GivenBack,
        8 => Op::Link(link_event(input.arbitrary()?)),
        9 => Op::Command(command(input.arbitrary()?, input.arbitrary()?)),
        10 => Op::TickAtDeadline,
        _ => Op::TickBeforeDeadline,
    })
}

/// A check message on the identifier of `node`: seven bytes if `len` says nothing else.
pub(super) fn own_check(node: MacId, len: u8, head: u8) -> Frame {
    let [low, high] = OTHER.vendor.0.to_le_bytes();
    let [a, b, c, d] = OTHER.serial.to_le_bytes();
    let data = [head, low, high, a, b, c, d, 0];
    let len = if len <= 8 { usize::from(len) } else { 7 };
    Identifier::duplicate_mac_check(node).frame(&data[..len]).expect("at most eight bytes")
}

/// A message to faulted nodes; every second one that names a device names this one.
pub(super) fn faulted(message: u8, head: u8) -> Frame {
    let device = if message & 0x08 == 0 { DEVICE } else { OTHER };
    let [low, high] = device.vendor.0.to_le_bytes();
    let [a, b, c, d] = device.serial.to_le_bytes();
    let bytes: &[u8] = match message % 5 {
        0 => &[head, 0x4B, message >> 4],
        1 => &[head, 0x4C],
        2 => &[0x3F, 0x4C, low, high, a, b, c, d],
        3 => &[head, 0x4D, low, high, a, b, c, d],
        _ => &[head, message, low, high, a],
    };
    Identifier::COMMUNICATION_FAULTED_REQUEST.frame(bytes).expect("at most eight bytes")
}

fn link_event(which: u8) -> LinkEvent {
    match which % 16 {
        0..=2 => LinkEvent::Up,
        3 => LinkEvent::Down,
        4 | 5 => LinkEvent::BusOff,
        6 => LinkEvent::ErrorWarning,
        7 => LinkEvent::ErrorPassive,
        8 => LinkEvent::ErrorActive,
        9 => LinkEvent::BusError(BusErrorKind::Ack),
        10 => LinkEvent::BusError(BusErrorKind::Bit),
        11 => LinkEvent::Counters { tec: u16::from(which), rec: 0 },
        12 => LinkEvent::Overrun { lost: u32::from(which >> 4) },
        13 => LinkEvent::ModeSet(Mode { bit_rate: BitRate::K125, listen_only: false }),
        14 => LinkEvent::FilterSet,
        _ => {
            LinkEvent::Refused(if which < 0x80 { LinkCommandKind::Reset } else { LinkCommandKind::SetFilter })
        }
    }
}

fn command(which: u8, value: u8) -> Command {
    match which % 7 {
        0 => Command::Reset,
        1 => Command::ResetWithSwitches(mac(value)),
        2 => Command::SetMacId(mac(value)),
        3 => Command::SetBusOffInterrupt(value & 1 == 1),
        4 => Command::SetBusOffCounter(value),
        5 => Command::ClearBusOffCounter,
        _ => Command::SetQuickConnect(value & 1 == 1),
    }
}

fn mac(byte: u8) -> MacId {
    MacId::new(byte & 0x3F).expect("six bits")
}

/// The node under test: a fictitious device. The bytes of its serial number differ, because Who uses one of them.
pub(super) const DEVICE: DeviceIdentity = DeviceIdentity { vendor: VendorId(0x1234), serial: 0x0A05_0301 };
pub(super) const PORT: PortNumber = PortNumber::ZERO;
const OTHER: DeviceIdentity = DeviceIdentity { vendor: VendorId(0x1234), serial: 0x0A05_0302 };
