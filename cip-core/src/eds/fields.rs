//! The fields of an entry, read one after the other.

use core::fmt;
use std::string::String;
use std::vec::Vec;

use super::diagnostic::{Code, Findings};
use super::document::{Content, Document, Entry, Field};
use super::{Span, literal};
use crate::epath::Epath;

/// The entries of a section; of all of that name, should there be several.
pub(super) struct Entries<'a> {
    header: Option<Span>,
    entries: Vec<&'a Entry>,
}

impl<'a> Entries<'a> {
    pub(super) fn of(document: &'a Document, name: &str) -> Self {
        let sections = || document.sections().iter().filter(|section| section.is(name));
        Self {
            header: sections().next().map(|section| section.span),
            entries: sections().flat_map(|section| &section.entries).collect(),
        }
    }

    /// Where the section begins; `None` if it is missing.
    pub(super) const fn header(&self) -> Option<Span> {
        self.header
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &'a Entry> {
        self.entries.iter().copied()
    }

    /// The first entry with this keyword.
    pub(super) fn find(&self, keyword: &str) -> Option<&'a Entry> {
        self.iter().find(|entry| entry.is(keyword))
    }

    /// The same; a finding if it is missing from a section that is there.
    pub(super) fn require(&self, keyword: &str, findings: &mut Findings) -> Option<&'a Entry> {
        let entry = self.find(keyword);
        if let (None, Some(header)) = (entry, self.header) {
            findings.add(
                Code::MissingKeyword,
                header,
                format_args!("`{keyword}` is missing; add it to this section"),
            );
        }
        entry
    }

    /// The entries with this stem and a number, each number once, the first entry of it, in ascending order.
    pub(super) fn numbered(&self, stem: &str) -> Vec<(u16, &'a Entry)> {
        let mut numbered: Vec<_> =
            self.iter().filter_map(|entry| Some((entry.number_of(stem)?, entry))).collect();
        numbered.sort_by_key(|&(number, _)| number);
        numbered.dedup_by_key(|&mut (number, _)| number);
        numbered
    }
}

/// Whether a field may be empty.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Need {
    Required,
    Optional,
}

/// Takes one field after the other; what is wrong with one is a finding, and the field is `None`.
pub(super) struct FieldReader<'a, 'f> {
    entry: &'a Entry,
    next: usize,
    pub(super) findings: &'f mut Findings,
}

impl<'a, 'f> FieldReader<'a, 'f> {
    pub(super) const fn new(entry: &'a Entry, findings: &'f mut Findings) -> Self {
        Self { entry, next: 0, findings }
    }

    /// Whether all fields are taken.
    pub(super) fn is_at_end(&self) -> bool {
        self.next >= self.entry.fields.len()
    }

    /// Where the field taken last stands, or where it should.
    pub(super) fn last_span(&self) -> Span {
        self.entry.field_span(self.next.saturating_sub(1))
    }

