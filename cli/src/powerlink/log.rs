//! What a station tells: a line of text each, or an object.

use core::fmt::Display;
use core::time::Duration;
use std::io;

use link_core::Instant;
use link_core::ethernet::LinkEvent;
use powerlink_core::NodeId;
use serde::Serialize;
use serde_json::{Map, Value};

use super::folds::{Folds, Told};
use super::limits::Limits;
use crate::losses::Losses;
use crate::output::Output;
use crate::text::{self, LOWER, push_hex};

pub(super) struct Log {
    output: Output,
    json: bool,
    /// Who tells, in text.
    name: String,
    /// The same in JSON.
    node: u8,
    folds: Folds,
    limits: Limits,
    losses: Losses,
    is_muted: bool,
}

impl Log {
    pub(super) fn new(node: NodeId, json: bool) -> Self {
        Self {
            output: Output::new(),
            json,
            name: node.to_string(),
            node: node.0,
            folds: Folds::default(),
            limits: Limits::default(),
            losses: Losses::default(),
            is_muted: false,
        }
    }

    /// The first line: when it was 0 o'clock, since 1970.
    pub(super) fn start(&mut self, now: Instant, zero: Duration) -> io::Result<()> {
        let micros = zero.as_micros();
        let words = format!(
            "starts; time 0 is {}.{:06} s since 1970-01-01 UTC",
            micros / 1_000_000,
            micros % 1_000_000
        );
        self.line(now, "start", fields([("unix_time", (micros as f64 / 1e6).into())]), &words)
    }

    /// Tells nothing any more: there is nobody who reads it.
    pub(super) const fn mute(&mut self) {
        self.is_muted = true;
    }

    /// An event as it stands in the core: its name, and what it carries. One that comes too often may be held back.
    pub(super) fn event<E: Serialize + Display>(&mut self, now: Instant, event: &E) -> io::Result<()> {
        let (name, fields) = parts(event);
        self.tell(now, Told { name, fields, words: event.to_string() })
    }

    fn tell(&mut self, now: Instant, told: Told) -> io::Result<()> {
        self.time(now)?;
        let is_told = match Folds::concern(&told) {
            true => self.folds.admit(now, &told),
            false => self.limits.admit(now, &told),
        };
        if is_told { self.line(now, &told.name, told.fields, &told.words) } else { Ok(()) }
    }

    /// Tells what was held back long enough.
    pub(super) fn time(&mut self, now: Instant) -> io::Result<()> {
        let due = self.folds.due(now);
        self.held_back(now, due)?;
        let due = self.limits.due(now);
        self.held_back(now, due)?;
        match self.losses.due(now) {
            Some(count) => self.lost(now, count),
            None => Ok(()),
        }
    }

    fn held_back(&mut self, now: Instant, told: Vec<Told>) -> io::Result<()> {
        told.into_iter().try_for_each(|told| self.line(now, &told.name, told.fields, &told.words))
    }

    fn lost(&mut self, now: Instant, count: u32) -> io::Result<()> {
        let words = format!("{} lost", text::count(count.into(), "frame"));
        self.line(now, "lost", fields([("frames", count.into())]), &words)
    }

    /// News of the interface. What is not sent is counted: there may be much of it.
    pub(super) fn link(&mut self, now: Instant, event: LinkEvent) -> io::Result<()> {
        match event {
            LinkEvent::Up => self.line(now, "link", fields([("state", "up".into())]), "link up"),
            LinkEvent::Down => self.line(now, "link", fields([("state", "down".into())]), "link down"),
            LinkEvent::FramesLost { count } => {
                self.losses.add(count);
                self.time(now)
            }
            LinkEvent::CrcError | LinkEvent::Collision | LinkEvent::NotSent => Ok(()),
        }
    }

    /// Process data of another node, if there are any.
    pub(super) fn inputs(&mut self, now: Instant, node: NodeId, data: Option<&[u8]>) -> io::Result<()> {
        let mut fields = fields([("node", node.0.into()), ("valid", data.is_some().into())]);
        let words = match data.map(hex) {
            Some(hex) => {
                let words = format!("{node}: inputs {hex}");
                fields.insert("data".into(), hex.into());
                words
            }
            None => format!("{node}: no inputs"),
        };
        self.tell(now, Told { name: "inputs".to_owned(), fields, words })
    }

    /// Process data of this node.
    pub(super) fn outputs(&mut self, now: Instant, data: &[u8], is_valid: bool) -> io::Result<()> {
        let hex = hex(data);
        let remark = if is_valid { "" } else { ", not valid" };
        let words = format!("outputs {hex}{remark}");
        let fields = fields([("data", hex.into()), ("valid", is_valid.into())]);
        self.tell(now, Told { name: "outputs".to_owned(), fields, words })
    }

    /// The last line: where it ended, and what was counted.
    pub(super) fn end(
        &mut self,
        now: Instant,
        state: &(impl Serialize + Display),
        counters: &impl Serialize,
    ) -> io::Result<()> {
        let rest = self.folds.rest(now);
        self.held_back(now, rest)?;
        let rest = self.limits.rest(now);
        self.held_back(now, rest)?;
        if let Some(count) = self.losses.rest() {
            self.lost(now, count)?;
        }
        let counters = serde_json::to_value(counters).unwrap_or_default();
        let counted: Vec<String> = counters
            .as_object()
            .into_iter()
            .flatten()
            .filter(|(_, count)| count.as_u64() != Some(0))
            .map(|(name, count)| format!("{} {count}", name.replace('_', " ")))
            .collect();
        let list = if counted.is_empty() { String::new() } else { format!(": {}", counted.join(", ")) };
        let words = format!("ends in {state}{list}");
        let state = serde_json::to_value(state).unwrap_or_default();
        self.line(now, "end", fields([("state", state), ("counters", counters)]), &words)
    }

    fn line(
        &mut self,
        now: Instant,
        event: &str,
        mut fields: Map<String, Value>,
        words: &str,
    ) -> io::Result<()> {
        if self.is_muted {
            return Ok(());
        }
        let line = match self.json {
            true => {
                let node = fields.remove("node").unwrap_or_else(|| self.node.into());
                let line = Line { t: seconds(now), node, event, fields, text: words };
                // Numbers and strings: nothing in it can fail.
                serde_json::to_string(&line).unwrap_or_default()
            }
            false => format!("{now:.6}  {}  {words}", self.name),
        };
        self.output.buffer.extend_from_slice(line.as_bytes());
        self.output.buffer.push(b'\n');
        self.output.flush()
    }
}

/// An object, in this order.
#[derive(Serialize)]
struct Line<'a> {
    t: f64,
    /// Whom it is about.
    node: Value,
    event: &'a str,
    #[serde(flatten)]
    fields: Map<String, Value>,
    text: &'a str,
}

/// The name of an event, and its fields.
fn parts(event: &impl Serialize) -> (String, Map<String, Value>) {
    match serde_json::to_value(event).unwrap_or_default() {
        Value::Object(mut fields) => match fields.remove("event") {
            Some(Value::String(name)) => (name, fields),
            _ => Default::default(),
        },
        _ => Default::default(),
    }
}

fn fields<const N: usize>(fields: [(&str, Value); N]) -> Map<String, Value> {
    fields.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

fn hex(bytes: &[u8]) -> String {
    let mut text = Vec::new();
    push_hex(&mut text, bytes, LOWER);
    String::from_utf8(text).unwrap_or_default()
}

fn seconds(at: Instant) -> f64 {
    at.as_nanos() as f64 / 1e9
}
