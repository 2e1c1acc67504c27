//! `[[expect]]`

use core::ops::Range;

use link_core::Instant;
use toml::Spanned;

use super::{Checker, list};
use crate::scenario::diagnostic::ScenarioError;
use crate::scenario::model::{EventName, Expectation, Node, Role, StateName, What, When};
use crate::scenario::raw::{RawExpect, Table};

impl Checker<'_> {
    pub(super) fn expectation(
        &self,
        table: &Spanned<RawExpect>,
        nodes: &[Node],
    ) -> Result<Expectation, ScenarioError> {
        let (raw, span) = (table.get_ref(), table.span());
        let when = self.when(raw, &span)?;
        let what = self.expected(raw, &span)?;
        if let (Some(event), When::At(_) | When::Always(..)) = (&raw.event, when) {
            return self.fail(
                &event.span(),
                "an event lasts no time; expected `by`, `from` and `to`, or `never` instead of `at` or `always`",
            );
        }
        let whom = match &raw.node {
            Some(name) => self.named(name)?,
            None if matches!(when, When::Never(..)) => Vec::new(),
            None => {
                return self.fail(
                    &span,
                    "`node` is missing; expected whom it is about (only `never` may be about all)",
                );
            }
        };
        if let Some(state) = &raw.state {
            let other = whom.iter().filter_map(|index| nodes.get(index.0));
            if let Some(node) = other.clone().find(|node| !matches!(node.role, Role::Access(_))) {
                return self.fail(
                    &state.span(),
                    format!(
                        "`{}` has the role `{}` and no state of network access; expected a node with the role \
                         `access`",
                        node.name,
                        node.role.name()
                    ),
                );
            }
        }
        let line = ScenarioError::at(self.file, self.text, &span, "").line;
        Ok(Expectation { line, nodes: whom, when, what })
    }

    /// One of `by`, `at`, `never`, or `from` and `to`, the last with or without `always`.
    fn when(&self, raw: &RawExpect, table: &Range<usize>) -> Result<When, ScenarioError> {
        let set = |flag: &Option<Spanned<bool>>| flag.as_ref().is_some_and(|flag| *flag.get_ref());
        let from = raw.from.as_ref().map(|from| self.moment("from", from)).transpose()?;
        let to = raw.to.as_ref().map(|to| self.moment("to", to)).transpose()?;
        let (first, last) = (from.unwrap_or(Instant::ZERO), to.unwrap_or(self.end));
        if last < first {
            return self.fail(table, "`to` is before `from`; expected a later time");
        }
        let ranged = from.is_some() || to.is_some();
        match (&raw.by, &raw.at, set(&raw.never), set(&raw.always)) {
            (Some(by), None, false, false) if !ranged => {
                Ok(When::Within(Instant::ZERO, self.moment("by", by)?))
            }
            (None, Some(at), false, false) if !ranged => Ok(When::At(self.moment("at", at)?)),
            (None, None, true, false) => Ok(When::Never(first, last)),
            (None, None, false, true) => Ok(When::Always(first, last)),
            (None, None, false, false) if ranged => Ok(When::Within(first, last)),
            (None, None, false, false) => self.fail(table, format!("there is no time; expected {TIMES}")),
            _ => self.fail(table, format!("there are several times; expected {TIMES}")),
        }
    }

    fn expected(&self, raw: &RawExpect, table: &Range<usize>) -> Result<What, ScenarioError> {
        if let Some((key, span)) = raw.keys().into_iter().find(|(key, _)| IO_KEYS.contains(key)) {
            return self.fail(
                &span,
                format!("`{key}` needs a node with I/O, which is not simulated; expected {}", list(WHAT)),
            );
        }
        let what = What {
            state: self.name("state", raw.state.as_ref(), StateName::ALL, StateName::name)?,
            tec: raw.tec.as_ref().map(|tec| *tec.get_ref()),
            rec: raw.rec.as_ref().map(|rec| *rec.get_ref()),
            bus_off: raw.bus_off.as_ref().map(|flag| *flag.get_ref()),
            event: self.name("event", raw.event.as_ref(), EventName::ALL, EventName::name)?,
        };
        if what == What::default() {
            return self.fail(table, format!("nothing is expected; expected one or more of {}", list(WHAT)));
        }
        Ok(what)
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
}

const TIMES: &str = "one of `by`, `at`, `from` and `to`, `always = true` or `never = true`";
pub(super) const IO_KEYS: &[&str] = &["connection", "connection_state", "input", "output"];
const WHAT: &[&str] = &["state", "tec", "rec", "bus_off", "event"];
