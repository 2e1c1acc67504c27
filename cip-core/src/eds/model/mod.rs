//! What the sections of a file say, each in a type of its own. What is wrong with a field is a finding, and the field is
//! absent or zero.

mod assembly;
mod device;
mod io;
mod param;

pub(super) use assembly::SIZE_FIELD as ASSEMBLY_SIZE_FIELD;
pub use assembly::{Assembly, Choice, Member, Reference, Variant};
pub use device::{Device, FileInfo, Stamp};
pub(super) use io::keyword as io_keyword;
pub use io::{IoConnection, IoData, IoInfo};
pub(super) use param::field as param_field;
pub use param::{Constant, EnumText, Group, GroupMember, Param, ParamClass, Scaling};

use std::string::String;
use std::vec::Vec;

use super::diagnostic::Findings;
use super::document::{Document, Entry};
use crate::epath::{Epath, LogicalPath};

/// Everything that is known of a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Model {
    pub(super) file: FileInfo,
    pub(super) device: Device,
    pub(super) classes: Vec<String>,
    pub(super) io: Option<IoInfo>,
    pub(super) param_class: Option<ParamClass>,
    /// In ascending order of their numbers, like everything that has one.
    pub(super) params: Vec<Param>,
    pub(super) groups: Vec<Group>,
    pub(super) assemblies: Vec<Assembly>,
    pub(super) variants: Vec<Variant>,
}

impl Model {
    pub(super) fn read(document: &Document, findings: &mut Findings) -> Self {
        let (assemblies, variants) = assembly::read(document, findings);
        Self {
            file: device::read_file(document, findings),
            device: device::read_device(document, findings),
            classes: device::read_classes(document, findings),
            io: io::read(document, findings),
            param_class: param::read_class(document, findings),
            params: param::read(document, findings),
            groups: param::read_groups(document, findings),
            assemblies,
            variants,
        }
    }

    pub(super) fn param(&self, number: u16) -> Option<&Param> {
        find(&self.params, number, |param| param.number)
    }

    pub(super) fn assembly(&self, number: u16) -> Option<&Assembly> {
        find(&self.assemblies, number, |assembly| assembly.number)
    }

    pub(super) fn variant(&self, is_of_bits: bool, number: u16) -> Option<&Variant> {
        let key = |variant: &Variant| (variant.is_of_bits, variant.number);
        let found = self.variants.binary_search_by_key(&(is_of_bits, number), key);
        found.ok().and_then(|index| self.variants.get(index))
    }
}

/// What has this number, in a list that ascends.
fn find<T>(list: &[T], number: u16, number_of: impl Fn(&T) -> u16) -> Option<&T> {
    list.binary_search_by_key(&number, number_of).ok().and_then(|index| list.get(index))
}

/// A path as lower-case hexadecimal digits.
#[cfg(feature = "serde")]
fn serialize_path<S: serde::Serializer>(path: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&crate::text::LowerHex(path))
}

/// The spans of an entry's fields, kept by what was read from it, so that a later check can point there.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Spans {
    keyword: super::Span,
    end: super::Span,
    fields: Vec<super::Span>,
}

impl Spans {
    fn of(entry: &Entry) -> Self {
        Self {
            keyword: entry.keyword_span,
            end: super::Span::at(entry.span.end),
            fields: entry.fields.iter().map(|field| field.span).collect(),
        }
    }

    /// Where the keyword stands.
    pub(super) const fn keyword(&self) -> super::Span {
        self.keyword
    }

    /// Where a field stands, or where it should.
    pub(super) fn field(&self, index: usize) -> super::Span {
        self.fields.get(index).copied().unwrap_or(self.end)
    }
}

/// Class, instance and attribute that a packed path names; `None` if it is empty, or cannot be read.
fn target(path: &[u8]) -> Option<LogicalPath> {
    if path.is_empty() { None } else { Epath::packed(path).logical().ok() }
}
