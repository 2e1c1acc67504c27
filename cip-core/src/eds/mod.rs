//! Electronic Data Sheets: what a vendor tells of a device (CIP Vol. 1, chapter 7, and Vol. 3, chapter 7). Feature `std`.
//!
//! An EDS is a text file of sections, entries and fields:
//!
//! ```text
//! $ a comment
//! [Device]
//!     VendCode = 4660;                      $ Keyword = field, field, ... ;
//!     ProdName = "Demo " "block";           $ strings side by side are one
//! [IO_Info]
//!     Default = 0x0001;
//!     PollInfo = 0x0003, 1, 1;
//! ```
//!
//! [`Eds::parse`] reads any file and never fails for what is in it: everything that is wrong is a [`Diagnostic`] with its
//! place, a stable [`Code`], and what to do. What can be understood all the same is there:
//!
//! | | |
//! |---|---|
//! | [`Eds::document`] | the file as it was written, byte for byte, and its sections, entries and fields |
//! | [`Eds::device`], [`Eds::file`] | which devices it is for, and what the file is |
//! | [`Eds::io_info`], [`Eds::scan_entry`] | the I/O connections, and what a master needs of them |
//! | [`Eds::params`], [`Eds::groups`] | the parameters: path, type, limits, scaling, texts |
//! | [`Eds::assemblies`], [`Eds::layout`] | what stands where in the data of an assembly |
//!
//! ```
//! use cip_core::eds::{Code, Eds};
//!
//! let eds = Eds::parse("[Device]\nVendCode = 4660\nProdCode = 42;\n")?;
//! assert_eq!(eds.device().product_code, Some(42));
//! let first = &eds.diagnostics()[0];
//! assert_eq!(first.code, Code::MissingSection);
//! let missing = eds.diagnostics().iter().find(|found| found.code == Code::MissingSemicolon);
//! assert_eq!(missing.map(ToString::to_string).as_deref(),
//!     Some("2:16: error: `VendCode` does not end; put a `;` here [missing_semicolon]"));
//! # Ok::<(), cip_core::eds::TooLong>(())
//! ```
//!
//! Work and memory are bounded by the length of the file, which is at most [`MAX_FILE`] bytes.

mod check;
mod diagnostic;
mod document;
mod encoding;
mod fields;
mod layout;
mod literal;
mod model;
mod parser;
mod quotes;
mod scaling;
mod scan_entry;
mod span;
mod token;
mod value;

pub use diagnostic::{Code, Diagnostic, MAX_DIAGNOSTICS, Severity};
pub use document::{Content, Document, Entry, Field, Section};
pub use encoding::Encoding;
pub use layout::Slot;
pub use literal::{Date, Time};
pub use model::{
    Assembly, Choice, Constant, Device, EnumText, FileInfo, Group, GroupMember, IoConnection, IoData, IoInfo,
    Member, Param, ParamClass, Reference, Scaling, Stamp, Variant,
};
pub use scaling::{Decimal, Factors, Precision};
pub use scan_entry::ScanEntryError;
pub use span::{Place, Span};
pub use token::{Token, TokenKind};
pub use value::whole_number;

use std::string::String;
use std::vec::Vec;

use diagnostic::Findings;
use model::Model;

use crate::code::ClassId;
use crate::epath::Epath;

/// An Electronic Data Sheet: the file, what it says, and what is wrong with it.
#[derive(Debug, Clone)]
pub struct Eds {
    document: Document,
    model: Model,
    diagnostics: Vec<Diagnostic>,
    left_out: usize,
}

/// The file is longer than any EDS.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[error("{len} bytes are too many for an EDS, at most {MAX_FILE} are read")]
pub struct TooLong {
    /// Its length in bytes.
    pub len: usize,
}

impl Eds {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// Only for a file of more than [`MAX_FILE`] bytes. Whatever else is wrong is a diagnostic.
    pub fn parse(bytes: impl Into<Vec<u8>>) -> Result<Self, TooLong> {
        let bytes = bytes.into();
        if bytes.len() > MAX_FILE {
            return Err(TooLong { len: bytes.len() });
        }
        let mut findings = Findings::default();
        let document = Document::parse(bytes, &mut findings);
        let model = Model::read(&document, &mut findings);
        check::run(&document, &model, &mut findings);
        let (diagnostics, left_out) = findings.finish(|places| document.places(places));
        Ok(Self { document, model, diagnostics, left_out })
    }

