//! Indicators, heartbeat, shutdown, reset, a new MAC ID, the detection of the bit rate.

use cip_core::identity::IdentityStatus;
use cip_core::message::ResetType;
use link_core::{BitRate, BusErrorKind, LinkCommand, LinkEvent, Mode, TxOutcome};

use super::bus::{Bus, CHECK, Full, G2o, MASTER, POLL, REQUEST, RESPONSE, Ucmm, block, config, everything};
use crate::MacId;
use crate::access::{NetworkStatus, StateKind};
use crate::slave::{ModuleStatus, Options, SlaveEvent, combined_status};

const REQUEST_1: [u8; 7] = [0x00, 0xE7, 0x03, 0x44, 0x33, 0x22, 0x11];

/// The network status, in the order of its life.
#[test]
fn network_status() {
    let mut bus: G2o = Bus::dark(config(), block());
    assert_eq!(bus.slave.network_status(), NetworkStatus::Off);
    bus.link(LinkEvent::Up);
    bus.wait(1999);
    assert_eq!(bus.slave.network_status(), NetworkStatus::Off);
    bus.wait(1);
    assert_eq!(bus.slave.network_status(), NetworkStatus::FlashingGreen);
    bus.skip();
    bus.skip();
    let mut bus = bus.allocated(0x03);
    assert_eq!(bus.slave.network_status(), NetworkStatus::SolidGreen);
    bus.asks(&[0x10, 5, 2, 9, 80, 0], &[0x90, 80, 0]);
    bus.hears(POLL, &[1]);
    bus.skip();
    bus.wait(320);
    bus.tells(SlaveEvent::NetworkStatus(NetworkStatus::FlashingRed));
    for end in [&[0x05, 5, 2][..], &[0x4B, 3, 1, 2, MASTER], &[0x4C, 3, 1, 2], &[0x09, 5, 2]] {
        let mut bus = bus.clone();
        bus.hears(REQUEST, &[&[MASTER], end].concat());
        assert_eq!(bus.slave.network_status(), NetworkStatus::SolidGreen, "{end:02X?}");
    }
    bus.wait(10_000);
    assert_eq!(bus.slave.network_status(), NetworkStatus::FlashingRed, "until the next allocation");
    bus.hears(CHECK, &[0x80, 1, 2, 3, 4, 5, 6]);
    assert_eq!(bus.slave.network_status(), NetworkStatus::SolidRed);
    bus.hears(0x7ED, &[0x3F, 0x4C, 0xE7, 0x03, 0x44, 0x33, 0x22, 0x11]);
    assert_eq!(bus.slave.network_status(), NetworkStatus::FlashingRedGreen);
    bus.wait(60_000);
    assert_eq!(bus.slave.network_status(), NetworkStatus::SolidRed);
    bus.link(LinkEvent::Down);
    assert_eq!(bus.slave.network_status(), NetworkStatus::Off);
}

#[test]
fn module_status() {
    let mut bus = Full::full();
    assert_eq!(bus.slave.module_status(), ModuleStatus::SolidGreen);
    for (status, shown) in [
        (IdentityStatus::MINOR_RECOVERABLE_FAULT, ModuleStatus::FlashingRed),
        (IdentityStatus::MAJOR_RECOVERABLE_FAULT, ModuleStatus::FlashingRed),
        (IdentityStatus::MAJOR_UNRECOVERABLE_FAULT, ModuleStatus::SolidRed),
        (IdentityStatus::empty(), ModuleStatus::SolidGreen),
    ] {
        bus.slave.application_mut().status = status;
        bus.drain();
        bus.tells(SlaveEvent::ModuleStatus(shown));
    }
    use cip_core::identity::DeviceState;
    for (state, shown) in [
        (DeviceState::NONEXISTENT, ModuleStatus::Off),
        (DeviceState::SELF_TESTING, ModuleStatus::FlashingRedGreen),
        (DeviceState::STANDBY, ModuleStatus::FlashingGreen),
        (DeviceState::OPERATIONAL, ModuleStatus::SolidGreen),
        (DeviceState::MAJOR_RECOVERABLE_FAULT, ModuleStatus::FlashingRed),
        (DeviceState::MAJOR_UNRECOVERABLE_FAULT, ModuleStatus::SolidRed),
    ] {
        assert_eq!(ModuleStatus::of(state, IdentityStatus::empty()), shown);
    }
}

