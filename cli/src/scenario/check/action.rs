//! `[[action]]`

use core::ops::Range;

use toml::Spanned;

use super::{Checker, list};
use crate::scenario::diagnostic::ScenarioError;
use crate::scenario::model::{Action, Do, Node, Role};
use crate::scenario::raw::RawAction;
use crate::scenario::values::rate;

impl Checker<'_> {
    pub(super) fn action(&self, table: &Spanned<RawAction>, nodes: &[Node]) -> Result<Action, ScenarioError> {
        let (raw, span) = (table.get_ref(), table.span());
        let at =
            self.moment("at", self.required(raw.at.as_ref(), &span, "`at`, the time of the action,")?)?;
        let name = self.required(raw.node.as_ref(), &span, "`node` of the action")?;
        let targets = self.named(name)?;
        let action = self.required(raw.action.as_ref(), &span, "`do` of the action")?;
        let what = self.what(raw, action, &span)?;
        let role = targets.first().and_then(|index| nodes.get(index.0)).map(|node| &node.role);
        if let (Do::SetMac(_) | Do::Reset, Some(role)) = (what, role)
            && !matches!(role, Role::Access(_))
        {
            return self.fail(
                &action.span(),
                format!(
                    "`{}` cannot be done to `{}`, whose role is `{}`; expected a node with the role `access`",
                    action.get_ref(),
                    name.get_ref(),
                    role.name()
                ),
            );
        }
        Ok(Action { at, nodes: targets, what })
    }

    fn what(
        &self,
        raw: &RawAction,
        action: &Spanned<String>,
        table: &Range<usize>,
    ) -> Result<Do, ScenarioError> {
        let plain = |what: Do| match &raw.value {
            None => Ok(what),
            Some(value) => self.fail(&value.span(), format!("`{}` takes no `value`", action.get_ref())),
        };
        match action.get_ref().as_str() {
            "cut" => plain(Do::Cut),
            "plug" => plain(Do::Plug),
            "power_off" => plain(Do::PowerOff),
            "power_on" => plain(Do::PowerOn),
            "power_cycle" => plain(Do::PowerCycle),
            "reset" => plain(Do::Reset),
            "set_mac" => Ok(Do::SetMac(self.mac_id("value", &self.integer(raw, table, "the MAC ID")?)?)),
            "set_bit_rate" => Ok(Do::SetBitRate(self.bit_rate("value", &self.rate(raw, table)?)?)),
            io @ ("set_input" | "set_output" | "go_idle" | "go_run") => self.fail(
                &action.span(),
                format!("`{io}` needs a node with I/O, which is not simulated; expected {}", list(ACTIONS)),
            ),
            other => {
                self.fail(&action.span(), format!("there is no action `{other}`; expected {}", list(ACTIONS)))
            }
        }
    }

    /// A bit rate: a number, or a text with a unit.
    fn rate(&self, raw: &RawAction, table: &Range<usize>) -> Result<Spanned<i64>, ScenarioError> {
        match &raw.value {
            Some(value) if let Some(rate) = value.get_ref().as_str().and_then(rate) => {
                Ok(Spanned::new(value.span(), rate))
            }
            _ => self.integer(raw, table, "the bit rate in bit/s"),
        }
    }

    fn integer(
        &self,
        raw: &RawAction,
        table: &Range<usize>,
        what: &str,
    ) -> Result<Spanned<i64>, ScenarioError> {
        let value = self.required(raw.value.as_ref(), table, &format!("`value`, {what},"))?;
        match value.get_ref() {
            toml::Value::Integer(number) => Ok(Spanned::new(value.span(), *number)),
            other => self
                .fail(&value.span(), format!("`value` is a {}; expected {what}, a number", other.type_str())),
        }
    }
}

pub(in crate::scenario) const ACTIONS: &[&str] =
    &["cut", "plug", "power_off", "power_on", "power_cycle", "set_mac", "set_bit_rate", "reset"];
