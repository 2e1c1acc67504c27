//! The words that lines and screen share.

use core::fmt;
use core::time::Duration;

use devicenet_core::monitor::{ConnectionName, ConnectionRecord, ConnectionState, Predefined};

use super::model::NodePicture;
use crate::histogram;
use crate::text::product_name;

/// `43.2 %`
pub(super) fn percent(share: f64) -> String {
    format!("{:.1} %", share * 100.0)
}

/// `0.30 ms`
pub(super) fn time(span: Option<Duration>) -> String {
    span.map_or_else(|| "-".into(), histogram::milliseconds)
}

/// `0.304 ms`
pub(super) fn exact_time(span: Option<Duration>) -> String {
    span.map_or_else(|| "-".into(), histogram::exact_milliseconds)
}

pub(super) fn or_dash(value: Option<impl fmt::Display>) -> String {
    value.map_or_else(|| "-".into(), |value| value.to_string())
}

/// Its product name, or else what is known of its identity, as far as there is room.
pub(super) fn device(node: &NodePicture, width: usize) -> String {
    if let Some(name) = product_name(&node.record.product_name) {
        return fit(&name, width);
    }
    let vendor = node.record.vendor.map(|vendor| format!("vendor {}", vendor.0));
    let product = node.record.product.map(|product| format!("product {product}"));
    let both = [vendor.clone(), product].into_iter().flatten().collect::<Vec<_>>().join(" ");
    let known = if both.len() <= width { both } else { vendor.unwrap_or(both) };
    if known.is_empty() { "-".into() } else { fit(&known, width) }
}

/// A text that has so much room, with an ellipsis if it has not.
pub(super) fn fit(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    let mut cut: String = text.chars().take(width.saturating_sub(1)).collect();
    cut.push('…');
    cut
}

/// `poll, COS/cyclic (timed out), explicit`: those that exist; a state only where something is to be said of it.
pub(super) fn connections(node: &NodePicture) -> String {
    let is_io =
        |connection: &&ConnectionRecord| connection.name != ConnectionName::Predefined(Predefined::Explicit);
    let words: Vec<String> = (node.live_connections().filter(is_io))
        .chain(node.live_connections().filter(|connection| !is_io(connection)))
        .map(|connection| {
            let name = short(&connection.name);
            match state(connection.state) {
                "" => name,
                state => format!("{name} ({state})"),
            }
        })
        .collect();
    if words.is_empty() { "-".into() } else { words.join(", ") }
}

/// The name of a connection, as short as it can be told.
pub(super) fn short(name: &ConnectionName) -> String {
    match name {
        ConnectionName::Predefined(which) => match which {
            Predefined::Explicit => "explicit",
            Predefined::Poll => "poll",
            Predefined::BitStrobe => "strobe",
            Predefined::CosCyclic => "COS/cyclic",
            Predefined::MulticastPoll => "multicast",
        }
        .into(),
        ConnectionName::Dynamic { group, .. } => format!("group {group}"),
    }
}

/// A state in a column of its own.
pub(super) const fn state_words(state: ConnectionState) -> &'static str {
    match state {
        ConnectionState::Unknown => "unknown",
        ConnectionState::NonExistent => "gone",
        ConnectionState::Configuring => "configuring",
        ConnectionState::WaitingForConnectionId => "waiting",
        ConnectionState::Established => "established",
        ConnectionState::TimedOut => "TIMED OUT",
        ConnectionState::DeferredDelete => "deferred",
    }
}

/// Attribute 12 of the Connection object: what happens when the watchdog runs out.
pub(super) const fn watchdog_words(action: u8) -> &'static str {
    match action {
        0 => "time-out",
        1 => "delete",
        2 => "reset",
        3 => "deferred",
        _ => "reserved",
    }
}

/// `0:01:23.4`: hours, minutes, seconds.
pub(super) fn clock(span: Duration) -> String {
    let tenths = span.as_millis() / 100;
    let (hours, minutes, seconds) = (tenths / 36_000, tenths / 600 % 60, tenths / 10 % 60);
    format!("{hours}:{minutes:02}:{seconds:02}.{}", tenths % 10)
}

/// What is to be said of a state beside a name: nothing if all is well, or nothing is known.
const fn state(state: ConnectionState) -> &'static str {
    match state {
        // Deferred delete is how an explicit connection waits while I/O goes on.
        ConnectionState::Established | ConnectionState::Unknown | ConnectionState::DeferredDelete => "",
        ConnectionState::NonExistent => "gone",
        ConnectionState::Configuring => "configuring",
        ConnectionState::WaitingForConnectionId => "waiting",
        ConnectionState::TimedOut => "timed out",
    }
}
