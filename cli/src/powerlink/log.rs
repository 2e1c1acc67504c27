//! What a station tells: a line of text each, or an object.

use core::fmt::Display;
use std::io;

use link_core::Instant;
use link_core::ethernet::LinkEvent;
use powerlink_core::NodeId;
use serde::Serialize;
use serde_json::{Map, Value};

use super::folds::{Folds, Told};
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
    losses: Losses,
}

impl Log {
    pub(super) fn new(node: NodeId, json: bool) -> Self {
        Self {
            output: Output::new(),
            json,
            name: node.to_string(),
            node: node.0,
            folds: Folds::default(),
            losses: Losses::default(),
        }
    }

    /// An event as it stands in the core: its name, and what it carries. One that others can cause without end may be held back.
    pub(super) fn event<E: Serialize + Display>(&mut self, now: Instant, event: &E) -> io::Result<()> {
        self.time(now)?;
        let (name, fields) = parts(event);
        let told = Told { name, fields, words: event.to_string() };
        if self.folds.admit(now, &told) {
            self.line(now, &told.name, told.fields, &told.words)
        } else {
            Ok(())
        }
    }

    /// Tells what was held back long enough.
    pub(super) fn time(&mut self, now: Instant) -> io::Result<()> {
        let due = self.folds.due(now);
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
        self.line(now, "inputs", fields, &words)
    }

    /// Process data.
    pub(super) fn data(&mut self, now: Instant, name: &str, data: &[u8], is_valid: bool) -> io::Result<()> {
        let hex = hex(data);
        let remark = if is_valid { "" } else { ", not valid" };
        let words = format!("{name} {hex}{remark}");
        self.line(now, name, fields([("data", hex.into()), ("valid", is_valid.into())]), &words)
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

    fn line(&mut self, now: Instant, event: &str, fields: Map<String, Value>, words: &str) -> io::Result<()> {
        let line = match self.json {
            true => {
                let mut object = Map::new();
                object.insert("t".into(), seconds(now).into());
                object.insert("node".into(), self.node.into());
                object.insert("event".into(), event.into());
                object.extend(fields);
                object.insert("text".into(), words.into());
                Value::Object(object).to_string()
            }
            false => format!("{now:.6}  {}  {words}", self.name),
        };
        self.output.buffer.extend_from_slice(line.as_bytes());
        self.output.buffer.push(b'\n');
        self.output.flush()
    }
}

/// The name of an event, and its fields; a single value is `value`.
fn parts(event: &impl Serialize) -> (String, Map<String, Value>) {
    match serde_json::to_value(event).unwrap_or_default() {
        Value::String(name) => (name, Map::new()),
        Value::Object(object) => match object.into_iter().next() {
            Some((name, Value::Object(fields))) => (name, fields),
            Some((name, value)) => (name, fields([("value", value)])),
            None => Default::default(),
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
