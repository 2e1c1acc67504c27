//! `[[expect]]`

use core::ops::Range;

use link_core::Instant;
use toml::Spanned;

use super::{Checker, list};
use crate::scenario::diagnostic::ScenarioError;
use crate::scenario::model::{EventName, Expectation, Node, StateName, What, When};
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
            None if matches!(when, When::Never(..)) => {
                if !nodes.iter().any(|node| node.role.can_be(&what)) {
                    return self.fail(&span, "there is no node of which this could be expected");
                }
                Vec::new()
            }
            None => {
                return self.fail(
                    &span,
                    "`node` is missing; expected whom it is about (only `never` may be about all)",
                );
            }
        };
        let mut named = whom.iter().filter_map(|index| nodes.get(index.0));
        if let Some(node) = named.find(|node| !node.role.can_be(&what)) {
            return self.unfit(raw, node, &span);
        }
        let line = ScenarioError::at(self.file, self.text, &span, "").line;
        Ok(Expectation { line, nodes: whom, when, what })
    }

    /// What is expected cannot come from a node of this role.
    fn unfit<T>(&self, raw: &RawExpect, node: &Node, table: &Range<usize>) -> Result<T, ScenarioError> {
        let (name, role) = (&node.name, node.role.name());
        let here = format!("`{name}` has the role `{role}` and");
        match (&raw.state, &raw.event) {
            (Some(state), _) => self.fail(
                &state.span(),
                format!("{here} no state of network access; expected a node with the role `access`"),
            ),
            (None, Some(event)) if event.get_ref() == EventName::Sent.name() => {
                self.fail(&event.span(), format!("{here} never sends; expected a node with another role"))
            }
            (None, Some(event)) => self.fail(
                &event.span(),
                format!(
                    "{here} no event `{}`, which is one of network access; expected a node with the role `access`",
                    event.get_ref()
                ),
            ),
            (None, None) => self.fail(table, format!("{here} cannot be what is expected")),
        }
    }

    /// `never` and `always`: true, or not there.
    fn is_set(&self, key: &str, flag: Option<&Spanned<bool>>) -> Result<bool, ScenarioError> {
        match flag {
            Some(flag) if !flag.get_ref() => self.fail(
                &flag.span(),
                format!("`{key}` is false, which says nothing; expected `{key} = true`, or no `{key}`"),
            ),
            flag => Ok(flag.is_some()),
        }
    }

    /// One of `by`, `at`, `never`, or `from` and `to`, the last with or without `always`.
    fn when(&self, raw: &RawExpect, table: &Range<usize>) -> Result<When, ScenarioError> {
        let never = self.is_set("never", raw.never.as_ref())?;
        let always = self.is_set("always", raw.always.as_ref())?;
        let from = raw.from.as_ref().map(|from| self.moment("from", from)).transpose()?;
        let to = raw.to.as_ref().map(|to| self.moment("to", to)).transpose()?;
        let first = from.unwrap_or(Instant::ZERO);
        if let (Some(last), Some(place)) = (to, &raw.to)
            && last < first
        {
            return self.fail(&place.span(), "`to` is before `from`; expected a later time");
        }
        let ranged = from.is_some() || to.is_some();
        match (&raw.by, &raw.at, never, always) {
            (Some(by), None, false, false) if !ranged => {
                Ok(When::Within(Instant::ZERO, Some(self.moment("by", by)?)))
            }
            (None, Some(at), false, false) if !ranged => Ok(When::At(self.moment("at", at)?)),
            (None, None, true, false) => Ok(When::Never(first, to)),
            (None, None, false, true) => Ok(When::Always(first, to)),
            (None, None, false, false) if ranged => Ok(When::Within(first, to)),
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
