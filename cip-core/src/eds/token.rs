//! The words of a file: nothing is left out, so that they put together are the file again.

use std::vec::Vec;

use super::diagnostic::{Code, Findings};
use super::encoding::{Characters, Located};
use super::quotes::{self, MissingQuote};
use super::{Encoding, Span};

/// A word of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Token {
    /// What it is.
    pub kind: TokenKind,
    /// Its bytes.
    pub span: Span,
}

/// What a word of the file is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TokenKind {
    /// A byte order mark.
    ByteOrderMark,
    /// Blanks, tabs and other characters without a meaning, on one line.
    Blank,
    /// An end of a line: LF, CR, or both.
    NewLine,
    /// `$` and the rest of the line.
    Comment,
    /// `[` and `]` with a name between.
    Section,
    /// Characters without blanks: a keyword, a number, a name.
    Word,
    /// Characters in double quotes.
    String,
    /// `=`
    Equals,
    /// `,`
    Comma,
    /// `;`
    Semicolon,
}

impl TokenKind {
    /// False for what only people read.
    #[must_use]
    pub const fn is_significant(self) -> bool {
        !matches!(self, Self::ByteOrderMark | Self::Blank | Self::NewLine | Self::Comment)
    }
}

/// Cuts a file into words.
pub(super) fn tokens(bytes: &[u8], encoding: Encoding, mark: usize, findings: &mut Findings) -> Vec<Token> {
    let rest = Characters::of(bytes, Span { start: mark, end: bytes.len() }, encoding);
    let mut lexer = Lexer { rest, findings, is_entry_open: false, is_line_start: true, missing: None };
    lexer.begin_line();
    let mut tokens = Vec::new();
    if mark > 0 {
        tokens.push(Token { kind: TokenKind::ByteOrderMark, span: Span { start: 0, end: mark } });
    }
    while let Some(token) = lexer.token() {
        tokens.push(token);
    }
    tokens
}

struct Lexer<'a, 'f> {
    rest: Characters<'a>,
    findings: &'f mut Findings,
    /// Whether an entry has begun and not ended.
    is_entry_open: bool,
    /// Whether only blanks stand before on the line.
    is_line_start: bool,
    /// What is missing on the line, if that can be told.
    missing: Option<MissingQuote>,
}

impl Lexer<'_, '_> {
    fn token(&mut self) -> Option<Token> {
        let Located { character, start, .. } = self.rest.next()?;
        let kind = match character {
            first if self.missing == Some(MissingQuote::Before(start)) => {
                self.unopened_string(start, first);
                TokenKind::String
            }
            '\n' => TokenKind::NewLine,
            '\r' => {
                if self.rest.peek() == Some('\n') {
                    self.rest.next();
                }
                TokenKind::NewLine
            }
            '$' => {
                self.take_while(|character| !is_line_end(character));
                TokenKind::Comment
            }
            ',' => TokenKind::Comma,
            ';' => TokenKind::Semicolon,
            '=' => TokenKind::Equals,
            '"' => {
                self.string(start);
                TokenKind::String
            }
            '“' | '”' | '„' if self.typographic_string(start) => TokenKind::String,
            // Inside of an entry a bracket is part of a word, unless the line begins with it: then a `;` is missing.
            '[' if self.is_line_start || !self.is_entry_open => {
                self.section(start);
                TokenKind::Section
            }
            blank if is_blank(blank) => {
                self.take_while(is_blank);
                TokenKind::Blank
            }
            _ => {
                self.take_while(is_word);
                TokenKind::Word
            }
        };
        match kind {
            TokenKind::NewLine => {
                self.is_line_start = true;
                self.begin_line();
            }
            TokenKind::Blank | TokenKind::ByteOrderMark => {}
            TokenKind::Semicolon | TokenKind::Section => {
                (self.is_entry_open, self.is_line_start) = (false, false);
            }
            TokenKind::Comment => self.is_line_start = false,
            TokenKind::Word | TokenKind::String | TokenKind::Equals | TokenKind::Comma => {
                (self.is_entry_open, self.is_line_start) = (true, false);
            }
        }
        Some(Token { kind, span: Span { start, end: self.rest.at() } })
    }