    /// The file as it was written.
    #[must_use]
    pub const fn document(&self) -> &Document {
        &self.document
    }

    /// What is wrong with it, in the order of the places.
    #[must_use]
    pub fn diagnostics(&self) -> &[Diagnostic] {
        &self.diagnostics
    }

    /// How many diagnostics there are beyond [`MAX_DIAGNOSTICS`].
    #[must_use]
    pub const fn diagnostics_left_out(&self) -> usize {
        self.left_out
    }

    /// The worst that is wrong with it.
    #[must_use]
    pub fn worst(&self) -> Option<Severity> {
        self.diagnostics.iter().map(Diagnostic::severity).max()
    }

    /// `[File]`
    #[must_use]
    pub const fn file(&self) -> &FileInfo {
        &self.model.file
    }

    /// `[Device]`
    #[must_use]
    pub const fn device(&self) -> &Device {
        &self.model.device
    }

    /// `[Device Classification]`: the networks of the device, such as `DeviceNet`.
    #[must_use]
    pub fn classes(&self) -> &[String] {
        &self.model.classes
    }

    /// `[IO_Info]`
    #[must_use]
    pub const fn io_info(&self) -> Option<&IoInfo> {
        self.model.io.as_ref()
    }

    /// `[ParamClass]`
    #[must_use]
    pub const fn param_class(&self) -> Option<&ParamClass> {
        self.model.param_class.as_ref()
    }

    /// `[Params]`, with the texts of `EnumN` and `[EnumPar]`, in ascending order of their numbers.
    #[must_use]
    pub fn params(&self) -> &[Param] {
        &self.model.params
    }

    /// `ParamN`
    #[must_use]
    pub fn param(&self, number: u16) -> Option<&Param> {
        self.model.param(number)
    }

    /// `[Groups]`, in ascending order of their numbers.
    #[must_use]
    pub fn groups(&self) -> &[Group] {
        &self.model.groups
    }

    /// `AssemN` of `[Assembly]`, in ascending order of their numbers.
    #[must_use]
    pub fn assemblies(&self) -> &[Assembly] {
        &self.model.assemblies
    }

    /// `AssemN`
    #[must_use]
    pub fn assembly(&self, number: u16) -> Option<&Assembly> {
        self.model.assembly(number)
    }

    /// `VariantN` and `BitStringVariantN` of `[Assembly]`.
    #[must_use]
    pub fn variants(&self) -> &[Variant] {
        &self.model.variants
    }

    /// The assembly that a path leads to: the one with this path, or for a path to the Assembly object the one without
    /// a path whose number is that of the instance.
    #[must_use]
    pub fn assembly_at(&self, path: &[u8]) -> Option<&Assembly> {
        assembly_at(&self.model, path)
    }

    /// What stands where in the data of an assembly. `None` if that cannot be said, because the size of a member is
    /// not known or assemblies are too deep inside of one another.
    #[must_use]
    pub fn layout<'a>(&'a self, assembly: &'a Assembly) -> Option<Vec<Slot<'a>>> {
        layout::layout(&self.model, assembly)
    }
}

fn assembly_at<'a>(model: &'a Model, path: &[u8]) -> Option<&'a Assembly> {
    let target = Epath::packed(path).logical().ok().filter(|target| target.class.is_some())?;
    let same = |assembly: &&Assembly| {
        let theirs = assembly.target();
        theirs.is_some_and(|it| {
            // Without an attribute a path to an assembly means its data.
            it.class == target.class
                && it.instance == target.instance
                && (it.attribute == target.attribute || it.attribute.is_none() || target.attribute.is_none())
        })
    };
    let by_number = || {
        let number = target.instance.filter(|_| target.class == Some(ClassId::ASSEMBLY))?.0;
        model.assembly(number).filter(|assembly| assembly.path.is_empty())
    };
    model.assemblies.iter().find(same).or_else(by_number)
}

/// The longest file that is read, in bytes.
pub const MAX_FILE: usize = 16 * 1024 * 1024;

#[cfg(test)]
mod tests;
