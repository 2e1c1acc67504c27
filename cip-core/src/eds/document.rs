//! A file as its author wrote it: sections, entries, fields.

use core::fmt;
use std::string::String;
use std::vec::Vec;

use super::check::structure;
use super::diagnostic::Findings;
use super::encoding::Characters;
use super::parser::Parser;
use super::span::Lines;
use super::token::{self, Token, TokenKind};
use super::{Encoding, Place, Span};

/// A file, whole: every byte belongs to one of its words, and [`write`](Self::write) gives them back as they were.
#[derive(Debug, Clone)]
pub struct Document {
    bytes: Vec<u8>,
    encoding: Encoding,
    tokens: Vec<Token>,
    sections: Vec<Section>,
    lines: Lines,
}

/// A section: `[Name]` and the entries up to the next one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Section {
    /// The name between the brackets.
    pub name: String,
    /// The name with its brackets.
    pub span: Span,
    /// The entries in their order.
    pub entries: Vec<Entry>,
}

/// An entry: `Keyword = field, field, ...;`
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// The keyword.
    pub keyword: String,
    /// Where the keyword stands.
    pub keyword_span: Span,
    /// From the keyword to the semicolon.
    pub span: Span,
    /// The fields; an entry without any has one that is empty.
    pub fields: Vec<Field>,
}

/// A field of an entry.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Field {
    /// Where it stands; if it is empty, where it should stand.
    pub span: Span,
    /// What it says.
    pub content: Content,
}

/// What a field says.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Content {
    /// Nothing.
    Empty,
    /// A number, a date, a name.
    Word(String),
    /// One string, or several that stand side by side, put together. Escapes like `\n` stay as they are written.
    Text(String),
}

impl Document {
    pub(super) fn parse(bytes: Vec<u8>, findings: &mut Findings) -> Self {
        let (encoding, mark) = Encoding::detect(&bytes);
        let tokens = token::tokens(&bytes, encoding, mark, findings);
        let line_ends = tokens.iter().filter(|token| token.kind == TokenKind::NewLine);
        let lines = Lines::new(line_ends.map(|token| token.span.end));
        let significant: Vec<_> =
            tokens.iter().filter(|token| token.kind.is_significant()).copied().collect();
        let sections = Parser::new(&bytes, encoding, &significant, findings).run();
        Self { bytes, encoding, tokens, sections, lines }
    }

    /// Appends the file to `out`, byte for byte as it was read.
    pub fn write(&self, out: &mut Vec<u8>) {
        self.tokens.iter().for_each(|token| out.extend_from_slice(token.span.of(&self.bytes)));
    }

    /// The bytes of the file.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// How its bytes are characters.
    #[must_use]
    pub const fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// Its words, comments and blanks, one after the other without a gap.
    #[must_use]
    pub fn tokens(&self) -> &[Token] {
        &self.tokens
    }

    /// Its sections in their order; one with the same name may come again.
    #[must_use]
    pub fn sections(&self) -> &[Section] {
        &self.sections
    }

    /// The first section of this name, upper and lower case being the same.
    #[must_use]
    pub fn section(&self, name: &str) -> Option<&Section> {
        self.sections.iter().find(|section| section.is(name))
    }

    /// The characters of a piece of the file.
    #[must_use]
    pub fn text(&self, span: Span) -> String {
        Characters::of(&self.bytes, span, self.encoding).map(|located| located.character).collect()
    }

    /// The bytes of a line, counted from 1, with what ends it.
    #[must_use]
    pub fn line(&self, line: usize) -> Span {
        self.lines.span_of(line, self.bytes.len())
    }

    /// The number of the line, from 1, that a byte is on.
    pub(super) fn line_of(&self, at: usize) -> usize {
        self.lines.line_of(at)
    }

    /// Lines and columns of places that ascend.
    pub(super) fn places(&self, ascending: &mut dyn Iterator<Item = usize>) -> Vec<Place> {
        let (_, mark) = Encoding::detect(&self.bytes);
        self.lines.places(&self.bytes, self.encoding, mark, ascending)
    }
}

impl Section {
    /// Whether this is its name, upper and lower case being the same.
    #[must_use]
    pub fn is(&self, name: &str) -> bool {
        self.name.eq_ignore_ascii_case(name)
    }

    /// Whether it is one of those that say something of a DeviceNet device, such as `[Device]` and `[Params]`.
    #[must_use]
    pub fn is_known(&self) -> bool {
        structure::is_known(&self.name)
    }
}

impl Entry {
    /// Whether this is its keyword, upper and lower case being the same.
    #[must_use]
    pub fn is(&self, keyword: &str) -> bool {
        self.keyword.eq_ignore_ascii_case(keyword)
    }

    /// The keyword without the number at its end: `Param` of `Param12`.
    #[must_use]
    pub fn stem(&self) -> &str {
        self.keyword.trim_end_matches(|character: char| character.is_ascii_digit())
    }

    /// The digits at the end of the keyword.
    #[must_use]
    pub fn digits(&self) -> &str {
        self.keyword.get(self.stem().len()..).unwrap_or_default()
    }