    /// A line without as many quotes as it needs is rare: the others are looked at once.
    fn begin_line(&mut self) {
        // Beyond the findings that are kept, nobody sees how well a line was read.
        self.missing = if self.findings.is_full() { None } else { quotes::missing(&self.rest) };
    }

    fn take_while(&mut self, accepts: impl Fn(char) -> bool) {
        while self.rest.peek().is_some_and(&accepts) {
            self.rest.next();
        }
    }

    /// The rest of a string, up to its closing quote. Without one, the string ends where its author probably meant it
    /// to: before a `,` or `;` that ends the line, else with the line. A quote that a letter or digit follows opens the
    /// next string: then the one before ends at its first `,` or `;`.
    fn string(&mut self, start: usize) {
        if let Some(MissingQuote::Behind { start: opened, end }) = self.missing
            && opened == start
        {
            while self.rest.at() < end && self.rest.next().is_some() {}
            return self.report_unterminated(start);
        }
        let mut look = self.rest.clone();
        let mut is_escaped = false;
        let mut after_escaped_quote = None;
        let mut separator = None;
        let mut here = look.clone();
        while let Some(located) = look.next().filter(|located| !is_line_end(located.character)) {
            match located.character {
                '"' if !is_escaped => {
                    let is_next_one = look.peek().is_some_and(char::is_alphanumeric);
                    match separator.filter(|_| is_next_one) {
                        Some(end) => {
                            self.rest = end;
                            self.report_unterminated(start);
                        }
                        None => self.rest = look,
                    }
                    return;
                }
                '"' => after_escaped_quote = Some(look.clone()),
                ',' | ';' if separator.is_none() => separator = Some(here),
                _ => {}
            }
            is_escaped = located.character == '\\' && !is_escaped;
            here = look.clone();
        }
        if let Some(end) = after_escaped_quote {
            self.rest = end;
            let span = Span { start, end: self.rest.at() };
            self.findings.add(
                Code::EscapedQuote,
                span,
                format_args!(
                    "the string ends with `\\\"`, which is a quote inside of a string; write `\\\\\"`"
                ),
            );
            return;
        }
        self.unterminated_string(start);
    }

    /// The rest of a string without its opening quote.
    fn unopened_string(&mut self, start: usize, first: char) {
        let mut is_escaped = first == '\\';
        let mut is_over = first == '"';
        while !is_over && let Some(located) = self.rest.next() {
            is_over = located.character == '"' && !is_escaped;
            is_escaped = located.character == '\\' && !is_escaped;
        }
        let span = Span { start, end: self.rest.at() };
        let message = format_args!("the string has no beginning; open it with `\"`");
        self.findings.add(Code::UnopenedString, span, message);
    }

    /// The rest of a string between quotes that are no quotes to a tool. False, and nothing is taken, if none closes it.
    fn typographic_string(&mut self, start: usize) -> bool {
        let mut look = self.rest.clone();
        while let Some(located) = look.next().filter(|located| !is_line_end(located.character)) {
            match located.character {
                '”' | '“' => {
                    self.rest = look;
                    let span = Span { start, end: self.rest.at() };
                    let message = format_args!("these quotes are typographic; write `\"` before and behind");
                    self.findings.add(Code::TypographicQuotes, span, message);
                    return true;
                }
                '"' => return false,
                _ => {}
            }
        }
        false
    }

    fn unterminated_string(&mut self, start: usize) {
        loop {
            let here = self.rest.clone();
            let Some(located) = self.rest.next() else { break };
            let ends_line = || {
                let mut after = self.rest.clone();
                let next = after.find(|located| !is_blank(located.character));
                next.is_none_or(|next| is_line_end(next.character) || next.character == '$')
            };
            let ends_string = match located.character {
                ',' | ';' => ends_line(),
                character => is_line_end(character),
            };
            if ends_string {
                self.rest = here;
                break;
            }
        }
        self.report_unterminated(start);
    }

