//! A quote that is missing on a line: where it must have been.
//!
//! Strings do not go on over the end of a line, so that a line with an odd number of quotes lacks one. It is looked for where
//! strings begin and end: with it the line must read as an entry does, of fields with `,` between them, each a string or a
//! single word. Of several such places, that counts which leaves the fewest words without a digit outside of quotes, where
//! they hardly ever are, and the fewest strings side by side, and then the one with the shortest string.

use std::vec::Vec;

use super::encoding::{Characters, Located};
use super::token::{is_blank, is_line_end};

/// A quote that is missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MissingQuote {
    /// Before the string that begins at this byte.
    Before(usize),
    /// Behind the string whose quote is at the byte `start`: it ends before the byte `end`.
    Behind { start: usize, end: usize },
}

/// Looks for the quote that is missing on the line that begins here.
pub(super) fn missing(rest: &Characters<'_>) -> Option<MissingQuote> {
    if !is_open_at_its_end(rest.clone()) {
        return None;
    }
    let line: Vec<Located> = of_line(rest.clone()).take(LONGEST_LINE.saturating_add(1)).collect();
    let first = line.iter().find(|located| !is_blank(located.character))?;
    if line.len() > LONGEST_LINE || first.character == '[' {
        return None;
    }
    let end = line.last()?.end;
    let best = places(&line).take(MOST_PLACES).filter_map(|at| read_with(&line, at, end)).min()?;
    Some(best.quote)
}

/// Whether the line ends inside of a string; not if that has an escaped quote, which is another mistake.
fn is_open_at_its_end(rest: Characters<'_>) -> bool {
    let (mut is_open, mut is_escaped, mut has_escaped_quote) = (false, false, false);
    for located in of_line(rest) {
        match located.character {
            '$' if !is_open => break,
            '"' if is_escaped && is_open => has_escaped_quote = true,
            '"' => (is_open, has_escaped_quote) = (!is_open, false),
            _ => {}
        }
        is_escaped = located.character == '\\' && !is_escaped;
    }
    is_open && !has_escaped_quote
}

fn of_line(rest: Characters<'_>) -> impl Iterator<Item = Located> {
    rest.take_while(|located| !is_line_end(located.character))
}

/// The places at which a string can begin or end.
fn places(line: &[Located]) -> impl Iterator<Item = usize> {
    (0..=line.len()).filter(|&at| {
        let (before, behind) = line.split_at_checked(at).unwrap_or_default();
        let next = behind.first().map(|located| located.character);
        let last = before.last().map(|located| located.character);
        let last_word = before.iter().rev().map(|located| located.character).find(|&it| !is_blank(it));
        let next_word = behind.iter().map(|located| located.character).find(|&it| !is_blank(it));
        let begins = next.is_some_and(|next| !is_blank(next) && !matches!(next, ',' | ';' | '$' | '='))
            && matches!(last_word, None | Some(',' | '=' | '"'));
        let ends =
            last.is_some_and(|last| !is_blank(last)) && matches!(next_word, None | Some(',' | ';' | '$'));
        begins || ends
    })
}

/// A line as it reads with a quote more. The better one is less.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Reading {
    /// Words without quotes and without a digit, and strings side by side, which are rare on one line.
    oddities: usize,
    /// The characters of the string that got its quote.
    length: usize,
    quote: MissingQuote,
}

/// Behind comes first: of an empty string with one quote, the second is missing.
impl Ord for MissingQuote {
    fn cmp(&self, other: &Self) -> core::cmp::Ordering {
        let key = |quote: &Self| match *quote {
            Self::Behind { start, .. } => (false, start),
            Self::Before(start) => (true, start),
        };
        key(self).cmp(&key(other))
    }
}

impl PartialOrd for MissingQuote {
    fn partial_cmp(&self, other: &Self) -> Option<core::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// What a field has so far.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Content {
    Nothing,
    /// A word: whether it has a digit, as numbers and `Param3` have, and whether a blank has come behind it.
    Word {
        has_digit: bool,
        is_over: bool,
    },
    Strings,
}

/// Reads the line with a quote before its character `at`; `None` if it does not read as an entry does.
fn read_with(line: &[Located], at: usize, end: usize) -> Option<Reading> {
    let mut reader = Reader { content: Content::Nothing, is_entry_expected: false, oddities: 0 };
    // The number of the character behind the opening quote, and the place of the quote.
    let mut open: Option<(usize, Option<usize>)> = None;
    let mut quote = None;
    let mut is_escaped = false;
    for (number, located) in line.iter().map(Some).chain([None]).enumerate() {
        let place = located.map_or(end, |located| located.start);
        if number == at {
            match open.take() {
                None => {
                    reader.string()?;
                    open = Some((number, None));
                }
                Some((first, start)) => {
                    quote = Some((
                        number.saturating_sub(first),
                        MissingQuote::Behind { start: start?, end: place },
                    ));
                }
            }
            is_escaped = false;
        }
        let Some(located) = located else { break };
        match (located.character, open) {
            ('"', Some((first, start))) if !is_escaped => {
                if start.is_none() {
                    let begin = line.get(first)?.start;
                    quote = Some((number.saturating_sub(first), MissingQuote::Before(begin)));
                }
                open = None;
            }
            (_, Some(_)) => {}
            ('"', None) => {
                reader.string()?;
                open = Some((number.saturating_add(1), Some(place)));
            }
            ('$', None) => break,
            (character, None) => reader.character(character)?,
        }
        is_escaped = located.character == '\\' && !is_escaped;
    }
    let (length, quote) = quote.filter(|_| open.is_none())?;
    reader.end_of_entry()?;
    Some(Reading { oddities: reader.oddities, length, quote })
}

