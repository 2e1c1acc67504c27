//! A key that nobody knows: which are known there, and which was meant.

use core::ops::Range;

use serde::Deserialize;
use toml::Spanned;

use super::expect::IO_KEYS;
use super::list;
use super::node::{ROLES, role_keys};
use crate::scenario::raw::{RawExpect, RawNode, Table as _};

/// The words for an unknown key, from those of the TOML reader; `None` if it complains of something else.
pub(super) fn key(message: &str, text: &str, span: &Range<usize>) -> Option<String> {
    let rest = message.strip_prefix("unknown field `")?;
    let (found, expected) = rest.split_once('`')?;
    // Every other part between backticks is a name.
    let known: Vec<&str> = expected.split('`').skip(1).step_by(2).collect();
    let (known, here) = if known == RawNode::KEYS {
        keys_of_node(text, span)
    } else if known == RawExpect::KEYS {
        (known.into_iter().filter(|key| !IO_KEYS.contains(key)).collect(), String::new())
    } else {
        (known, String::new())
    };
    let meant = closest(found, &known).map(|key| format!(", did you mean `{key}`?")).unwrap_or_default();
    let semicolon = if meant.is_empty() { ";" } else { "" };
    Some(format!("there is no key `{found}`{here}{meant}{semicolon} expected {}", list(&known)))
}

/// What the node takes that the span lies in, by its role.
fn keys_of_node(text: &str, span: &Range<usize>) -> (Vec<&'static str>, String) {
    #[derive(Deserialize)]
    struct Nodes {
        node: Vec<Spanned<toml::Table>>,
    }
    let nodes = toml::from_str::<Nodes>(text).map(|nodes| nodes.node).unwrap_or_default();
    let node = nodes.iter().rev().find(|node| node.span().start <= span.start);
    let role = node.and_then(|node| node.get_ref().get("role")?.as_str());
    if let Some((role, keys)) = role.and_then(|role| Some((role, role_keys(role)?))) {
        return (keys, format!(" for the role `{role}`"));
    }
    let is_taken =
        |key: &&str| ROLES.iter().any(|role| role_keys(role).is_some_and(|keys| keys.contains(key)));
    (RawNode::KEYS.iter().copied().filter(is_taken).collect(), String::new())
}

/// The known key that differs by a slip of the finger.
fn closest<'a>(found: &str, known: &[&'a str]) -> Option<&'a str> {
    let distance = |key: &&&str| strsim::osa_distance(found, key);
    known.iter().min_by_key(distance).filter(|key| distance(key) <= (key.len() / 3).max(1)).copied()
}
