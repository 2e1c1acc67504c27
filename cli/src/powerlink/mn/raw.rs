//! The network file as serde reads it: nothing checked but types and names.

use serde::Deserialize;
use toml::Spanned;

use crate::scenario::Time;

/// The file.
#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub(super) struct RawNetwork {
    pub(super) cycle: Option<Spanned<Time>>,
    pub(super) wait_not_active: Option<Spanned<Time>>,
    pub(super) wait_after_reset: Option<Spanned<Time>>,
    pub(super) wait_pre_operational_1: Option<Spanned<Time>>,
    pub(super) command_timeout: Option<Spanned<Time>>,
    pub(super) command_repeat: Option<Spanned<Time>>,
    pub(super) wait_soc_preq: Option<Spanned<Time>>,
    pub(super) async_slot: Option<Spanned<Time>>,
    pub(super) status_period: Option<Spanned<Time>>,
    pub(super) retry_after: Option<Spanned<Time>>,
    pub(super) sdo_timeout: Option<Spanned<Time>>,
    pub(super) pres_timeout: Option<Spanned<Time>>,
    pub(super) loss_of_soc_tolerance: Option<Spanned<Time>>,
    pub(super) async_mtu: Option<Spanned<i64>>,
    pub(super) multiplexed_cycles: Option<Spanned<i64>>,
    pub(super) prescaler: Option<Spanned<i64>>,
    pub(super) status_threshold: Option<Spanned<i64>>,
    pub(super) state_threshold: Option<Spanned<i64>>,
    pub(super) check_cycles: Option<Spanned<i64>>,
    pub(super) follows_requests: Option<bool>,
    pub(super) asks_diagnostic_device: Option<bool>,
    #[serde(default)]
    pub(super) node: Vec<Spanned<RawNode>>,
}

/// `[[node]]`
#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub(super) struct RawNode {
    pub(super) node: Option<Spanned<i64>>,
    pub(super) mandatory: Option<bool>,
    pub(super) async_only: Option<bool>,
    pub(super) multiplexed_slot: Option<Spanned<i64>>,
    pub(super) identity: Option<RawIdentity>,
    pub(super) configuration: Option<RawStamp>,
    pub(super) pres_timeout: Option<Spanned<Time>>,
    pub(super) loss_of_soc_tolerance: Option<Spanned<Time>>,
    pub(super) loss_of_pres_threshold: Option<Spanned<i64>>,
    pub(super) preq_limit: Option<Spanned<i64>>,
    pub(super) pres_limit: Option<Spanned<i64>>,
    pub(super) pdo_version: Option<Spanned<i64>>,
    #[serde(default)]
    pub(super) map_outputs: Vec<Spanned<RawMapped>>,
    #[serde(default)]
    pub(super) map_inputs: Vec<Spanned<RawMapped>>,
    pub(super) outputs: Option<Spanned<String>>,
    #[serde(default)]
    pub(super) write: Vec<Spanned<RawWrite>>,
}

/// `identity`: what is not there is not checked.
#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub(super) struct RawIdentity {
    pub(super) device_type: Option<Spanned<i64>>,
    pub(super) vendor: Option<Spanned<i64>>,
    pub(super) product: Option<Spanned<i64>>,
    pub(super) revision: Option<Spanned<i64>>,
    pub(super) serial: Option<Spanned<i64>>,
}

/// `configuration`
#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub(super) struct RawStamp {
    pub(super) date: Option<Spanned<i64>>,
    pub(super) time: Option<Spanned<i64>>,
}

/// An object in process data.
#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub(super) struct RawMapped {
    pub(super) object: Option<Spanned<String>>,
    pub(super) bits: Option<Spanned<i64>>,
    pub(super) offset: Option<Spanned<i64>>,
}

/// An object that is written before the node is started.
#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub(super) struct RawWrite {
    pub(super) object: Option<Spanned<String>>,
    pub(super) value: Option<Spanned<i64>>,
    pub(super) size: Option<Spanned<i64>>,
    pub(super) data: Option<Spanned<String>>,
    pub(super) may_fail: Option<bool>,
}
