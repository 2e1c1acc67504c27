//! `[ParamClass]`, `[Params]`, `[EnumPar]` and `[Groups]`.

use std::string::String;
use std::vec::Vec;

use super::{Spans, find};
use crate::code::DataTypeCode;
use crate::data_type::DataType;
use crate::eds::Span;
use crate::eds::diagnostic::{Code, Findings};
use crate::eds::document::{Content, Document, Entry};
use crate::eds::fields::{Entries, FieldReader, Need};
use crate::eds::literal;
use crate::epath::{Epath, LogicalPath};
use crate::parameter::{ParameterClassDescriptor, ParameterDescriptor};

/// `[ParamClass]`: the class attributes of the Parameter object.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ParamClass {
    /// `MaxInst`: the number of parameters.
    pub max_instance: Option<u16>,
    /// `Descriptor`
    pub descriptor: Option<ParameterClassDescriptor>,
    /// `CfgAssembly`: the configuration assembly; `None`: none.
    pub configuration_assembly: Option<u16>,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(in crate::eds) max_instance_spans: Spans,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(in crate::eds) descriptor_spans: Spans,
}

/// `ParamN`: a parameter.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Param {
    /// The number, which is also its instance of the Parameter object.
    pub number: u16,
    /// The packed path to its value; empty if only an assembly has it.
    #[cfg_attr(feature = "serde", serde(serialize_with = "super::serialize_path"))]
    pub path: Vec<u8>,
    /// What it can do.
    pub descriptor: ParameterDescriptor,
    /// Its type; `None` if the code means none.
    pub data_type: Option<DataType>,
    /// The size of its value in bytes. Of a string, that of a character.
    pub size: u8,
    /// Its name.
    pub name: String,
    /// Its engineering unit, such as `ms`.
    pub units: String,
    /// What it is.
    pub help: String,
    /// The smallest value. Of a string, the shortest length.
    pub minimum: Option<Constant>,
    /// The largest value. Of a string, the longest length.
    pub maximum: Option<Constant>,
    /// The value out of the box.
    pub default: Option<Constant>,
    /// How its value becomes an engineering value.
    pub scaling: Scaling,
    /// Digits after the point.
    pub decimal_places: u8,
    /// Texts for its values, of a bit string for its bits: from `EnumN`, or from `ParamN` of `[EnumPar]`.
    pub texts: Vec<EnumText>,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(in crate::eds) spans: Spans,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(in crate::eds) type_code: Option<u8>,
}

/// A value as it stands in a field.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(untagged))]
pub enum Constant {
    /// A whole number.
    Integer(i128),
    /// A number with a point.
    Real(f64),
    /// A string.
    Text(String),
}

/// The numbers of a scaling, as they stand in the file; `None`: not given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Scaling {
    /// Multiplier.
    pub multiplier: Option<u32>,
    /// Divisor.
    pub divisor: Option<u32>,
    /// Base.
    pub base: Option<u32>,
    /// Offset.
    pub offset: Option<i32>,
    /// The parameters that multiplier, divisor, base and offset are taken from; 0: none.
    pub links: [u16; 4],
}

/// A text for a value, or for a bit.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct EnumText {
    /// The value. Of a bit string, the number of the bit.
    pub value: i64,
    /// What it means.
    pub text: String,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(in crate::eds) span: Span,
}

/// `GroupN`: parameters that a tool shows together.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Group {
    /// The number in `GroupN`.
    pub number: u16,
    /// The name.
    pub name: String,
    /// The members.
    pub members: Vec<GroupMember>,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(in crate::eds) count: Option<u16>,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(in crate::eds) spans: Spans,
}

/// A member of a group.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(untagged))]
pub enum GroupMember {
    /// A parameter.
    Param(u16),
    /// Something else, by its keyword: a variant, a proxy parameter.
    Other(String),
}