#[test]
fn combined_indicator() {
    use ModuleStatus as Ms;
    use NetworkStatus as Ns;
    for (module, network, shown) in [
        (Ms::Off, Ns::Off, Ns::Off),
        (Ms::SolidGreen, Ns::Off, Ns::Off),
        (Ms::SolidGreen, Ns::FlashingGreen, Ns::FlashingGreen),
        (Ms::SolidGreen, Ns::SolidGreen, Ns::SolidGreen),
        (Ms::FlashingRed, Ns::SolidGreen, Ns::FlashingRed),
        (Ms::SolidGreen, Ns::FlashingRed, Ns::FlashingRed),
        (Ms::SolidRed, Ns::SolidGreen, Ns::SolidRed),
        (Ms::SolidGreen, Ns::SolidRed, Ns::SolidRed),
        (Ms::FlashingRedGreen, Ns::Off, Ns::FlashingRedGreen),
        (Ms::SolidGreen, Ns::FlashingRedGreen, Ns::FlashingRedGreen),
    ] {
        assert_eq!(combined_status(module, network), shown, "{module} {network}");
    }
}

/// Every interval while on line; state, flags and consistency value as in CIP Vol. 3.
#[test]
fn heartbeat() {
    let mut with_attribute = config();
    with_attribute.heartbeat_interval = Some(0);
    let mut bus: G2o = Bus::online(with_attribute.clone(), block()).allocated(0x01);
    bus.wait(9000);
    bus.sends_nothing();
    bus.asks(&[0x10, 1, 1, 10, 2], &[0x90]);
    bus.tells(SlaveEvent::StoreHeartbeatInterval(2));
    bus.asks(&[0x0E, 1, 1, 10], &[0x8E, 2]);
    bus.wait(1999);
    bus.sends_nothing();
    bus.wait(1);
    bus.sends(RESPONSE, &[63, 0xCD, 1, 0, 3, 0, 0, 0]);
    bus.wait(2000);
    bus.sends(RESPONSE, &[63, 0xCD, 1, 0, 3, 0, 0, 0]);
    // However late, one.
    bus.sleep(60_000);
    bus.sends(RESPONSE, &[63, 0xCD, 1, 0, 3, 0, 0, 0]);
    bus.sends_nothing();
    bus.link(LinkEvent::Down);
    bus.wait(60_000);
    bus.sends_nothing();
    // With the UCMM on another identifier.
    with_attribute.heartbeat_interval = Some(1);
    let mut application = everything();
    application.status = IdentityStatus::MINOR_RECOVERABLE_FAULT;
    let mut bus: Ucmm = Bus::online(with_attribute, application);
    bus.wait(1000);
    bus.sends(0x77F, &[63, 0xCD, 1, 0, 3, 0x01, 0, 0]);
}

/// The response precedes the reset; then two checks, and the node is back without connections.
#[test]
fn reset() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.acknowledging = false;
    bus.hears(REQUEST, &[MASTER, 0x05, 1, 1, 0]);
    bus.sends(RESPONSE, &[MASTER, 0x85]);
    assert_eq!(bus.slave.access().state().kind(), StateKind::OnLine);
    bus.hears(REQUEST, &[MASTER, 0x0E, 1, 1, 1]);
    bus.sends_nothing();
    bus.acknowledging = true;
    bus.done(TxOutcome::Sent);
    bus.tells(SlaveEvent::Reset(ResetType::POWER_CYCLE));
    bus.sends(CHECK, &REQUEST_1);
    assert_eq!(bus.allocation(), (0, None));
    bus.wait(1000);
    bus.sends(CHECK, &REQUEST_1);
    bus.wait(1000);
    assert_eq!(bus.slave.access().state().kind(), StateKind::OnLine);
}

