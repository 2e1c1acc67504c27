//! `[Assembly]`.

use std::string::String;
use std::vec::Vec;

use super::Spans;
use crate::eds::Span;
use crate::eds::diagnostic::{Code, Findings};
use crate::eds::document::{Content, Document, Field};
use crate::eds::fields::{Entries, FieldReader, Need};
use crate::eds::literal;
use crate::epath::{Epath, LogicalPath};

/// `AssemN`: what stands where in a block of data.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Assembly {
    /// The number in `AssemN`. It need not be the instance of the Assembly object.
    pub number: u16,
    /// The name.
    pub name: String,
    /// The packed path to the data; empty if there is none.
    #[cfg_attr(feature = "serde", serde(serialize_with = "super::serialize_path"))]
    pub path: Vec<u8>,
    /// Bytes; `None` if not given.
    pub size: Option<u16>,
    /// The descriptor.
    pub descriptor: u16,
    /// The members, from bit 0 of the first byte upward.
    pub members: Vec<Member>,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(in crate::eds) spans: Spans,
}

/// A member of an assembly.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Member {
    /// Its size in bits; `None`: that of what it refers to.
    pub bits: Option<u32>,
    /// What it is.
    pub reference: Reference,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(in crate::eds) span: Span,
}

/// What a member is.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Reference {
    /// Nothing: bits that fill up.
    Padding,
    /// `ParamN`, or `ParamN:B` for a piece of it that begins with bit B.
    Param {
        /// The parameter.
        number: u16,
        /// The first bit of it.
        bit: u16,
    },
    /// `AssemN`
    Assembly(u16),
    /// `VariantN`
    Variant(u16),
    /// `BitStringVariantN`
    BitVariant(u16),
    /// A packed path.
    Path(#[cfg_attr(feature = "serde", serde(serialize_with = "super::serialize_path"))] Vec<u8>),
    /// Something else, by its keyword: an array, a proxied assembly.
    Other(String),
}

/// `VariantN` or `BitStringVariantN`: what a piece of data is depends on a value elsewhere.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Variant {
    /// True for `BitStringVariantN`, whose choices depend on one bit each.
    pub is_of_bits: bool,
    /// The number in the keyword.
    pub number: u16,
    /// The name.
    pub name: String,
    /// What its value decides, such as `Param1` or `Assem1:0:4`.
    pub selector: String,
    /// What it can be.
    pub choices: Vec<Choice>,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(in crate::eds) spans: Spans,
}

/// What a variant is for one value of its selector.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Choice {
    /// The value of the selector, or the number of a bit of it.
    pub value: i64,
    /// What the data are then; of a bit, when it is set and when it is not.
    pub references: Vec<Reference>,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(in crate::eds) span: Span,
}

impl Assembly {
    /// The path to the data.
    #[must_use]
    pub fn epath(&self) -> Epath<'_> {
        Epath::packed(&self.path)
    }

    /// Class, instance and attribute of the data; `None` if there is no path, or one that cannot be read.
    #[must_use]
    pub fn target(&self) -> Option<LogicalPath> {
        super::target(&self.path)
    }
}

/// The field where the members of an assembly begin, from 0.
pub(in crate::eds) const SIZE_FIELD: usize = 2;

pub(super) fn read(document: &Document, findings: &mut Findings) -> (Vec<Assembly>, Vec<Variant>) {
    let entries = Entries::of(document, "Assembly");
    let mut assemblies = Vec::new();
    for (number, entry) in entries.numbered("Assem") {
        let mut fields = FieldReader::new(entry, findings);
        let mut assembly = Assembly {
            number,
            name: fields.string("the name", Need::Optional).unwrap_or_default(),
            path: fields.path().unwrap_or_default(),
            size: fields.number("the size in bytes", Need::Optional),
            descriptor: fields.number("the descriptor", Need::Optional).unwrap_or(0),
            members: Vec::new(),
            spans: Spans::of(entry),
        };
        fields.reserved("leave it empty");
        fields.reserved("leave it empty");
        read_members(&mut fields, &mut assembly.members);
        assemblies.push(assembly);
    }
    let mut variants: Vec<Variant> = Vec::new();
    for (stem, is_of_bits) in [("Variant", false), ("BitStringVariant", true)] {
        for (number, entry) in entries.numbered(stem) {
            let fields = FieldReader::new(entry, findings);
            variants.push(read_variant(number, is_of_bits, fields, Spans::of(entry)));
        }
    }
    (assemblies, variants)
}