    fn report_unterminated(&mut self, start: usize) {
        let span = Span { start, end: self.rest.at() };
        self.findings.add(
            Code::UnterminatedString,
            span,
            format_args!("the string has no end on its line; close it with `\"`, and go on in a second string if it is long"),
        );
    }

    fn section(&mut self, start: usize) {
        self.take_while(|character| !is_line_end(character) && character != ']' && character != '$');
        if self.rest.peek() == Some(']') {
            self.rest.next();
            return;
        }
        let span = Span { start, end: self.rest.at() };
        self.findings.add(
            Code::UnterminatedSection,
            span,
            format_args!("the name of the section has no end; close it with `]`"),
        );
    }
}

pub(super) const fn is_line_end(character: char) -> bool {
    matches!(character, '\n' | '\r')
}

pub(super) fn is_blank(character: char) -> bool {
    !is_line_end(character) && (character.is_whitespace() || character.is_control())
}

fn is_word(character: char) -> bool {
    !matches!(character, '$' | ',' | ';' | '=' | '"') && !is_line_end(character) && !is_blank(character)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::String;

    /// The words without blanks.
    fn words(text: &str) -> Vec<(TokenKind, &str)> {
        let tokens = tokens(text.as_bytes(), Encoding::Utf8, 0, &mut Findings::default());
        let whole: String = tokens.iter().map(|token| &text[token.span.start..token.span.end]).collect();
        assert_eq!(whole, text);
        let shown = tokens.iter().filter(|token| token.kind.is_significant());
        shown.map(|token| (token.kind, &text[token.span.start..token.span.end])).collect()
    }

    #[test]
    fn an_entry() {
        use TokenKind::{Comma, Equals, Section, Semicolon, String, Word};
        let expected = [
            (Section, "[Device Classification]"),
            (Word, "Class1"),
            (Equals, "="),
            (Word, "0x1F"),
            (Comma, ","),
            (String, "\"a $ b ; \\\" c\""),
            (Word, "x[1]"),
            (Semicolon, ";"),
        ];
        assert_eq!(words("[Device Classification] $ x\nClass1=0x1F ,\"a $ b ; \\\" c\" x[1];$ y"), expected);
    }

    #[test]
    fn a_string_without_an_end_ends_where_it_was_meant_to() {
        use TokenKind::{Comma, Semicolon, String, Word};
        assert_eq!(words("\"abc;  $ d\n1"), [(String, "\"abc"), (Semicolon, ";"), (Word, "1")]);
        assert_eq!(words("\"a,b ,\r\n1"), [(String, "\"a,b"), (Comma, ","), (Word, "1")]);
        assert_eq!(words("\"abc\n\"d\""), [(String, "\"abc"), (String, "\"d\"")]);
        assert_eq!(words("\"C:\\\";\n"), [(String, "\"C:\\\""), (Semicolon, ";")]);
        assert_eq!(words("\"C:\\\\\";\n"), [(String, "\"C:\\\\\""), (Semicolon, ";")]);
    }

    #[test]
    fn a_quote_before_a_letter_opens_the_next_string() {
        use TokenKind::{Comma, String, Word};
        let expected = [(String, "\"Inputs"), (Comma, ","), (Word, "6"), (Comma, ","), (String, "\"20 04\"")];
        assert_eq!(words("\"Inputs, 6, \"20 04\""), expected);
        assert_eq!(words("\"a, b\" \"c\"x"), [(String, "\"a, b\""), (String, "\"c\""), (Word, "x")]);
    }

    #[test]
    fn typographic_quotes_are_quotes_all_the_same() {
        use TokenKind::{Comma, Semicolon, String, Word};
        assert_eq!(
            words("“a, b”, „c“;"),
            [(String, "“a, b”"), (Comma, ","), (String, "„c“"), (Semicolon, ";")]
        );
        assert_eq!(words("“a b"), [(Word, "“a"), (Word, "b")]);
    }

    #[test]
    fn a_bracket_at_the_start_of_a_line_is_a_section() {
        use TokenKind::{Equals, Section, Word};
        let expected = [(Word, "A"), (Equals, "="), (Word, "1"), (Section, "[B ")];
        assert_eq!(words("A = 1\n  [B $ c"), expected);
    }
}
