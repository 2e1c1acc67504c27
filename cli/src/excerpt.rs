//! A line of a file, and marks under what is meant, as a good compiler shows them.

use core::fmt;

/// Prints the line, and marks under a piece of it:
/// ```text
///    |
/// 12 | mac = 64
///    |       ^^
/// ```
#[derive(Clone, Copy, Debug)]
pub(crate) struct Excerpt<'a> {
    /// The number of the line.
    pub(crate) line: usize,
    /// The line without its end.
    pub(crate) text: &'a str,
    /// Where the marks begin, in characters from 1.
    pub(crate) column: usize,
    /// How many characters are marked.
    pub(crate) width: usize,
}

impl fmt::Display for Excerpt<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = self.line.to_string();
        let margin = " ".repeat(number.len());
        // Of a long line, a piece around the marks.
        let before = self.column.saturating_sub(1);
        let cut = if before + self.width > LONGEST { before.saturating_sub(LONGEST / 4) } else { 0 };
        let lead = if cut > 0 { "..." } else { "" };
        let printable = |character: char| match character {
            '\t' => '\t',
            control if control.is_control() => ' ',
            character => character,
        };
        let shown: String = self.text.chars().skip(cut).take(LONGEST).map(printable).collect();
        let rest = if self.text.chars().nth(cut + LONGEST).is_some() { "..." } else { "" };
        // Tabs stay tabs, so that the marks are below what they mean.
        let above = self.text.chars().chain(core::iter::repeat(' ')).skip(cut).take(before - cut);
        let indent: String = above.map(|character| if character == '\t' { '\t' } else { ' ' }).collect();
        let blanks = " ".repeat(lead.len()) + &indent;
        let marks = "^".repeat(self.width.clamp(1, LONGEST.saturating_sub(before - cut).max(1)));
        writeln!(f, "{margin} |")?;
        writeln!(f, "{number} | {lead}{}{rest}", shown.trim_end())?;
        write!(f, "{margin} | {blanks}{marks}")
    }
}

const LONGEST: usize = 160;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_with_a_tab() {
        let excerpt = Excerpt { line: 9, text: "\tProdCode = x;", column: 13, width: 1 };
        assert_eq!(excerpt.to_string(), "  |\n9 | \tProdCode = x;\n  | \t           ^");
    }

    #[test]
    fn a_long_line_is_cut() {
        let text = "x".repeat(500);
        let shown = Excerpt { line: 1, text: &text, column: 301, width: 400 }.to_string();
        let lines: Vec<_> = shown.lines().collect();
        assert_eq!(lines[1], format!("1 | ...{}...", "x".repeat(160)));
        assert_eq!(lines[2], format!("  | {}{}", " ".repeat(43), "^".repeat(120)));
        let start = Excerpt { line: 1, text: &text, column: 1, width: 3 }.to_string();
        assert!(start.ends_with("...\n  | ^^^"));
    }
}