/// Follows the fields of a line outside of strings.
struct Reader {
    content: Content,
    /// Behind a `;` an entry begins.
    is_entry_expected: bool,
    oddities: usize,
}

impl Reader {
    fn string(&mut self) -> Option<()> {
        match self.content {
            Content::Word { .. } => return None,
            Content::Strings => self.oddities = self.oddities.saturating_add(1),
            Content::Nothing => {}
        }
        self.content = Content::Strings;
        (!self.is_entry_expected).then_some(())
    }

    fn character(&mut self, character: char) -> Option<()> {
        match (character, self.content) {
            (',', _) if self.is_entry_expected => return None,
            (',' | ';', _) => {
                self.end_of_entry()?;
                self.is_entry_expected = character == ';';
            }
            ('=', Content::Word { .. }) => (self.content, self.is_entry_expected) = (Content::Nothing, false),
            ('=', _) => return None,
            (blank, Content::Word { has_digit, .. }) if is_blank(blank) => {
                self.content = Content::Word { has_digit, is_over: true };
            }
            (blank, _) if is_blank(blank) => {}
            (_, Content::Strings | Content::Word { is_over: true, .. }) => return None,
            (_, Content::Nothing) => {
                let has_digit = character.is_ascii_digit();
                self.content = Content::Word { has_digit, is_over: false };
            }
            (_, Content::Word { has_digit, .. }) => {
                let has_digit = has_digit || character.is_ascii_digit();
                self.content = Content::Word { has_digit, is_over: false };
            }
        }
        Some(())
    }

    /// A field is over; a word that should begin an entry has no `=`.
    fn end_of_entry(&mut self) -> Option<()> {
        match core::mem::replace(&mut self.content, Content::Nothing) {
            Content::Word { .. } if self.is_entry_expected => return None,
            Content::Word { has_digit: false, .. } => self.oddities = self.oddities.saturating_add(1),
            Content::Word { .. } | Content::Nothing | Content::Strings => {}
        }
        Some(())
    }
}

/// Lines of more characters, and places beyond these, are not looked at.
const LONGEST_LINE: usize = 512;
const MOST_PLACES: usize = 64;

#[cfg(test)]
mod tests {
    use crate::eds::{Code, Diagnostic, Eds, MAX_DIAGNOSTICS};
    use std::string::String;
    use std::vec::Vec;

    fn codes(file: impl Into<Vec<u8>>) -> Vec<Code> {
        Eds::parse(file).unwrap().diagnostics().iter().map(|found| found.code).collect()
    }

    /// Without any one of the quotes of a right file, that quote is missing, and nothing else is wrong.
    #[test]
    fn a_missing_quote_is_one_finding() {
        let demo = crate::eds::tests::DEMO;
        for (at, _) in demo.match_indices('"') {
            let (before, behind) = (&demo[..at], &demo[at + 1..]);
            let found = codes(String::from(before) + behind);
            let line = before.rsplit('\n').next().unwrap();
            assert!(
                matches!(found[..], [Code::UnterminatedString | Code::UnopenedString]),
                "{line}: {found:?}"
            );
        }
    }

    /// Each string on the line, and what is found.
    #[track_caller]
    fn reads(line: &str, strings: &[&str], expected: &str) {
        let eds = Eds::parse(std::format!("[9_X]\n{line}\n")).unwrap();
        let of_line: Vec<&Diagnostic> = (eds.diagnostics().iter())
            .filter(|found| found.place.line == 2 && found.code != Code::MissingSemicolon)
            .collect();
        let told: Vec<_> =
            of_line.iter().map(|found| std::format!("{} {}", found.place.column, found.code)).collect();
        assert_eq!(told, [expected], "{line}");
        let fields = eds.document().sections()[0].entries.iter().flat_map(|entry| &entry.fields);
        let found: Vec<&str> = (fields)
            .filter_map(|field| match &field.content {
                crate::eds::Content::Text(text) => Some(text.as_str()),
                _ => None,
            })
            .collect();
        assert_eq!(found, strings, "{line}");
    }

    #[test]
    fn the_quote_is_put_where_the_line_reads_as_an_entry() {
        reads("A = \"one, two;", &["one, two"], "5 unterminated_string");
        reads("A = \"one, 2, 0x3;", &["one"], "5 unterminated_string");
        reads("A = \"one\"; B = two words\"; $ x", &["one", "two words"], "16 unopened_string");
        reads("A = \"one;  B = 7; $ no quote", &["one"], "5 unterminated_string");
        reads("A = 1, Param3, \"one, 8, Param4;", &["one"], "16 unterminated_string");
        reads("A = \"EX, Catalog = \"X\";", &["EX", "X"], "5 unterminated_string");
    }

    /// A line that has no such place is read up to where its author probably meant the string to end.
    #[test]
    fn a_line_that_reads_as_no_entry_still_ends() {
        assert!(codes("[9_X] A = one two \"three;\nB = 4;").contains(&Code::UnterminatedString));
        let long = std::format!("[9_X] A = \"{};", "x, ".repeat(200));
        assert!(codes(long).contains(&Code::UnterminatedString));
        let many = "A = \"x;\n".repeat(MAX_DIAGNOSTICS * 2);
        assert_eq!(codes(many).len(), MAX_DIAGNOSTICS);
    }
}
