//! Heartbeat and shutdown message: on 0x403 + 8s, or on 0x740 + s if the node has the UCMM.

use cip_core::code::{ClassId, InstanceId};
use cip_core::codec::Writer;
use cip_core::identity::IdentityStatus;
use heapless::Vec;
use link_core::Frame;
use link_core::timers::TimerSet;

use super::application::{Application, Parts};
use super::departure::Departure;
use super::lines::Sent;
use super::machine::Slave;
use super::timer::Timer;
use crate::message::{DeviceState, Heartbeat, HeartbeatFlags, Shutdown, ShutdownCode, Wire};

impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize> Slave<A, MESSAGE, DYNAMIC> {
    /// The interval begins, if there is one.
    pub(super) fn start_heartbeat(&mut self) {
        if !A::PARTS.contains(Parts::HEARTBEAT) {
            return;
        }
        match self.node.heartbeat_interval {
            None | Some(0) => self.node.timers.clear(Timer::Heartbeat),
            Some(seconds) => {
                let millis = u32::from(seconds).saturating_mul(1000);
                self.node.timers.set_after_millis(Timer::Heartbeat, millis);
            }
        }
    }

    /// Off line there is none, and nothing else waits by its timer.
    pub(super) fn stop_heartbeat(&mut self) {
        if A::PARTS.intersects(Parts::HEARTBEAT.union(Parts::BIT_RATE_DETECTION)) {
            self.heartbeat_due = false;
            self.node.timers.clear(Timer::Heartbeat);
        }
    }

    /// The interval is over. However late the slave learns of it, one heartbeat is due.
    pub(super) fn heartbeat_over(&mut self) {
        self.heartbeat_due = true;
        self.start_heartbeat();
    }

    pub(super) fn is_broadcast_due(&self) -> bool {
        (A::PARTS.contains(Parts::HEARTBEAT) && self.heartbeat_due) || self.is_shutdown_due()
    }

    pub(super) fn take_broadcast(&mut self) -> Option<(Sent, Vec<u8, { Frame::MAX_DATA }>)> {
        let node = self.node.access.mac_id();
        if self.is_shutdown_due() {
            let (class, instance) = (ClassId::IDENTITY, InstanceId(1));
            let shutdown = Shutdown { node, class, instance, code: ShutdownCode(0) };
            return Some((Sent::Shutdown, field_of(&shutdown)?));
        }
        if !A::PARTS.contains(Parts::HEARTBEAT) || !core::mem::take(&mut self.heartbeat_due) {
            return None;
        }
        let identity = self.node.application.identity();
        let state = identity.state.unwrap_or(cip_core::identity::DeviceState::OPERATIONAL);
        let heartbeat = Heartbeat {
            node,
            instance: InstanceId(1),
            state: DeviceState(state.0),
            flags: flags(identity.status, self.node.is_io_timed_out()),
            configuration_consistency: identity.configuration_consistency.unwrap_or(0),
        };
        Some((Sent::Heartbeat, field_of(&heartbeat)?))
    }

    fn is_shutdown_due(&self) -> bool {
        A::PARTS.contains(Parts::SHUTDOWN_MESSAGE)
            && self.node.departure.as_ref().is_some_and(Departure::is_shutting_down)
            && self.node.lines.explicit != Some(Sent::Shutdown)
            && self.node.lines.ucmm != Some(Sent::Shutdown)
    }
}

fn flags(status: IdentityStatus, timed_out: bool) -> HeartbeatFlags {
    let mut flags = HeartbeatFlags::empty();
    let fault = IdentityStatus::from_bits_retain(0x0F00);
    flags.set(HeartbeatFlags::DEVICE_FAULT, status.intersects(fault));
    flags.set(HeartbeatFlags::SYSTEM_FAULT, timed_out);
    flags
}

fn field_of<'a>(message: &impl Wire<'a>) -> Option<Vec<u8, { Frame::MAX_DATA }>> {
    let mut buffer = [0; Frame::MAX_DATA];
    let mut out = Writer::new(&mut buffer);
    message.emit(&mut out).ok()?;
    Vec::from_slice(out.written()).ok()
}