    /// The next field, whatever it is; `None` behind the last.
    pub(super) fn field(&mut self) -> Option<&'a Field> {
        let field = self.entry.fields.get(self.next);
        self.next = self.next.saturating_add(1);
        field
    }

    pub(super) fn string(&mut self, what: &str, need: Need) -> Option<String> {
        let field = self.given(what, need)?;
        if let Content::Text(text) = &field.content {
            let end = text.char_indices().nth(LONGEST_STRING).map(|(end, _)| end);
            let Some(beginning) = end.and_then(|end| text.get(..end)) else { return Some(text.clone()) };
            let message =
                format_args!("{what} is longer than {LONGEST_STRING} characters, which are read; shorten it");
            self.findings.add(Code::StringTooLong, field.span, message);
            return Some(beginning.into());
        }
        let message = format_args!("{what} is {field}; put it into quotes `\"`");
        self.findings.add(Code::NotAString, field.span, message);
        Some(field.as_str().into())
    }

    /// A name without quotes; with quotes it is taken as well.
    pub(super) fn word(&mut self, what: &str, need: Need) -> Option<String> {
        self.given(what, need).map(|field| field.as_str().into())
    }

    pub(super) fn number<T: Number>(&mut self, what: &str, need: Need) -> Option<T> {
        let field = self.given(what, need)?;
        let number = self.integer_in(field, what)?;
        let converted = T::try_from(number).ok();
        if converted.is_none() {
            let (min, max) = (T::LEAST, T::MOST);
            let message = format_args!("{what} is {}; write a number from {min} to {max}", field.as_str());
            self.findings.add(Code::NumberRange, field.span, message);
        }
        converted
    }

    fn integer_in(&mut self, field: &Field, what: &str) -> Option<i128> {
        let number = match &field.content {
            Content::Word(text) => literal::integer(text),
            Content::Text(_) | Content::Empty => None,
        };
        if number.is_none() {
            let message =
                format_args!("{what} is {field}; write a whole number, decimal or `0x` hexadecimal");
            self.findings.add(Code::NotANumber, field.span, message);
        }
        number
    }

    /// A field that says nothing: empty or 0.
    pub(super) fn reserved(&mut self, value: &str) {
        let Some(field) = self.field() else { return };
        if !field.is_empty() && !field.as_str().is_empty() && literal::integer(field.as_str()) != Some(0) {
            let message = format_args!("the field is reserved and is {field}; {value}");
            self.findings.add(Code::Reserved, field.span, message);
        }
    }

    /// A string that is read by `parse`.
    pub(super) fn literal<T>(
        &mut self,
        what: &str,
        code: Code,
        form: &str,
        parse: impl Fn(&str) -> Option<T>,
    ) -> Option<T> {
        let field = self.given(what, Need::Required)?;
        let parsed = parse(field.as_str()).filter(|_| matches!(field.content, Content::Word(_)));
        if parsed.is_none() {
            self.findings.add(code, field.span, format_args!("{what} is {field}; write it as {form}"));
        }
        parsed
    }

    /// A path: two fields, its size in bytes and its text.
    pub(super) fn sized_path(&mut self) -> Vec<u8> {
        let size_span = self.entry.field_span(self.next);
        let size: Option<u16> = self.number("the path size", Need::Optional);
        let Some(path) = self.path() else { return Vec::new() };
        let size = size.unwrap_or(0);
        if usize::from(size) != path.len() {
            let found = Count(path.len(), "byte");
            let message = format_args!("the path has {found}, and its size is {size}; write {}", path.len());
            self.findings.add(Code::PathSize, size_span, message);
        }
        path
    }

    /// The text of a path; an empty one if there is none.
    pub(super) fn path(&mut self) -> Option<Vec<u8>> {
        let span = self.entry.field_span(self.next);
        let text = self.string("the path", Need::Optional).unwrap_or_default();
        let Some(bytes) = literal::path(&text) else {
            let message = format_args!(
                "the path is \"{text}\"; write its bytes with two hexadecimal digits each, like \"20 04 24 65 30 03\""
            );
            self.findings.add(Code::BadPath, span, message);
            return None;
        };
        if let Some(Err(error)) = Epath::packed(&bytes).segments().find(Result::is_err) {
            let message = format_args!("the path is not a packed EPATH: {error}");
            self.findings.add(Code::PathSegments, span, message);
        }
        Some(bytes)
    }

    /// A finding if fields are left that nobody knows.
    pub(super) fn finish(self) {
        let rest = self.entry.fields.get(self.next..).unwrap_or_default();
        if let Some(first) = rest.iter().find(|field| !field.is_empty()) {
            let (keyword, known) = (&self.entry.keyword, Count(self.next, "field"));
            let message =
                format_args!("`{keyword}` has {known}; remove what follows, or a `,` too many before");
            self.findings.add(Code::TooManyFields, first.span, message);
        }
    }

    /// The next field if it says something.
    fn given(&mut self, what: &str, need: Need) -> Option<&'a Field> {
        let span = self.entry.field_span(self.next);
        let field = self.field().filter(|field| !field.is_empty());
        if field.is_none() && need == Need::Required {
            let keyword = &self.entry.keyword;
            let is_whole = what.trim_matches('`') == keyword;
            let of_entry = if is_whole { String::new() } else { std::format!(" in `{keyword}`") };
            self.findings.add(
                Code::MissingField,
                span,
                format_args!("{what} is missing{of_entry}; write it here"),
            );
        }
        field
    }
}

/// A type that numbers in fields have.
pub(super) trait Number: TryFrom<i128> {
    const LEAST: i128;
    const MOST: i128;
}

macro_rules! numbers {
    ($($number:ident: $least:literal, $most:literal;)*) => {$(
        impl Number for $number {
            const LEAST: i128 = $least;
            const MOST: i128 = $most;
        }
    )*};
}

numbers! {
    u8: 0, 0xFF;
    u16: 0, 0xFFFF;
    u32: 0, 0xFFFF_FFFF;
    i32: -0x8000_0000, 0x7FFF_FFFF;
    i64: -0x8000_0000_0000_0000, 0x7FFF_FFFF_FFFF_FFFF;
}

/// In characters. Many members of assemblies can have the name of one parameter.
const LONGEST_STRING: usize = 4096;

/// A number of things: `1 byte`, `2 bytes`.
pub(super) struct Count<N>(pub(super) N, pub(super) &'static str);

impl<N: fmt::Display + PartialEq + From<u8>> fmt::Display for Count<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plural = if self.0 == N::from(1) { "" } else { "s" };
        write!(f, "{} {}{plural}", self.0, self.1)
    }
}