#[test]
fn reset_types() {
    let mut bus = G2o::g2o().allocated(0x01);
    for kind in [3, 99, 100, 200, 255] {
        bus.asks(&[0x05, 1, 1, kind], &[0x94, 0x20, 0xFF]);
    }
    bus.asks(&[0x05, 1, 1, 0, 0], &[0x94, 0x15, 0xFF]);
    let mut config = config();
    config.access.mac_id = MacId::new(5).unwrap();
    config.access.quick_connect = true;
    config.bit_rate.rate = BitRate::K500;
    config.heartbeat_interval = Some(9);
    for (kind, mac, rate, interval) in [
        (ResetType::POWER_CYCLE, 5, BitRate::K500, 9),
        (ResetType::OUT_OF_BOX_KEEP_COMMUNICATION, 5, BitRate::K500, 0),
        (ResetType::OUT_OF_BOX, 63, BitRate::K125, 0),
    ] {
        let mut bus: G2o = Bus::online(config.clone(), block());
        bus.hears(0x42E, &[4, 0x4B, 3, 1, 1, 4]);
        bus.hears(0x42C, &[4, 0x05, 1, 1, kind.0]);
        bus.tells(SlaveEvent::Reset(kind));
        assert_eq!(bus.slave.access().mac_id().number(), mac, "{kind}");
        assert_eq!(bus.slave.node.port.active, rate, "{kind}");
        assert_eq!(bus.slave.node.heartbeat_interval, Some(interval), "{kind}");
        assert_eq!(bus.slave.access().quick_connect(), kind != ResetType::OUT_OF_BOX, "{kind}");
    }
}

/// The success response goes out under the old MAC ID; then the checks with the new one.
#[test]
fn a_new_mac_id() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.asks(&[0x10, 3, 1, 1, 64], &[0x94, 0x09, 0xFF]);
    bus.asks(&[0x10, 3, 1, 1, 5], &[0x90]);
    bus.tells(SlaveEvent::StoreMacId(MacId::new(5).unwrap()));
    bus.sends(0x42F, &REQUEST_1);
    assert_eq!(bus.allocation(), (0, None));
    bus.wait(1000);
    bus.sends(0x42F, &REQUEST_1);
    bus.wait(1000);
    bus.hears(0x42E, &[MASTER, 0x4B, 3, 1, 1, MASTER]);
    bus.sends(0x42B, &[MASTER, 0xCB, 0]);
    // The same once more restarts too, unless it shall not.
    bus.hears(0x42C, &[MASTER, 0x10, 3, 1, 1, 5]);
    bus.sends(0x42B, &[MASTER, 0x90]);
    bus.sends(0x42F, &REQUEST_1);
    let mut config = config();
    config.access.same_mac_id_restarts = false;
    let mut bus: G2o = Bus::online(config, block()).allocated(0x01);
    bus.asks(&[0x10, 3, 1, 1, 63], &[0x90]);
    bus.is_state(1, 3);
}

#[test]
fn shutdown_messages() {
    let mut config = config();
    config.options.insert(Options::SHUTDOWN_MESSAGE);
    for request in [&[0x05, 1, 1][..], &[0x10, 3, 1, 1, 63]] {
        let mut bus: G2o = Bus::online(config.clone(), block()).allocated(0x01);
        bus.asks(request, &[request[0] | 0x80]);
        bus.sends(RESPONSE, &[63, 0xCE, 1, 0, 1, 0, 0, 0]);
        bus.sends(CHECK, &REQUEST_1);
    }
    let mut bus: Ucmm = Bus::online(config.clone(), everything());
    bus.hears(0x784, &[63, 0x4B, 0, 0x31]);
    bus.skip();
    bus.hears(0x644, &[63, 0x05, 1, 1]);
    bus.sends(0x63F, &[4, 0x85]);
    bus.sends(0x77F, &[63, 0xCE, 1, 0, 1, 0, 0, 0]);
    bus.sends(CHECK, &REQUEST_1);
    // The network is lost before it could be sent.
    let mut bus: G2o = Bus::online(config, block()).allocated(0x01);
    bus.acknowledging = false;
    bus.hears(REQUEST, &[MASTER, 0x05, 1, 1]);
    bus.skip();
    bus.link(LinkEvent::Down);
    bus.tells(SlaveEvent::Reset(ResetType::POWER_CYCLE));
}

