//! `[[node]]` with `role = "device"` or `role = "manager"`: DeviceNeX.

use core::ops::Range;
use core::time::Duration;

use devicenex_core::OperationalAddress;
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
            None => OperationalAddress::NONE.number(),
        };
        let size = |key: &str, value: Option<&Spanned<i64>>| match value {
            Some(value) => self.number::<u16>(key, value, 0, 448, "a number of bytes, 0 to 448"),
            None => Ok(0),
        };
        let produce = size("produce", raw.produce.as_ref())?.into();
        Ok(DeviceNode {
            node: self.nex(raw, table, oa)?,
            input: match &raw.input {
                None => vec![0; produce],
                Some(input) => self.data("input", input, produce, "as the device produces")?,
            },
            consume: size("consume", raw.consume.as_ref())?,
        })
    }

    /// Without its database, which names nodes that may come later.
    pub(super) fn nex_manager(
        &self,
        raw: &RawNode,
        table: &Range<usize>,
    ) -> Result<ManagerNode, ScenarioError> {
        self.protocol(raw, table, Protocol::DeviceNex)?;
        let oa = self.required(raw.oa.as_ref(), table, "`oa`, the operational address of the manager,")?;
        let oa = self.number("oa", oa, 0, 126, "an operational address, 0 to 126")?;
        let tries = |key, value: &Option<Spanned<i64>>, default| {
            value.as_ref().map_or(Ok(default), |value| {
                self.number::<u8>(key, value, 1, 255, "a number of attempts, 1 to 255")
            })
        };
        Ok(ManagerNode {
            node: self.nex(raw, table, oa)?,
            mini_who: self.long_milliseconds("mini_who", raw.mini_who.as_ref(), 2_000)?,
            idle_mini_who: self.long_milliseconds("idle_mini_who", raw.idle_mini_who.as_ref(), 10_000)?,
            roam_tries: tries("roam_tries", &raw.roam_tries, 3)?,
            connect_tries: tries("connect_tries", &raw.connect_tries, 2)?,
            spare_wait: self.long_milliseconds("spare_wait", raw.spare_wait.as_ref(), 15_000)?,
            learning: is_set(raw.learning.as_ref()),
            takeover_after: self.long_milliseconds("takeover_after", raw.takeover_after.as_ref(), 0)?,
            rejoin_after: self.long_milliseconds("rejoin_after", raw.rejoin_after.as_ref(), 10_000)?,
            planned: Vec::new(),
        })
    }

    fn nex(&self, raw: &RawNode, table: &Range<usize>, oa: u8) -> Result<NexNode, ScenarioError> {
        Ok(NexNode {
            // The range was checked.
            oa: OperationalAddress::new(oa).unwrap_or(OperationalAddress::NONE),
            device: self.required_identity(raw, table)?,
            port: self.port(raw)?,
            boi: is_set(raw.boi.as_ref()),
            hello_wait: raw.hello_wait.as_ref().map_or(Ok(1_000), |wait| self.hello_wait(wait))?,
            announcement: self.long_milliseconds("announcement", raw.announcement.as_ref(), 10_000)?,
        })
    }

    fn hello_wait(&self, value: &Spanned<Time>) -> Result<u16, ScenarioError> {
        match self.milliseconds("hello_wait", value)? {
            0 => self.fail(&value.span(), "`hello_wait` is 0s; expected at least 1ms, for others to object"),
            wait => Ok(wait),
        }
    }

    fn long_milliseconds(
        &self,
        key: &str,
        value: Option<&Spanned<Time>>,
        default: u32,
    ) -> Result<u32, ScenarioError> {
        let Some(value) = value else { return Ok(default) };
        let Time(time) = *value.get_ref();
        match u32::try_from(time.as_millis()) {
            Ok(millis) if Duration::from_millis(millis.into()) == time => Ok(millis),
            _ => self.fail(&value.span(), format!("`{key}` is {}; expected whole milliseconds", Time(time))),
        }
    }
}

/// What `oa` may be.
pub(super) const OPERATIONAL_ADDRESS: &str = "an operational address, 0 to 126, or 127 for none";