impl Param {
    /// The path to its value.
    #[must_use]
    pub fn epath(&self) -> Epath<'_> {
        Epath::packed(&self.path)
    }

    /// Class, instance and attribute of its value; `None` if it has no path, or one that cannot be read.
    #[must_use]
    pub fn target(&self) -> Option<LogicalPath> {
        super::target(&self.path)
    }

    /// True for BYTE, WORD, DWORD and LWORD, whose texts are for bits.
    #[must_use]
    pub const fn is_bit_string(&self) -> bool {
        matches!(self.data_type, Some(DataType::Byte | DataType::Word | DataType::Dword | DataType::Lword))
    }

    /// Minimum, maximum or default in words. Of a string, minimum and maximum are lengths.
    #[must_use]
    pub fn text_of_constant(&self, constant: &Constant) -> String {
        let number = match constant {
            Constant::Text(text) => return std::format!("\"{text}\""),
            Constant::Real(number) => return std::format!("{number} {}", self.units).trim_end().into(),
            Constant::Integer(number) => *number,
        };
        let bytes = number.to_le_bytes();
        let text = match self.data_type {
            Some(DataType::Real | DataType::Lreal) | None => None,
            Some(_) => bytes.get(..self.size.into()).and_then(|bytes| self.text_of_bytes(bytes, |_| None)),
        };
        text.unwrap_or_else(|| std::format!("{number}"))
    }

    /// The text for a value, or for a bit.
    #[must_use]
    pub fn text_of(&self, value: i128) -> Option<&str> {
        let text = self.texts.iter().find(|text| i128::from(text.value) == value);
        text.map(|text| text.text.as_str())
    }
}

/// The number of a field of `ParamN`, from 0.
pub(in crate::eds) mod field {
    pub(in crate::eds) const PATH: usize = 2;
    pub(in crate::eds) const DESCRIPTOR: usize = 3;
    pub(in crate::eds) const DATA_TYPE: usize = 4;
    pub(in crate::eds) const SIZE: usize = 5;
    pub(in crate::eds) const NAME: usize = 6;
    pub(in crate::eds) const UNITS: usize = 7;
    pub(in crate::eds) const HELP: usize = 8;
    pub(in crate::eds) const MINIMUM: usize = 9;
    pub(in crate::eds) const MAXIMUM: usize = 10;
    pub(in crate::eds) const DEFAULT: usize = 11;
    pub(in crate::eds) const MULTIPLIER: usize = 12;
    pub(in crate::eds) const DIVISOR: usize = 13;
    pub(in crate::eds) const BASE: usize = 14;
    pub(in crate::eds) const LINKS: usize = 16;
}

pub(super) fn read_class(document: &Document, findings: &mut Findings) -> Option<ParamClass> {
    let entries = Entries::of(document, "ParamClass");
    entries.header()?;
    let mut read = |keyword: &str, what: &str| {
        let entry = entries.require(keyword, findings)?;
        let mut fields = FieldReader::new(entry, findings);
        let number = fields.number::<u16>(what, Need::Required);
        fields.finish();
        number
    };
    let spans = |keyword: &str| entries.find(keyword).map(Spans::of).unwrap_or_default();
    Some(ParamClass {
        max_instance: read("MaxInst", "`MaxInst`"),
        descriptor: read("Descriptor", "`Descriptor`").map(ParameterClassDescriptor::from_bits_retain),
        configuration_assembly: read("CfgAssembly", "`CfgAssembly`").filter(|&number| number != 0),
        max_instance_spans: spans("MaxInst"),
        descriptor_spans: spans("Descriptor"),
    })
}

pub(super) fn read(document: &Document, findings: &mut Findings) -> Vec<Param> {
    let entries = Entries::of(document, "Params");
    let numbered = entries.numbered("Param");
    let mut params: Vec<_> =
        numbered.into_iter().map(|(number, entry)| read_param(number, entry, findings)).collect();
    for (number, entry) in entries.numbered("Enum") {
        let texts = read_pairs(entry, findings);
        attach(&mut params, number, entry, texts, findings);
    }
    for (number, entry) in Entries::of(document, "EnumPar").numbered("Param") {
        let first = match find(&params, number, |param| param.number) {
            Some(param) if !param.is_bit_string() => first_value(param),
            _ => 0,
        };
        let texts = read_row(entry, first, findings);
        attach(&mut params, number, entry, texts, findings);
    }
    params
}

fn read_param(number: u16, entry: &Entry, findings: &mut Findings) -> Param {
    let mut fields = FieldReader::new(entry, findings);
    fields.reserved("write 0");
    let path = fields.sized_path();
    let descriptor = fields.number("the descriptor", Need::Required).unwrap_or(0);
    let type_code = fields.number("the data type", Need::Required);
    let size = fields.number("the data size", Need::Required).unwrap_or(0);
    let name = fields.string("the name", Need::Required).unwrap_or_default();
    let units = fields.string("the unit", Need::Optional).unwrap_or_default();
    let help = fields.string("the help text", Need::Optional).unwrap_or_default();
    let param = Param {
        number,
        path,
        descriptor: ParameterDescriptor::from_bits_retain(descriptor),
        data_type: type_code.and_then(|code| DataType::from_code(DataTypeCode(code))),
        size,
        name,
        units,
        help,
        minimum: constant(&mut fields, "the minimum"),
        maximum: constant(&mut fields, "the maximum"),
        default: constant(&mut fields, "the default"),
        scaling: Scaling {
            multiplier: fields.number("the multiplier", Need::Optional),
            divisor: fields.number("the divisor", Need::Optional),
            base: fields.number("the base", Need::Optional),
            offset: fields.number("the offset", Need::Optional),
            links: LINKS.map(|what| fields.number(what, Need::Optional).unwrap_or(0)),
        },
        decimal_places: fields.number("the number of decimal places", Need::Optional).unwrap_or(0),
        texts: Vec::new(),
        spans: Spans::of(entry),
        type_code,
    };
    // Newer editions have names in several languages behind the fields of old.
    for what in ["the international name", "the international unit", "the international help text"] {
        fields.word(what, Need::Optional);
    }
    fields.finish();
    param
}

