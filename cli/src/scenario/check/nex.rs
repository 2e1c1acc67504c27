//! `[[node]]` with `role = "device"` or `role = "manager"`: DeviceNeX.

use core::ops::Range;
use core::time::Duration;

use toml::Spanned;

use super::Checker;
use super::device::is_set;
use crate::scenario::diagnostic::ScenarioError;
use crate::scenario::model::{DeviceNode, ManagerNode, NexNode, Protocol};
use crate::scenario::raw::RawNode;
use crate::scenario::values::Time;

impl Checker<'_> {
    pub(super) fn nex_device(
        &self,
        raw: &RawNode,
        table: &Range<usize>,
    ) -> Result<DeviceNode, ScenarioError> {
        self.protocol(raw, table, Protocol::DeviceNex)?;
        let oa = match &raw.oa {
            Some(oa) => self.number("oa", oa, 0, 127, OPERATIONAL_ADDRESS)?,
            None => NO_ADDRESS,
        };
        Ok(DeviceNode { node: self.nex(raw, table, oa)? })
    }

    pub(super) fn nex_manager(
        &self,
        raw: &RawNode,
        table: &Range<usize>,
    ) -> Result<ManagerNode, ScenarioError> {
        self.protocol(raw, table, Protocol::DeviceNex)?;
        let oa = self.required(raw.oa.as_ref(), table, "`oa`, the operational address of the manager,")?;
        let oa = self.number("oa", oa, 0, 126, "an operational address, 0 to 126")?;
        Ok(ManagerNode { node: self.nex(raw, table, oa)? })
    }

    fn nex(&self, raw: &RawNode, table: &Range<usize>, oa: u8) -> Result<NexNode, ScenarioError> {
        Ok(NexNode {
            oa,
            device: self.required_identity(raw, table)?,
            port: self.port(raw)?,
            boi: is_set(raw.boi.as_ref()),
            hello_wait: raw.hello_wait.as_ref().map_or(Ok(1_000), |wait| self.hello_wait(wait))?,
            announcement: raw.announcement.as_ref().map_or(Ok(10_000), |time| self.announcement(time))?,
        })
    }

    fn hello_wait(&self, value: &Spanned<Time>) -> Result<u16, ScenarioError> {
        match self.milliseconds("hello_wait", value)? {
            0 => self.fail(&value.span(), "`hello_wait` is 0s; expected at least 1ms, for others to object"),
            wait => Ok(wait),
        }
    }

    fn announcement(&self, value: &Spanned<Time>) -> Result<u32, ScenarioError> {
        let Time(time) = *value.get_ref();
        match u32::try_from(time.as_millis()) {
            Ok(millis) if Duration::from_millis(millis.into()) == time => Ok(millis),
            _ => self.fail(
                &value.span(),
                format!("`announcement` is {}; expected whole milliseconds, 0ms for never", Time(time)),
            ),
        }
    }
}

/// What `oa` may be.
pub(super) const OPERATIONAL_ADDRESS: &str = "an operational address, 0 to 126, or 127 for none";
/// The operational address that is none.
const NO_ADDRESS: u8 = 127;