/// Pairs of a size in bits and a reference.
fn read_members(fields: &mut FieldReader<'_, '_>, members: &mut Vec<Member>) {
    while !fields.is_at_end() {
        let bits = fields.number("the member size in bits", Need::Optional);
        let size_span = fields.last_span();
        let Some(field) = fields.field() else {
            if bits.is_some() {
                let message = format_args!(
                    "a member size without a reference; write `,` behind it for bits that fill up"
                );
                fields.findings.add(Code::MemberPairs, size_span, message);
                members.push(Member { bits, reference: Reference::Padding, span: size_span });
            }
            break;
        };
        let reference = reference(field, fields.findings);
        let span = if field.is_empty() { size_span } else { field.span };
        // A comma too many at the end says nothing.
        if bits.is_some() || reference != Reference::Padding {
            members.push(Member { bits, reference, span });
        }
    }
}

fn read_variant(number: u16, is_of_bits: bool, mut fields: FieldReader<'_, '_>, spans: Spans) -> Variant {
    let name = fields.string("the name", Need::Optional).unwrap_or_default();
    // A variant has four reserved fields here, a variant of bits its help text.
    for _ in 0..if is_of_bits { 1 } else { 4 } {
        fields.field();
    }
    let selector = fields.word("the selector", Need::Required).unwrap_or_default();
    let mut choices = Vec::new();
    while !fields.is_at_end() {
        let value = fields.number("the value", Need::Required);
        let span = fields.last_span();
        let mut references = Vec::new();
        for _ in 0..if is_of_bits { 2 } else { 1 } {
            let Some(field) = fields.field() else { break };
            references.push(reference(field, fields.findings));
        }
        if references.is_empty() {
            let message = format_args!(
                "a value without a reference; write pairs of a value and what the data are then"
            );
            fields.findings.add(Code::MemberPairs, span, message);
        }
        choices.extend(value.map(|value| Choice { value, references, span }));
    }
    Variant { is_of_bits, number, name, selector, choices, spans }
}

fn reference(field: &Field, findings: &mut Findings) -> Reference {
    let word = match &field.content {
        Content::Empty => return Reference::Padding,
        Content::Text(text) if text.trim().is_empty() => return Reference::Padding,
        Content::Text(text) => {
            return match literal::path(text) {
                Some(path) if Epath::packed(&path).segments().all(|segment| segment.is_ok()) => {
                    Reference::Path(path)
                }
                _ => {
                    let message = format_args!(
                        "the reference is {field}; write ParamN, AssemN, or a path like \"20 04 24 65 30 03\""
                    );
                    findings.add(Code::MemberReference, field.span, message);
                    Reference::Other(text.clone())
                }
            };
        }
        Content::Word(word) => word,
    };
    let (keyword, bit) = word.split_once(':').unwrap_or((word, "0"));
    let stem = keyword.trim_end_matches(|character: char| character.is_ascii_digit());
    let number = keyword.get(stem.len()..).and_then(|digits| digits.parse().ok());
    let reference = match (stem.to_ascii_lowercase().as_str(), number) {
        ("param", Some(number)) => bit.parse().ok().map(|bit| Reference::Param { number, bit }),
        ("assem", Some(number)) => Some(Reference::Assembly(number)),
        ("variant", Some(number)) => Some(Reference::Variant(number)),
        ("bitstringvariant", Some(number)) => Some(Reference::BitVariant(number)),
        _ if stem.starts_with(|character: char| character.is_ascii_alphabetic()) => {
            Some(Reference::Other(word.clone()))
        }
        _ => None,
    };
    reference.unwrap_or_else(|| {
        let message = format_args!(
            "the reference is {field}; write ParamN, AssemN, or a path like \"20 04 24 65 30 03\""
        );
        findings.add(Code::MemberReference, field.span, message);
        Reference::Other(word.clone())
    })
}