    /// The number of a keyword that has this stem.
    #[must_use]
    pub fn number_of(&self, stem: &str) -> Option<u16> {
        if self.stem().eq_ignore_ascii_case(stem) { self.digits().parse().ok() } else { None }
    }

    /// Where a field stands, or where it should.
    #[must_use]
    pub fn field_span(&self, index: usize) -> Span {
        self.fields.get(index).map_or(Span::at(self.span.end), |field| field.span)
    }
}

impl Field {
    /// True if it says nothing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.content == Content::Empty
    }

    /// Its characters, without quotes.
    #[must_use]
    pub fn as_str(&self) -> &str {
        match &self.content {
            Content::Empty => "",
            Content::Word(text) | Content::Text(text) => text,
        }
    }
}

/// As it is written; `nothing` if it is empty.
impl fmt::Display for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.content {
            Content::Empty => f.write_str("nothing"),
            Content::Word(text) => write!(f, "`{text}`"),
            Content::Text(text) => write!(f, "`\"{text}\"`"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eds::Code;
    use proptest::prelude::*;
    use std::format;
    use std::string::ToString;

    fn parse(text: &str) -> (Document, Vec<Code>) {
        let mut findings = Findings::default();
        let document = Document::parse(text.as_bytes().to_vec(), &mut findings);
        let (diagnostics, _) = findings.finish(|places| document.places(places));
        (document, diagnostics.iter().map(|diagnostic| diagnostic.code).collect())
    }

    /// Keyword and fields of each entry.
    fn shown(text: &str) -> Vec<String> {
        let (document, _) = parse(text);
        let entries = document.sections.iter().flat_map(|section| &section.entries);
        let fields =
            |entry: &Entry| entry.fields.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
        entries.map(|entry| format!("{}: {}", entry.keyword, fields(entry))).collect()
    }

    #[test]
    fn strings_side_by_side_are_one() {
        assert_eq!(shown("[A] B = \"one \" $ first\n \"two\", 3;"), ["B: `\"one two\"` `3`"]);
    }

    #[test]
    fn empty_fields_count() {
        assert_eq!(shown("[A] B = 8, , 4, ; C = ;"), ["B: `8` nothing `4` nothing", "C: nothing"]);
    }

    #[test]
    fn a_missing_semicolon_costs_no_entry() {
        let text = "[A]\nB = 1\nC = 2 D = 3;\n[E]\nF = 4, \"x\"\n[G]\nH =";
        assert_eq!(shown(text), ["B: `1`", "C: `2`", "D: `3`", "F: `4` `\"x\"`", "H: nothing"]);
        assert_eq!(parse(text).1, [Code::MissingSemicolon; 4]);
    }

    #[test]
    fn a_missing_comma_costs_no_field() {
        assert_eq!(shown("[A] B = 0xC6 $ type\n 1 \"x\", 2;"), ["B: `0xC6` `1` `\"x\"` `2`"]);
        assert_eq!(parse("[A] B = 0xC6 $ type\n 1 \"x\", 2;").1, [Code::MissingComma; 2]);
    }

    #[test]
    fn what_stands_between_entries() {
        let (document, codes) = parse("junk 1, 2;\nA = 1;;\n[B] comment\nC = = 2;");
        assert_eq!(document.sections.len(), 2);
        let expected = [
            Code::StrayText,
            Code::EntryOutsideSection,
            Code::StraySemicolon,
            Code::StrayText,
            Code::StrayText,
        ];
        assert_eq!(codes, expected);
    }

    #[test]
    fn keywords_have_numbers() {
        let (document, _) = parse("[params] PARAM12 = 1; Enum99999 = 2; Default = 3; 1_X7 = 4;");
        let section = document.section("Params").unwrap();
        let [param, large, plain, vendor] = &section.entries[..] else { panic!("four entries") };
        assert_eq!((param.stem(), param.number_of("Param")), ("PARAM", Some(12)));
        assert_eq!((large.digits(), large.number_of("Enum")), ("99999", None));
        assert_eq!((plain.stem(), plain.number_of("Default")), ("Default", None));
        assert_eq!(vendor.stem(), "1_X");
    }

    proptest! {
        #[test]
        fn what_is_written_is_what_was_read(bytes: Vec<u8>) {
            let document = Document::parse(bytes.clone(), &mut Findings::default());
            let mut written = Vec::new();
            document.write(&mut written);
            prop_assert_eq!(written, bytes);
        }

        /// Of characters that mean something.
        #[test]
        fn words_follow_one_another(text in "[\\[\\]=,;\"$\\\\ \r\nAa1é]{0,60}") {
            let (document, _) = parse(&text);
            let mut at = 0;
            for token in document.tokens() {
                prop_assert_eq!(token.span.start, at);
                prop_assert!(token.span.end > at);
                at = token.span.end;
            }
            prop_assert_eq!(at, text.len());
            for entry in document.sections().iter().flat_map(|section| &section.entries) {
                prop_assert!(!entry.fields.is_empty());
                prop_assert!(entry.span.start <= entry.span.end && entry.span.end <= text.len());
            }
        }
    }
}
