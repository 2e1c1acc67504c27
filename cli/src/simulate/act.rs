//! The actions of a scenario, carried out.

use devicenet_core::MacId;
use devicenet_core::access::{Access, Config};
use link_core::Instant;
use transport_mock::{Change, Network, NodeId};

use super::event::{Effect, NodeEvent};
use super::machines::{DeviceMachine, ManagerMachine, MasterMachine, SlaveMachine, Task, ToolMachine};
use crate::scenario::Do;

/// Carries out an action now. What cannot be seen on the bus, or has no effect, is told.
pub(super) fn act(network: &mut Network<NodeEvent>, node: NodeId, what: &Do) {
    if let Some(why) = obstacle(network, node, what) {
        return tell(network, node, what, Effect::None(why.to_owned()));
    }
    match what {
        Do::Cut => network.apply(Change::Cut(node)),
        Do::Plug => network.apply(Change::Plug(node)),
        Do::PowerOff => network.apply(Change::PowerOff(node)),
        Do::PowerOn => network.apply(Change::PowerOn(node)),
        Do::PowerCycle => network.apply(Change::PowerCycle(node)),
        Do::SetBitRate(rate) => {
            let turn = |slave: &mut SlaveMachine| slave.turn_bit_rate_switch(*rate);
            if network.command(node, |slave: &mut SlaveMachine, _| turn(slave)).is_none() {
                network.alter_memory(node, turn);
            }
            network.apply(Change::SetBitRate(node, *rate));
        }
        Do::SetMac(mac) => set_mac(network, node, what, MacId::new(*mac).unwrap_or(MacId::DEFAULT)),
        Do::SetOa(oa) => {
            tell(network, node, what, Effect::AtOnce);
            network.command(node, |device: &mut DeviceMachine, now| device.set_address(now, *oa));
        }
        Do::Readdress(from, to) => {
            let begun =
                network.command(node, |manager: &mut ManagerMachine, _| manager.readdress(*from, *to));
            let effect = match begun {
                Some(Err(error)) => Effect::None(error.to_string()),
                Some(Ok(())) | None => Effect::AtOnce,
            };
            tell(network, node, what, effect);
        }
        Do::Reset => {
            tell(network, node, what, Effect::AtOnce);
            let has_own = network.command(node, Access::reset).is_some()
                || network.command(node, DeviceMachine::reset).is_some()
                || network.command(node, ManagerMachine::reset).is_some()
                || network.command(node, SlaveMachine::reset).is_some();
            if !has_own {
                network.apply(Change::PowerCycle(node));
            }
        }
        Do::SetInput(data) => {
            let powered = network.is_powered(node);
            tell(network, node, what, if powered { Effect::AtOnce } else { Effect::AtPowerUp });
            network.command(node, |slave: &mut SlaveMachine, now| slave.set_input(now, data));
            network.alter_memory(node, |slave: &mut SlaveMachine| slave.keep_input(data));
            network.command(node, |device: &mut DeviceMachine, now| device.set_input(now, data));
            network.alter_memory(node, |device: &mut DeviceMachine| device.keep_input(data));
        }
        Do::SetOutput(output) => {
            let set = network.command(node, |master: &mut MasterMachine, _| master.set_output(output));
            let effect = match set {
                Some(Err(error)) => Effect::None(error.to_string()),
                Some(Ok(())) | None => Effect::AtOnce,
            };
            tell(network, node, what, effect);
        }
        Do::GoRun | Do::GoIdle => {
            tell(network, node, what, Effect::AtOnce);
            network.command(node, |master: &mut MasterMachine, _| master.set_run(*what == Do::GoRun));
        }
        Do::Claim => task(network, node, what, Task::Claim),
        Do::Release => task(network, node, what, Task::Release),
        Do::Who => task(network, node, what, Task::Who),
        Do::Identify(device) => task(network, node, what, Task::Identify(*device)),
        Do::Recover(device, mac) => {
            let mac = MacId::new(*mac).unwrap_or(MacId::DEFAULT);
            task(network, node, what, Task::Recover(*device, mac));
        }
    }
}

/// Why an action can have no effect.
fn obstacle(network: &Network<NodeEvent>, node: NodeId, what: &Do) -> Option<&'static str> {
    let (powered, plugged) = (network.is_powered(node), network.is_plugged(node));
    match what {
        Do::Cut if !plugged => Some("the cable is unplugged already"),
        Do::Plug if plugged => Some("the cable is plugged already"),
        Do::PowerOn if powered => Some("it has power already"),
        Do::PowerOff
        | Do::SetOa(_)
        | Do::Readdress(..)
        | Do::Reset
        | Do::SetOutput(_)
        | Do::GoRun
        | Do::GoIdle
        | Do::Claim
        | Do::Release
        | Do::Who
        | Do::Identify(_)
        | Do::Recover(..)
            if !powered =>
        {
            Some("no power")
        }
        _ => None,
    }
}

fn tell(network: &mut Network<NodeEvent>, node: NodeId, what: &Do, effect: Effect) {
    network.tell(node, NodeEvent::Action(what.clone(), effect));
}

fn task(network: &mut Network<NodeEvent>, node: NodeId, what: &Do, task: Task) {
    tell(network, node, what, Effect::AtOnce);
    network.command(node, |tool: &mut ToolMachine, now: Instant| tool.add(now, task));
}

/// A node whose switch is turned starts anew.
fn set_mac(network: &mut Network<NodeEvent>, node: NodeId, what: &Do, mac: MacId) {
    let powered = network.is_powered(node);
    tell(network, node, what, if powered { Effect::AtOnce } else { Effect::AtPowerUp });
    // Its MAC ID is set by software, so that it cannot refuse.
    if network.command(node, |access: &mut Access, now| access.set_mac_id(now, mac)).is_some() {
        return;
    }
    if powered {
        network.apply(Change::PowerOff(node));
    }
    network.alter_memory(node, |access: &mut Access| remember(access, mac));
    network.alter_memory(node, |slave: &mut SlaveMachine| slave.keep_mac_id(mac));
    network.alter_memory(node, |master: &mut MasterMachine| master.keep_mac_id(mac));
    network.alter_memory(node, |tool: &mut ToolMachine| tool.keep_mac_id(mac));
    if powered {
        network.apply(Change::PowerOn(node));
    }
}

/// What network access keeps without power: its MAC ID.
pub(super) fn remember(access: &mut Access, mac_id: MacId) {
    *access = Access::new(Config { mac_id, ..access.config().clone() });
}
