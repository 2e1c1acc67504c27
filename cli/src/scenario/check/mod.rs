//! From what the file says to what it means, or to what is wrong with it.

mod action;
mod device;
mod expect;
mod fault;
mod master;
mod nex;
mod node;
mod plan;
mod slave;
mod unknown;

#[cfg(test)]
pub(super) use action::ACTIONS;
#[cfg(test)]
pub(super) use fault::FAULTS;
#[cfg(test)]
pub(super) use node::ROLES;

use core::ops::Range;
use core::time::Duration;
use std::collections::HashMap;
use std::path::Path;

use link_core::{BitRate, Frame, Instant, StandardId};
use toml::Spanned;

use super::diagnostic::ScenarioError;
use super::model::{Bus, NodeIndex, Note, Scenario};
use super::raw::{RawBus, RawNode, RawNote, RawScenario, Table};
use super::values::{RateSetting, Time};

/// Reads and checks the text of a scenario. Files that it names are looked for in `folder`.
pub(super) fn scenario(file: &str, text: &str, folder: &Path) -> Result<Scenario, ScenarioError> {
    let raw: RawScenario = toml::from_str(text).map_err(|error| toml_error(file, text, &error))?;
    let mut check = Checker { file, text, folder, names: HashMap::new(), end: Instant::ZERO };

    let Some(bus) = &raw.bus else {
        return Err(ScenarioError::of_file(
            file,
            "there is no table [bus]; expected [bus] and at least one [[node]]",
        ));
    };
    let bus = check.bus(bus)?;
    check.end = Instant::ZERO + bus.duration;

    let mut nodes = Vec::new();
    for table in &raw.node {
        check.node(table, bus.bit_rate, &mut nodes)?;
    }
    if nodes.is_empty() {
        return Err(ScenarioError::of_file(file, "there is no [[node]]; expected at least one"));
    }
    check.one_protocol(&raw.node)?;
    check.plans(&raw.node, &mut nodes)?;
    Ok(Scenario {
        file: file.to_owned(),
        title: raw.title,
        actions: each(&raw.action, |table| check.action(table, &nodes))?,
        faults: check.faults(&raw.fault, &nodes)?,
        expectations: each(&raw.expect, |table| check.expectation(table, &nodes))?,
        notes: each(&raw.note, |table| check.note(table))?,
        bus,
        nodes,
    })
}

/// What the TOML reader complains of, in our words.
pub(crate) fn toml_error(file: &str, text: &str, error: &toml::de::Error) -> ScenarioError {
    let span = error.span().unwrap_or_default();
    if let Some(message) = unknown::key(error.message(), text, &span) {
        return ScenarioError::at(file, text, &span, message);
    }
    if error.message().starts_with("invalid type: map, expected a sequence") {
        return ScenarioError::at(file, text, &span, one_of_a_list(text, &span));
    }
    let message = error.message().replace("expected i64", "expected a whole number");
    ScenarioError::at(file, text, &span, message.replace("expected f64", "expected a number such as 1e-4"))
}

/// The words for a table where a list of tables is expected.
fn one_of_a_list(text: &str, span: &Range<usize>) -> String {
    let found = text.get(span.start..).unwrap_or_default();
    let before = text.get(..span.start).unwrap_or_default();
    if let Some((list, _)) = found.split_once(']').and_then(|(header, _)| header.split_once('.'))
        && before.ends_with("[[")
    {
        let header = found.split(']').next().unwrap_or_default();
        return format!("`[[{header}]]` belongs below a `[[{list}]]`, and there is none before it");
    }
    match found.strip_prefix('[').and_then(|header| header.split_once(']')) {
        Some((name, _)) => format!("`[{name}]` is one table; expected `[[{name}]]`, as many as there are"),
        None => "expected a list, such as [{ .. }]".to_owned(),
    }
}

fn each<T, U>(items: &[T], check: impl Fn(&T) -> Result<U, ScenarioError>) -> Result<Vec<U>, ScenarioError> {
    items.iter().map(check).collect()
}

/// What the checks share.
struct Checker<'a> {
    file: &'a str,
    text: &'a str,
    folder: &'a Path,
    /// The nodes of each name; several when the node has a `count`.
    names: HashMap<String, Vec<NodeIndex>>,
    /// The end of the run.
    end: Instant,
}

