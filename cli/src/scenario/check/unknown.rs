//! A key that nobody knows: which are known there, and which was meant.

use core::ops::Range;

use serde::Deserialize;
use toml::Spanned;

use super::fault::fault_keys;
use super::list;
use super::node::{ROLES, role_keys};
use crate::scenario::raw::{RawFault, RawNode, Table as _};

/// The words for an unknown key, from those of the TOML reader; `None` if it complains of something else.
pub(super) fn key(message: &str, text: &str, span: &Range<usize>) -> Option<String> {
    let rest = message.strip_prefix("unknown field `")?;
    let (found, expected) = rest.split_once('`')?;
    // Every other part between backticks is a name.
    let known: Vec<&str> = expected.split('`').skip(1).step_by(2).collect();
    let (known, here) = if known == RawNode::KEYS {
        keys_of_node(text, span)
    } else if known == RawFault::KEYS {
        keys_of_fault(text, span)
    } else {
        (known, String::new())
    };
    let meant = closest(found, &known).map(|key| format!(", did you mean `{key}`?")).unwrap_or_default();
    let semicolon = if meant.is_empty() { ";" } else { "" };
    Some(format!("there is no key `{found}`{here}{meant}{semicolon} expected {}", list(&known)))
}

/// What the node takes that the span lies in, by its role.
fn keys_of_node(text: &str, span: &Range<usize>) -> (Vec<&'static str>, String) {
    let role = value_at(text, span, |tables| tables.node, "role");
    if let (Some(role), Some(keys)) = (&role, role.as_deref().and_then(role_keys)) {
        return (keys, format!(" for the role `{role}`"));
    }
    let is_taken =
        |key: &&str| ROLES.iter().any(|role| role_keys(role).is_some_and(|keys| keys.contains(key)));
    (RawNode::KEYS.iter().copied().filter(is_taken).collect(), String::new())
}

/// What the fault takes that the span lies in, by its kind.
fn keys_of_fault(text: &str, span: &Range<usize>) -> (Vec<&'static str>, String) {
    let kind = value_at(text, span, |tables| tables.fault, "kind");
    if let (Some(kind), Some(keys)) = (&kind, kind.as_deref().and_then(fault_keys)) {
        return (keys, format!(" for the fault `{kind}`"));
    }
    (RawFault::KEYS.to_vec(), String::new())
}

/// The tables whose keys depend on one of them.
#[derive(Deserialize, Default)]
struct Tables {
    #[serde(default)]
    node: Vec<Spanned<toml::Table>>,
    #[serde(default)]
    fault: Vec<Spanned<toml::Table>>,
}

/// The value of a key in the table that the span lies in.
fn value_at(
    text: &str,
    span: &Range<usize>,
    kind: fn(Tables) -> Vec<Spanned<toml::Table>>,
    key: &str,
) -> Option<String> {
    let tables = kind(toml::from_str(text).unwrap_or_default());
    let table = tables.iter().rev().find(|table| table.span().start <= span.start)?;
    Some(table.get_ref().get(key)?.as_str()?.to_owned())
}

/// The known name that differs by a slip of the finger.
pub(super) fn closest<'a>(found: &str, known: &[&'a str]) -> Option<&'a str> {
    let distance = |key: &&&str| strsim::osa_distance(found, key);
    known.iter().min_by_key(distance).filter(|key| distance(key) <= (key.len() / 3).max(1)).copied()
}