/// Minimum, maximum or default.
fn constant(fields: &mut FieldReader<'_, '_>, what: &str) -> Option<Constant> {
    let field = fields.field().filter(|field| !field.is_empty())?;
    let constant = match &field.content {
        Content::Empty => None,
        Content::Text(text) => Some(Constant::Text(text.clone())),
        Content::Word(word) => match literal::integer(word) {
            Some(number) => Some(Constant::Integer(number)),
            None => literal::real(word).map(Constant::Real),
        },
    };
    if constant.is_none() {
        let message = format_args!("{what} is {field}; write a number, or a string in quotes");
        fields.findings.add(Code::NotANumber, field.span, message);
    }
    constant
}

/// `EnumN = value, "text", value, "text" ...`
fn read_pairs(entry: &Entry, findings: &mut Findings) -> Vec<EnumText> {
    let mut fields = FieldReader::new(entry, findings);
    let mut texts = Vec::new();
    while !fields.is_at_end() {
        let value = fields.number("the value", Need::Required);
        let span = fields.last_span();
        if fields.is_at_end() {
            let message = format_args!("a value without a text; write pairs of a value and its text");
            fields.findings.add(Code::EnumPairs, span, message);
            break;
        }
        let text = fields.string("the text", Need::Required);
        if let (Some(value), Some(text)) = (value, text) {
            texts.push(EnumText { value, text, span });
        }
    }
    texts
}

/// `ParamN = "text", "text" ...`: for the first value, the next, and so on.
fn read_row(entry: &Entry, first: i64, findings: &mut Findings) -> Vec<EnumText> {
    let mut fields = FieldReader::new(entry, findings);
    let mut texts = Vec::new();
    let mut value = first;
    while !fields.is_at_end() {
        let text = fields.string("the text", Need::Optional);
        let span = fields.last_span();
        texts.extend(text.map(|text| EnumText { value, text, span }));
        value = value.saturating_add(1);
    }
    texts
}

fn attach(params: &mut [Param], number: u16, entry: &Entry, texts: Vec<EnumText>, findings: &mut Findings) {
    let found = params.binary_search_by_key(&number, |param| param.number).ok();
    let Some(param) = found.and_then(|index| params.get_mut(index)) else {
        let message = format_args!("texts for parameter {number}, which [Params] does not have");
        findings.add(Code::UnknownParameter, entry.keyword_span, message);
        return;
    };
    if param.texts.is_empty() {
        param.texts = texts;
    } else {
        let message = format_args!("parameter {number} has texts in [Params] already; remove these");
        findings.add(Code::EnumDuplicate, entry.keyword_span, message);
    }
}

fn first_value(param: &Param) -> i64 {
    match param.minimum {
        Some(Constant::Integer(minimum)) => i64::try_from(minimum).unwrap_or(0),
        _ => 0,
    }
}

pub(super) fn read_groups(document: &Document, findings: &mut Findings) -> Vec<Group> {
    let read = |(number, entry)| {
        let mut fields = FieldReader::new(entry, findings);
        let name = fields.string("the name", Need::Required).unwrap_or_default();
        let count = fields.number("the number of members", Need::Required);
        let mut members = Vec::new();
        while !fields.is_at_end() {
            let Some(word) = fields.word("the member", Need::Required) else { continue };
            members.push(match word.parse() {
                Ok(number) => GroupMember::Param(number),
                Err(_) => GroupMember::Other(word),
            });
        }
        Group { number, name, members, count, spans: Spans::of(entry) }
    };
    Entries::of(document, "Groups").numbered("Group").into_iter().map(read).collect()
}

const LINKS: [&str; 4] = ["the multiplier link", "the divisor link", "the base link", "the offset link"];