impl Checker<'_> {
    fn fail<T>(&self, span: &Range<usize>, message: impl Into<String>) -> Result<T, ScenarioError> {
        Err(ScenarioError::at(self.file, self.text, span, message))
    }

    /// The value of a key that must be there.
    fn required<'v, T>(
        &self,
        value: Option<&'v Spanned<T>>,
        table: &Range<usize>,
        what: &str,
    ) -> Result<&'v Spanned<T>, ScenarioError> {
        match value {
            Some(value) => Ok(value),
            None => self.fail(table, format!("{what} is missing")),
        }
    }

    /// Refuses every key but those that mean something here.
    fn only(&self, table: &impl Table, allowed: &[&str], here: &str) -> Result<(), ScenarioError> {
        match table.keys().into_iter().find(|(key, _)| !allowed.contains(key)) {
            None => Ok(()),
            Some((key, span)) => {
                self.fail(&span, format!("`{key}` means nothing for {here}; expected {}", list(allowed)))
            }
        }
    }

    /// A number in a range.
    fn number<T: TryFrom<i64>>(
        &self,
        key: &str,
        value: &Spanned<i64>,
        least: i64,
        greatest: i64,
        what: &str,
    ) -> Result<T, ScenarioError> {
        let found = *value.get_ref();
        match T::try_from(found) {
            Ok(number) if (least..=greatest).contains(&found) => Ok(number),
            _ => self.fail(&value.span(), format!("`{key}` is {found}; expected {what}")),
        }
    }

    fn mac_id(&self, key: &str, value: &Spanned<i64>) -> Result<u8, ScenarioError> {
        self.number(key, value, 0, 63, "a MAC ID, 0 to 63")
    }

    /// Both protocols on one bus would share identifiers.
    fn one_protocol(&self, nodes: &[Spanned<RawNode>]) -> Result<(), ScenarioError> {
        let mut named = nodes.iter().filter_map(|node| node.get_ref().protocol.as_ref());
        let Some(first) = named.next() else { return Ok(()) };
        match named.find(|protocol| protocol.get_ref() != first.get_ref()) {
            None => Ok(()),
            Some(other) => self.fail(
                &other.span(),
                format!(
                    "`{}` beside `{}` on one bus; expected one protocol, since both would use the same identifiers",
                    other.get_ref(),
                    first.get_ref()
                ),
            ),
        }
    }

    fn rate_setting(&self, setting: &Spanned<RateSetting>) -> Result<BitRate, ScenarioError> {
        match setting.get_ref() {
            RateSetting::Fixed(rate) => self.bit_rate("bit_rate", &Spanned::new(setting.span(), *rate)),
            RateSetting::Auto => self.fail(
                &setting.span(),
                "`bit_rate` is \"auto\", and only a slave or a device detects the bit rate; expected a rate in bit/s",
            ),
        }
    }

    fn bit_rate(&self, key: &str, value: &Spanned<i64>) -> Result<BitRate, ScenarioError> {
        match u32::try_from(*value.get_ref()).ok().filter(|rate| BIT_RATES.contains(rate)) {
            Some(rate) => Ok(BitRate(rate)),
            None => self.fail(
                &value.span(),
                format!(
                    "`{key}` is {}; expected a bit rate in bit/s: {}",
                    value.get_ref(),
                    list(&BIT_RATES.map(|rate| rate.to_string()))
                ),
            ),
        }
    }

    /// One of a closed set of names.
    fn name<T: Copy>(
        &self,
        key: &str,
        value: Option<&Spanned<String>>,
        all: &[T],
        name: fn(T) -> &'static str,
    ) -> Result<Option<T>, ScenarioError> {
        let Some(value) = value else { return Ok(None) };
        if let Some(found) = all.iter().find(|item| name(**item) == value.get_ref()) {
            return Ok(Some(*found));
        }
        let names: Vec<&str> = all.iter().map(|item| name(*item)).collect();
        self.fail(
            &value.span(),
            format!("there is no {key} `{}`; expected {}", value.get_ref(), list(&names)),
        )
    }

    fn ppm(&self, key: &str, value: &Spanned<i64>) -> Result<i32, ScenarioError> {
        self.number(key, value, -100_000, 100_000, "millionths, -100000 to 100000")
    }

    fn probability(&self, value: &Spanned<f64>) -> Result<f64, ScenarioError> {
        match *value.get_ref() {
            rate if (0.0..=1.0).contains(&rate) => Ok(rate),
            rate => self.fail(&value.span(), format!("`rate` is {rate}; expected a probability, 0 to 1")),
        }
    }

    /// `7ED#0A4D341245230000`, as candump writes a frame: three or eight hex digits, `#`, data.
    fn frame(&self, value: &Spanned<String>) -> Result<Frame, ScenarioError> {
        match parse_frame(value.get_ref()) {
            Some(frame) => Ok(frame),
            None => self.fail(
                &value.span(),
                format!(
                    "`{}` is not a frame; expected one such as \"7ED#0A4D341245230000\"",
                    value.get_ref()
                ),
            ),
        }
    }

    /// A moment of the run.
    fn moment(&self, key: &str, value: &Spanned<Time>) -> Result<Instant, ScenarioError> {
        let Time(time) = *value.get_ref();
        let at = Instant::ZERO + time;
        if at > self.end {
            let (time, end) = (Time(time), Time(self.end.saturating_since(Instant::ZERO)));
            return self.fail(
                &value.span(),
                format!("`{key}` is {time}, after the end of the run; expected at most the duration, {end}"),
            );
        }
        Ok(at)
    }

    /// The nodes of a name.
    fn nodes(&self, name: &str, span: &Range<usize>) -> Result<Vec<NodeIndex>, ScenarioError> {
        if let Some(nodes) = self.names.get(name) {
            return Ok(nodes.clone());
        }
        let mut known: Vec<&str> = self.names.keys().map(String::as_str).collect();
        known.sort_unstable();
        let expected = match (known.len() > MOST_LISTED, unknown::closest(name, &known)) {
            (false, _) => list(&known),
            (true, Some(meant)) => format!("`{meant}` perhaps, or another `name` of a [[node]]"),
            (true, None) => "a `name` of a [[node]]".to_owned(),
        };
        self.fail(span, format!("there is no node `{name}`; expected {expected}"))
    }

    fn named(&self, name: &Spanned<String>) -> Result<Vec<NodeIndex>, ScenarioError> {
        self.nodes(name.get_ref(), &name.span())
    }

    fn bus(&self, bus: &RawBus) -> Result<Bus, ScenarioError> {
        let bit_rate = match &bus.bit_rate {
            Some(rate) => self.rate_setting(rate)?,
            None => BitRate::K125,
        };
        let seed = match &bus.seed {
            Some(seed) => self.number("seed", seed, 0, i64::MAX, "a number from 0")?,
            None => 1,
        };
        let duration = match &bus.duration {
            None => Duration::from_secs(10),
            Some(time) if time.get_ref().0 <= LONGEST_RUN && !time.get_ref().0.is_zero() => time.get_ref().0,
            Some(time) => {
                let (found, longest) = (time.get_ref(), Time(LONGEST_RUN));
                return self.fail(
                    &time.span(),
                    format!("`duration` is {found}; expected more than 0s, at most {longest}"),
                );
            }
        };
        Ok(Bus { bit_rate, seed, duration })
    }

    fn note(&self, table: &Spanned<RawNote>) -> Result<Note, ScenarioError> {
        let (note, span) = (table.get_ref(), table.span());
        let at = self.moment("at", self.required(note.at.as_ref(), &span, "`at`, the time of the note,")?)?;
        let text = self.required(note.text.as_ref(), &span, "`text`, the words of the note,")?;
        Ok(Note { at, text: text.get_ref().clone() })
    }
}

/// `a, b or c`
fn list<T: AsRef<str>>(items: &[T]) -> String {
    let quoted: Vec<String> = items.iter().map(|item| format!("`{}`", item.as_ref())).collect();
    match quoted.split_last() {
        None => "nothing".to_owned(),
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} or {last}", others.join(", ")),
    }
}

fn parse_frame(text: &str) -> Option<Frame> {
    let (id, data) = text.split_once('#')?;
    let number = u32::from_str_radix(id, 16).ok()?;
    let bytes = crate::text::hex_bytes(data)?;
    match id.len() {
        3 => Frame::new(StandardId::new(u16::try_from(number).ok()?)?, &bytes),
        8 => Frame::new(link_core::ExtendedId::new(number)?, &bytes),
        _ => None,
    }
}

/// 10 kbit/s to 1 Mbit/s in the steps that CAN networks use; a bit is a whole number of nanoseconds in each.
const BIT_RATES: [u32; 8] = [10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 1_000_000];
/// Names that an error lists.
const MOST_LISTED: usize = 16;
/// The longest run.
pub const LONGEST_RUN: Duration = Duration::from_secs(24 * 3_600);
