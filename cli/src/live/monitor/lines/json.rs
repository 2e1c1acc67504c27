//! One object a line, as `docs/json.md` has them.

use core::time::Duration;

use devicenet_core::doctor::Finding;
use devicenet_core::monitor::ConnectionRecord;
use link_core::Instant;
use serde_json::{Map, Value, json};

use crate::live::monitor::model::{Happening, Load, NodePicture, Picture, Purpose, Times};
use crate::text::product_name;

/// What has happened at a moment, and when the beginning was.
pub(super) fn event(at: Duration, what: &Happening, begin: Instant) -> Value {
    if let Happening::Finding(change) = what {
        let mut object = finding(&change.finding, begin);
        object["event"] = what.name().into();
        object["t"] = seconds(at).into();
        object["change"] = change.kind.to_string().into();
        return object;
    }
    let mut object = json!({ "event": what.name(), "t": seconds(at), "text": what.to_string() });
    if let Some(mac) = what.mac() {
        object["mac"] = mac.number().into();
    }
    match what {
        Happening::Link(state) => object["state"] = state.name().into(),
        Happening::Access { from, to, .. } => {
            object["from"] = from.name().into();
            object["to"] = to.name().into();
        }
        Happening::Connection { client, name, from, to, .. } => {
            object["connection"] = name.to_string().into();
            object["from"] = from.name().into();
            object["to"] = to.name().into();
            if let Some(client) = client {
                object["client"] = client.number().into();
            }
        }
        // It is an object of its own.
        Happening::Finding(_) => {}
        Happening::Lost(frames) => object["frames"] = (*frames).into(),
    }
    object
}

pub(super) fn summary(picture: &Picture, is_last: bool) -> Value {
    let problems =
        picture.problems.sorted().into_iter().map(
            |count| json!({ "problem": count.code, "severity": count.severity, "frames": count.frames }),
        );
    let mut object = json!({
        "event": "summary",
        "t": seconds(picture.at),
        "bit_rate": picture.bit_rate.rate().0,
        "bit_rate_source": picture.bit_rate.source(),
        "link": picture.link.name(),
        "frames": picture.counters.frames,
        "error_frames": picture.counters.error_frames,
        "lost": picture.counters.lost,
        "problems": picture.counters.problems,
        "span": seconds(picture.span),
        "load": load(&picture.load),
        "load_total": load(&picture.total),
        "nodes": picture.nodes.iter().map(node).collect::<Vec<_>>(),
        "verdict": picture.verdict,
        "problems_by_kind": problems.collect::<Vec<_>>(),
        "findings": picture.findings.iter().map(|found| finding(&found.finding, picture.begin)).collect::<Vec<_>>(),
    });
    if is_last {
        object["last"] = true.into();
    }
    put(&mut object, "tec", picture.counters.tec);
    put(&mut object, "rec", picture.counters.rec);
    object
}

/// As the doctor says it, but with times in seconds since the beginning, and `mac` as everywhere here.
fn finding(finding: &Finding, begin: Instant) -> Value {
    // A map with keys of text cannot fail.
    let mut object = serde_json::to_value(finding).unwrap_or_default();
    let time = |at: Instant| seconds(at.saturating_since(begin));
    object["since"] = time(finding.since).into();
    object["last"] = time(finding.last).into();
    put(&mut object, "until", finding.until.map(time));
    if let Some(fields) = object.as_object_mut()
        && let Some(node) = fields.remove("node")
    {
        fields.insert("mac".into(), node);
    }
    object
}

fn load(load: &Load) -> Value {
    let mut object = Map::new();
    object.insert("all".into(), part(load.all));
    for (purpose, share) in Purpose::ALL.into_iter().zip(load.by_purpose) {
        object.insert(purpose.name().into(), part(share));
    }
    object.into()
}

fn node(node: &NodePicture) -> Value {
    let NodePicture { record, .. } = node;
    let mut object = json!({
        "mac": record.mac.number(),
        "state": record.access.name(),
        "frames": record.traffic.frames,
        "load": part(node.load),
        "load_total": part(node.total),
        "connections": node.connections.iter().map(connection).collect::<Vec<_>>(),
    });
    put(&mut object, "vendor", record.vendor.map(|vendor| vendor.0));
    put(&mut object, "device_type", record.device_type.map(|device| device.0));
    put(&mut object, "product", record.product);
    put(&mut object, "revision", record.revision.map(|(major, minor)| format!("{major}.{minor}")));
    put(&mut object, "serial", record.serial);
    put(&mut object, "product_name", product_name(&node.record.product_name));
    put(&mut object, "master", record.master.map(|master| master.number()));
    put(&mut object, "silent", node.silent.map(seconds));
    put(&mut object, "io", node.io.map(times));
    put(&mut object, "explicit", node.explicit.map(times));
    put(&mut object, "limit", node.limit.map(seconds));
    object
}

fn connection(record: &ConnectionRecord) -> Value {
    let mut object = json!({
        "connection": record.name.to_string(),
        "state": record.state.name(),
        "frames": record.frames,
    });
    put(&mut object, "client", record.client.map(|client| client.number()));
    put(&mut object, "epr", record.epr);
    put(&mut object, "watchdog", record.watchdog_action);
    put(&mut object, "inhibit", record.inhibit);
    put(&mut object, "consumes", record.consumed_size);
    put(&mut object, "produces", record.produced_size);
    object
}

fn times(times: Times) -> Value {
    let Times { count, p50, p99, max } = times;
    json!({ "count": count, "p50": seconds(p50), "p99": seconds(p99), "max": seconds(max) })
}

fn put(object: &mut Value, key: &str, value: Option<impl Into<Value>>) {
    if let Some(value) = value {
        object[key] = value.into();
    }
}

fn seconds(span: Duration) -> f64 {
    span.as_nanos() as f64 / 1e9
}

/// Six decimals, which is less than a bit in a second.
fn part(share: f64) -> Value {
    ((share * 1e6).round() / 1e6).into()
}
