//! The scenario file as serde reads it: every key optional and with its place, nothing checked but types and names.

use core::ops::Range;

use serde::Deserialize;
use toml::Spanned;

use super::values::{Comparison, RateSetting, SlaveName, Time, TimeRange};

/// A table of the file.
pub(super) trait Table {
    /// The keys that the file may have here.
    const KEYS: &'static [&'static str];

    /// The keys that the file has here, with the places of their values.
    fn keys(&self) -> Vec<(&'static str, Range<usize>)>;
}

/// Declares a [`Table`] whose keys are all optional: which are required depends on the others.
macro_rules! table {
    ($(#[$doc:meta])* $name:ident { $($key:ident $(as $text:literal)?: $type:ty),* $(,)? }) => {
        $(#[$doc])*
        #[derive(Deserialize, Debug)]
        #[serde(deny_unknown_fields, expecting = "a table of keys and values")]
        pub(super) struct $name {
            $($(#[serde(rename = $text)])? pub(super) $key: Option<Spanned<$type>>),*
        }

        impl Table for $name {
            const KEYS: &'static [&'static str] = &[$(table!(@name $key $($text)?)),*];

            fn keys(&self) -> Vec<(&'static str, Range<usize>)> {
                let mut keys = Vec::new();
                $(if let Some(value) = &self.$key {
                    keys.push((table!(@name $key $($text)?), value.span()));
                })*
                keys
            }
        }
    };
    (@name $key:ident) => { stringify!($key) };
    (@name $key:ident $text:literal) => { $text };
}

/// The file.
#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub(super) struct RawScenario {
    pub(super) title: Option<String>,
    pub(super) bus: Option<RawBus>,
    #[serde(default)]
    pub(super) node: Vec<Spanned<RawNode>>,
    #[serde(default)]
    pub(super) action: Vec<Spanned<RawAction>>,
    #[serde(default)]
    pub(super) fault: Vec<Spanned<RawFault>>,
    #[serde(default)]
    pub(super) expect: Vec<Spanned<RawExpect>>,
    #[serde(default)]
    pub(super) note: Vec<Spanned<RawNote>>,
}

table! { /** `[bus]` */ RawBus { bit_rate: RateSetting, seed: i64, duration: Time } }

table! {
    /// `[[node]]`
    RawNode {
        name: String,
        count: i64,
        protocol: String,
        role: String,
        mac: i64,
        oa: i64,
        power_up: TimeRange,
        reaction: TimeRange,
        bit_rate: RateSetting,
        clock_ppm: i64,
        identity: RawIdentity,
        port: i64,
        boi: bool,
        quick_connect: bool,
        offline_set: bool,
        switches: bool,
        hello_wait: Time,
        announcement: Time,
        produce: i64,
        consume: i64,
        mini_who: Time,
        idle_mini_who: Time,
        roam_tries: i64,
        connect_tries: i64,
        spare_wait: Time,
        learning: bool,
        takeover_after: Time,
        rejoin_after: Time,
        planned: Vec<Spanned<RawPlanned>>,
        poll: RawIo,
        bit_strobe: RawIo,
        cos: RawIo,
        cyclic: RawIo,
        multicast_poll: RawIo,
        input: String,
        ucmm: bool,
        unconnected_port: bool,
        heartbeat: Time,
        shutdown_message: bool,
        run: bool,
        interscan_delay: Time,
        response_wait: Time,
        background_ratio: i64,
        first_contact: String,
        retry_after: Time,
        retry_at_most: Time,
        replacement: String,
        replacement_retry: Time,
        multicast_output: String,
        scan: Vec<Spanned<RawScan>>,
        file: String,
        log: String,
        only: Vec<i64>,
        frame: String,
        period: Time,
    }
}

table! {
    /// `identity = { .. }`
    RawIdentity {
        vendor: i64,
        device_type: i64,
        product: i64,
        revision: [i64; 2],
        serial: i64,
        name: String,
    }
}

table! {
    /// `poll = { .. }` and the other I/O connections, of a slave or of a scan list.
    RawIo { produce: i64, consume: i64, epr: Time, inhibit: Time, acknowledged: bool }
}

table! {
    /// `[[node.scan]]`
    RawScan {
        mac: i64,
        poll: RawIo,
        bit_strobe: RawIo,
        cos: RawIo,
        cyclic: RawIo,
        multicast_poll: RawIo,
        epr: Time,
        key: RawKey,
        background: bool,
        replaceable: bool,
        output: String,
        strobe_bit: bool,
        configuration: Vec<Spanned<RawWrite>>,
    }
}

table! {
    /// `key = { .. }`
    RawKey { vendor: i64, device_type: i64, product: i64, revision: [i64; 2] }
}

table! {
    /// `configuration = [{ .. }]`
    RawWrite { class: i64, instance: i64, attribute: i64, value: String }
}

table! {
    /// `[[node.planned]]`
    RawPlanned {
        oa: i64,
        device: toml::Value,
        spares: Vec<Spanned<toml::Value>>,
        connections: Vec<Spanned<RawPlannedIo>>,
        reads: Vec<Spanned<RawRead>>,
    }
}

table! {
    /// `connections = [{ .. }]`
    RawPlannedIo { connection: String, epr: Time, watchdog: String, from: SlaveName }
}

table! {
    /// `reads = [{ .. }]`
    RawRead { class: i64, instance: i64, attribute: i64 }
}

table! {
    /// `[[action]]`
    RawAction { at: Time, node: String, action as "do": String, value: toml::Value }
}

table! {
    /// `[[fault]]`
    RawFault {
        from: Time,
        to: Time,
        kind: String,
        node: String,
        nodes: Vec<Spanned<String>>,
        rate: f64,
        frame: i64,
        bit: i64,
        id: i64,
        overrun: bool,
        gap: Time,
        length: Time,
        pull: Time,
        every: Time,
        ppm: i64,
    }
}

table! {
    /// `[[expect]]`
    RawExpect {
        by: Time,
        at: Time,
        from: Time,
        to: Time,
        never: bool,
        always: bool,
        node: String,
        state: String,
        oa: i64,
        tec: Comparison,
        rec: Comparison,
        bus_off: bool,
        event: String,
        connection: String,
        connection_state: String,
        mode: String,
        input: String,
        output: String,
        slave: SlaveName,
        slave_state: String,
        status: Comparison,
        device: SlaveName,
        device_state: String,
    }
}

table! { /** `[[note]]` */ RawNote { at: Time, text: String } }
