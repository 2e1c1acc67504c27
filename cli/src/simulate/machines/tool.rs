//! A tool for the offline connection set.

use std::collections::VecDeque;

use devicenet_core::MacId;
use devicenet_core::access::Access;
use devicenet_core::message::{DelayOffset, DeviceIdentity};
use devicenet_core::tool::{CommandError, Config, OfflineTool, ToolEvent, ToolState};
use link_core::{Action, Deadline, Input, Instant, Machine};

use super::access_config;
use crate::scenario::{AccessNode, Do};
use crate::simulate::event::{Effect, NodeEvent};

/// A tool of a scenario. What it is told to do it does one after the other, and takes the offline connection set before it if
/// need be.
#[derive(Clone, Debug)]
pub(in crate::simulate) struct ToolMachine {
    tool: OfflineTool,
    /// The MAC ID is kept without power.
    mac: MacId,
    tasks: VecDeque<Task>,
    /// What it cannot do, and why: still to be told.
    refused: VecDeque<(Task, CommandError)>,
    /// It waits for what comes of the last.
    is_busy: bool,
}

/// What a tool is to do.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::simulate) enum Task {
    Claim,
    Who,
    Identify(DeviceIdentity),
    Recover(DeviceIdentity, MacId),
    Release,
}

impl From<Task> for Do {
    fn from(task: Task) -> Self {
        match task {
            Task::Claim => Self::Claim,
            Task::Who => Self::Who,
            Task::Identify(device) => Self::Identify(device),
            Task::Recover(device, mac) => Self::Recover(device, mac.number()),
            Task::Release => Self::Release,
        }
    }
}

impl ToolMachine {
    pub(in crate::simulate) fn new(node: &AccessNode) -> Self {
        Self::with(node, access_config(node).mac_id)
    }

    /// As it starts after `self` has lost its power.
    pub(in crate::simulate) fn restarted(&self, node: &AccessNode) -> Self {
        Self::with(node, self.mac)
    }

    fn with(node: &AccessNode, mac: MacId) -> Self {
        let access = devicenet_core::access::Config { mac_id: mac, ..access_config(node) };
        Self {
            tool: OfflineTool::new(Config::new(access)),
            mac,
            tasks: VecDeque::new(),
            refused: VecDeque::new(),
            is_busy: false,
        }
    }

    pub(in crate::simulate) const fn access(&self) -> &Access {
        self.tool.access()
    }

    pub(in crate::simulate) const fn keep_mac_id(&mut self, mac: MacId) {
        self.mac = mac;
    }

    pub(in crate::simulate) fn add(&mut self, now: Instant, task: Task) {
        self.tasks.push_back(task);
        self.work(now);
    }

    /// Begins what can begin.
    fn work(&mut self, now: Instant) {
        while let Some(task) = self.tasks.front().copied().filter(|_| !self.is_busy) {
            let begun = match (self.tool.state(), task) {
                (ToolState::Claiming, _) => return,
                (ToolState::Idle, Task::Release) => Ok(()),
                (ToolState::Idle, _) => {
                    // Before it is on line it cannot; it will be tried again then.
                    let _ = self.tool.claim(now);
                    return;
                }
                (ToolState::Owner, Task::Claim) => Ok(()),
                (ToolState::Owner, Task::Release) => {
                    self.tool.release(now);
                    Ok(())
                }
                (ToolState::Owner, Task::Who) => self.tool.who(now, DelayOffset::SERIAL),
                (ToolState::Owner, Task::Identify(device)) => self.tool.identify_device(now, device),
                (ToolState::Owner, Task::Recover(device, mac)) => self.tool.change_mac_id(now, device, mac),
            };
            match begun {
                Ok(()) => {}
                // It will be tried again.
                Err(CommandError::NotOnLine | CommandError::NotOwner | CommandError::Busy) => return,
                Err(error @ (CommandError::OwnMacId(_) | CommandError::Access(_))) => {
                    self.tasks.pop_front();
                    self.refused.push_back((task, error));
                    continue;
                }
            }
            self.tasks.pop_front();
            self.is_busy = matches!(task, Task::Who | Task::Identify(_) | Task::Recover(..));
        }
    }
}

impl Machine for ToolMachine {
    type Event = NodeEvent;

    fn input(&mut self, now: Instant, input: Input) {
        let before = self.tool.state();
        self.tool.input(now, input);
        if before != ToolState::Idle && self.tool.state() == ToolState::Idle {
            // The set is another tool's, or the network is lost: it does not ask again by itself.
            self.tasks.clear();
            self.is_busy = false;
        }
        self.work(now);
    }

    fn poll(&mut self, now: Instant) -> Option<Action<NodeEvent>> {
        if let Some((task, error)) = self.refused.pop_front() {
            return Some(Action::Event(NodeEvent::Action(task.into(), Effect::None(error.to_string()))));
        }
        let action = self.tool.poll(now)?;
        if let Action::Event(
            ToolEvent::WhoDone { .. }
            | ToolEvent::IdentifyDone { .. }
            | ToolEvent::Recovered { .. }
            | ToolEvent::NotRecovered { .. },
        ) = action
        {
            self.is_busy = false;
            self.work(now);
        }
        Some(action.map_event(|event| match event {
            ToolEvent::Access(event) => NodeEvent::Access(event),
            event => NodeEvent::Tool(event),
        }))
    }

    fn deadline(&self) -> Option<Deadline> {
        self.tool.deadline()
    }

    fn max_in_flight(&self) -> usize {
        self.tool.max_in_flight()
    }
}