#[test]
fn the_application_resets() {
    let mut bus = G2o::g2o().established(0x03, &[2]);
    bus.slave.reset(bus.now);
    bus.drain();
    bus.sends(CHECK, &REQUEST_1);
    assert_eq!(bus.allocation(), (0, None));
}

fn mode(bit_rate: BitRate, listen_only: bool) -> Mode {
    Mode { bit_rate, listen_only }
}

/// Listening at one rate after the other; the first good frame tells.
#[test]
fn the_bit_rate_is_detected() {
    let mut config = config();
    config.bit_rate.detect = true;
    let mut bus: G2o = Bus::dark(config, block());
    bus.hears(POLL, &[1]);
    bus.link(LinkEvent::Up);
    for rate in [BitRate::K125, BitRate::K250, BitRate::K500, BitRate::K125] {
        assert_eq!(bus.links.pop(), Some(LinkCommand::SetMode(mode(rate, true))));
        bus.link(LinkEvent::ModeSet(mode(rate, true)));
        bus.wait(999);
        assert_eq!(bus.links, []);
        bus.wait(1);
    }
    assert_eq!(bus.links.pop(), Some(LinkCommand::SetMode(mode(BitRate::K250, true))));
    bus.link(LinkEvent::ModeSet(mode(BitRate::K250, true)));
    bus.link(LinkEvent::BusError(BusErrorKind::Stuff));
    assert_eq!(bus.links.pop(), Some(LinkCommand::SetMode(mode(BitRate::K500, true))));
    bus.link(LinkEvent::ModeSet(mode(BitRate::K500, true)));
    assert_eq!(bus.slave.network_status(), NetworkStatus::Off);
    bus.sends_nothing();
    // A frame at the very end of the second.
    bus.now += core::time::Duration::from_millis(1000);
    bus.hears(0x123, &[]);
    assert_eq!(bus.links.pop(), Some(LinkCommand::SetMode(mode(BitRate::K500, false))));
    bus.tells(SlaveEvent::BitRateDetected(BitRate::K500));
    bus.sends_nothing();
    bus.link(LinkEvent::ModeSet(mode(BitRate::K500, false)));
    bus.sends(CHECK, &REQUEST_1);
    bus.wait(2000);
    bus.skip();
    bus.allocated(0x01).asks(&[0x0E, 3, 1, 2], &[0x8E, 2]);
}

#[test]
fn detection_without_a_port_that_can_and_without_power() {
    let mut config = config();
    config.bit_rate.detect = true;
    let mut bus: G2o = Bus::dark(config, block());
    bus.link(LinkEvent::Up);
    bus.link(LinkEvent::Down);
    bus.wait(5000);
    bus.link(LinkEvent::Up);
    bus.link(LinkEvent::Refused(link_core::link::LinkCommandKind::SetMode));
    bus.sends(CHECK, &REQUEST_1);
    bus.wait(2000);
    assert_eq!(bus.slave.access().state().kind(), StateKind::OnLine);
}

/// The words of the decoder for what it sees on the bus, and those of the master for its own indicator.
#[test]
fn what_is_told_has_the_words_of_the_others() {
    use crate::master::MasterEvent;
    use cip_core::code::{ClassId, InstanceId, ServiceCode};
    let (class, instance) = (ClassId::DEVICENET, InstanceId(1));
    let allocated = SlaveEvent::Changed { class, instance, service: ServiceCode::ALLOCATE };
    assert_eq!(std::format!("{allocated}"), "Allocate DeviceNet 1 done");
    let status = NetworkStatus::SolidGreen;
    assert_eq!(std::format!("{}", SlaveEvent::NetworkStatus(status)), "network status green");
    assert_eq!(std::format!("{}", MasterEvent::NetworkStatus(status)), "network status green");
}
