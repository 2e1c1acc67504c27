//! What is wrong with a scenario file, and where.

use core::fmt;
use core::ops::Range;

use crate::excerpt::Excerpt;
use crate::text::printable;

/// A defect of a scenario: file, line and column, what was found and what was expected.
///
/// Its `Display` shows the place, the words, and the offending line:
/// ```text
/// plant.toml:12:7: `mac` is 64; expected a MAC ID, 0 to 63
///    |
/// 12 | mac = 64
///    |       ^^
/// ```
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ScenarioError {
    /// The file as the user named it.
    pub file: String,
    /// From 1; 0 when the file as a whole is meant, such as one that cannot be read.
    pub line: usize,
    /// In characters, from 1.
    pub column: usize,
    /// What was found, and what was expected.
    pub message: String,
    /// The offending line.
    excerpt: String,
    /// How many characters of it are meant, from `column` on.
    width: usize,
}

impl ScenarioError {
    /// A defect of the bytes `span` of `text`.
    pub(crate) fn at(file: &str, text: &str, span: &Range<usize>, message: impl Into<String>) -> Self {
        let start = span.start.min(text.len());
        let before = text.get(..start).unwrap_or(text);
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        let excerpt = text.get(line_start..).unwrap_or_default().lines().next().unwrap_or_default();
        let column = before.get(line_start..).unwrap_or_default().chars().count() + 1;
        let line_end = line_start + excerpt.len();
        let marked = text.get(start..span.end.min(line_end)).unwrap_or_default();
        Self {
            file: file.to_owned(),
            line: before.matches('\n').count() + 1,
            column,
            message: message.into(),
            excerpt: excerpt.to_owned(),
            width: marked.chars().count().max(1),
        }
    }

    /// A defect of the file as a whole.
    pub(crate) fn of_file(file: &str, message: impl Into<String>) -> Self {
        Self {
            file: file.to_owned(),
            line: 0,
            column: 0,
            message: message.into(),
            excerpt: String::new(),
            width: 0,
        }
    }
}

impl fmt::Display for ScenarioError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.line == 0 {
            return write!(f, "{}: {}", self.file, self.message);
        }
        writeln!(f, "{}:{}:{}: {}", self.file, self.line, self.column, printable(&self.message))?;
        let Self { line, column, width, .. } = *self;
        Excerpt { line, text: &self.excerpt, column, width }.fmt(f)
    }
}

impl core::error::Error for ScenarioError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_characters_and_marks_stay_on_the_line() {
        let text = "title = \"é\"\nmac = [64,\n65]\n";
        let start = text.find("[64").unwrap();
        let error = ScenarioError::at("a.toml", text, &(start..text.len()), "wrong");
        assert_eq!((error.line, error.column), (2, 7));
        assert_eq!(error.to_string(), "a.toml:2:7: wrong\n  |\n2 | mac = [64,\n  |       ^^^^");
        let accent = text.find("\"\n").unwrap();
        assert_eq!(ScenarioError::at("a.toml", text, &(accent..accent + 1), "x").column, 11);
    }

    #[test]
    fn the_mark_stands_below_what_follows_a_tab() {
        let error = ScenarioError::at("a.toml", "\tmac = 64", &(7..9), "wrong");
        assert_eq!(error.to_string(), "a.toml:1:8: wrong\n  |\n1 | \tmac = 64\n  | \t      ^^");
    }

    #[test]
    fn a_span_past_the_end_is_the_end() {
        let error = ScenarioError::at("a.toml", "x", &(7..9), "wrong");
        assert_eq!((error.line, error.column), (1, 2));
    }
}
