//! From words to sections, entries and fields. What is in the wrong place is a finding, and costs as little of the rest as can
//! be.

use std::string::String;
use std::vec::Vec;

use super::diagnostic::{Code, Findings};
use super::document::{Content, Entry, Field, Section};
use super::encoding::Characters;
use super::token::{Token, TokenKind};
use super::{Encoding, Span};

/// Puts significant words together.
pub(super) struct Parser<'a, 'f> {
    bytes: &'a [u8],
    encoding: Encoding,
    /// Significant words only.
    rest: &'a [Token],
    /// Where the last word taken ends.
    end: usize,
    sections: Vec<Section>,
    findings: &'f mut Findings,
}

impl<'a, 'f> Parser<'a, 'f> {
    pub(super) const fn new(
        bytes: &'a [u8],
        encoding: Encoding,
        significant: &'a [Token],
        findings: &'f mut Findings,
    ) -> Self {
        Self { bytes, encoding, rest: significant, end: 0, sections: Vec::new(), findings }
    }

    /// The sections with their entries.
    pub(super) fn run(mut self) -> Vec<Section> {
        while let Some(&first) = self.rest.first() {
            match (first.kind, self.second()) {
                (TokenKind::Section, _) => self.section(first),
                (TokenKind::Word, Some(TokenKind::Equals)) => self.entry(first),
                (TokenKind::Semicolon, _) => {
                    self.take();
                    let message = format_args!("the `;` ends nothing; remove it");
                    self.findings.add(Code::StraySemicolon, first.span, message);
                }
                _ => self.stray(first),
            }
        }
        self.sections
    }

    fn section(&mut self, header: Token) {
        self.take();
        let text = self.text(header.span);
        let name = text.trim_start_matches('[').trim_end_matches(']').trim().into();
        self.sections.push(Section { name, span: header.span, entries: Vec::new() });
    }

    /// What is neither a section nor an entry, up to where one of them begins.
    fn stray(&mut self, first: Token) {
        self.take();
        while !self.at_start() {
            if self.take().is_some_and(|token| token.kind == TokenKind::Semicolon) {
                break;
            }
        }
        let span = first.span.to(Span::at(self.end));
        let message = format_args!(
            "an entry `Keyword = value;` or a section `[Name]` expected; put a `$` before a comment"
        );
        self.findings.add(Code::StrayText, span, message);
    }

    fn entry(&mut self, keyword: Token) {
        self.take();
        self.take();
        let mut entry = Entry {
            keyword: self.text(keyword.span),
            keyword_span: keyword.span,
            span: keyword.span,
            fields: Vec::new(),
        };
        self.fields(&mut entry);
        entry.span.end = self.end;
        if self.sections.is_empty() {
            let message =
                format_args!("`{}` stands before the first section; put it into one", entry.keyword);
            self.findings.add(Code::EntryOutsideSection, keyword.span, message);
            self.sections.push(Section {
                name: String::new(),
                span: Span::at(keyword.span.start),
                entries: Vec::new(),
            });
        }
        if let Some(section) = self.sections.last_mut() {
            section.entries.push(entry);
        }
    }

    fn fields(&mut self, entry: &mut Entry) {
        let mut field = None;
        loop {
            let missing = self.at_start();
            let end = self.end;
            let Some(token) = self.rest.first().copied().filter(|_| !missing) else {
                let message = format_args!("`{}` does not end; put a `;` here", entry.keyword);
                self.findings.add(Code::MissingSemicolon, Span::at(end), message);
                entry.fields.extend(field);
                if entry.fields.is_empty() {
                    entry.fields.push(empty(end));
                }
                return;
            };
            self.take();
            match token.kind {
                TokenKind::Comma => entry.fields.push(field.take().unwrap_or(empty(token.span.start))),
                TokenKind::Semicolon => {
                    entry.fields.push(field.take().unwrap_or(empty(token.span.start)));
                    return;
                }
                TokenKind::Word => {
                    let content = Content::Word(self.text(token.span));
                    self.value(entry, &mut field, Field { span: token.span, content });
                }
                TokenKind::String => {
                    let content = Content::Text(self.string(token.span));
                    self.value(entry, &mut field, Field { span: token.span, content });
                }
                // Comments and blanks are left out; a section is where an entry starts.
                TokenKind::Equals
                | TokenKind::Section
                | TokenKind::ByteOrderMark
                | TokenKind::Blank
                | TokenKind::NewLine
                | TokenKind::Comment => {
                    let message = format_args!("a value, `,` or `;` expected; remove this");
                    self.findings.add(Code::StrayText, token.span, message);
                }
            }
        }
    }

    /// A value: the first of its field, a string that goes on, or one before which a comma is missing.
    fn value(&mut self, entry: &mut Entry, field: &mut Option<Field>, value: Field) {
        let Some(before) = field else {
            *field = Some(value);
            return;
        };
        if let (Content::Text(text), Content::Text(more)) = (&mut before.content, &value.content) {
            text.push_str(more);
            before.span = before.span.to(value.span);
            return;
        }
        let message = format_args!("two values without a `,` between them");
        self.findings.add(Code::MissingComma, value.span, message);
        entry.fields.extend(field.replace(value));
    }

    /// The characters of a string without its quotes.
    fn string(&self, span: Span) -> String {
        let text = self.text(span);
        let inner = text.strip_prefix(['"', '“', '”', '„']).unwrap_or(&text);
        inner.strip_suffix(['"', '“', '”']).unwrap_or(inner.trim_end()).into()
    }

    /// Whether a section or an entry begins here, or the file ends.
    fn at_start(&self) -> bool {
        match self.rest.first().map(|token| token.kind) {
            None | Some(TokenKind::Section) => true,
            Some(TokenKind::Word) => self.second() == Some(TokenKind::Equals),
            Some(_) => false,
        }
    }

    fn second(&self) -> Option<TokenKind> {
        self.rest.get(1).map(|token| token.kind)
    }

    fn take(&mut self) -> Option<Token> {
        let (&first, rest) = self.rest.split_first()?;
        self.rest = rest;
        self.end = first.span.end;
        Some(first)
    }

    fn text(&self, span: Span) -> String {
        Characters::of(self.bytes, span, self.encoding).map(|located| located.character).collect()
    }
}

const fn empty(at: usize) -> Field {
    Field { span: Span::at(at), content: Content::Empty }
}
