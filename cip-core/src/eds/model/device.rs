//! `[File]`, `[Device]` and `[Device Classification]`.

use std::string::String;
use std::vec::Vec;

use super::Spans;
use crate::code::{DeviceType, VendorId};
use crate::eds::diagnostic::{Code, Findings};
use crate::eds::document::Document;
use crate::eds::fields::{Entries, FieldReader, Need};
use crate::eds::literal::{self, Date, Time};
use crate::identity::{PRODUCT_NAME_MAX, Revision};

/// `[File]`: what the file is.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct FileInfo {
    /// `DescText`
    pub description: Option<String>,
    /// `CreateDate` and `CreateTime`
    pub created: Stamp,
    /// `ModDate` and `ModTime`
    pub modified: Stamp,
    /// `Revision` of the file, not of the device: major and minor.
    pub revision: Option<(u16, u16)>,
    /// `HomeURL`
    pub home_url: Option<String>,
}

/// A date and the time on it, as far as they are given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Stamp {
    /// The date.
    pub date: Option<Date>,
    /// The time.
    pub time: Option<Time>,
}

/// `[Device]`: which devices the file is for.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Device {
    /// `VendCode`: Identity attribute 1.
    pub vendor: Option<VendorId>,
    /// `VendName`
    pub vendor_name: Option<String>,
    /// `ProdType`: Identity attribute 2.
    pub device_type: Option<DeviceType>,
    /// `ProdTypeStr`
    pub device_type_name: Option<String>,
    /// `ProdCode`: Identity attribute 3.
    pub product_code: Option<u16>,
    /// `MajRev` and `MinRev`: Identity attribute 4.
    pub revision: Option<Revision>,
    /// `ProdName`: Identity attribute 7.
    pub product_name: Option<String>,
    /// `Catalog`
    pub catalog: Option<String>,
    /// `Icon`, the name of a file.
    pub icon: Option<String>,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(in crate::eds) spans: DeviceSpans,
}

/// Where the numbers of the identity stand.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::eds) struct DeviceSpans {
    pub(in crate::eds) vendor: Spans,
    pub(in crate::eds) product_code: Spans,
    pub(in crate::eds) major: Spans,
    pub(in crate::eds) minor: Spans,
}

/// Reads the only field of entries that a section has once each.
struct Scalars<'a, 'f> {
    entries: Entries<'a>,
    findings: &'f mut Findings,
}

impl<'a> Scalars<'a, '_> {
    fn read<T>(
        &mut self,
        keyword: &str,
        need: Need,
        read: impl FnOnce(&mut FieldReader<'a, '_>) -> Option<T>,
    ) -> Option<T> {
        let entry = match need {
            Need::Required => self.entries.require(keyword, self.findings)?,
            Need::Optional => self.entries.find(keyword)?,
        };
        let mut fields = FieldReader::new(entry, self.findings);
        let value = read(&mut fields);
        fields.finish();
        value
    }

    fn string(&mut self, keyword: &str, need: Need) -> Option<String> {
        self.read(keyword, need, |fields| fields.string(&quoted(keyword), need))
    }

    fn date(&mut self, keyword: &str) -> Option<Date> {
        self.read(keyword, Need::Required, |fields| {
            fields.literal(&quoted(keyword), Code::BadDate, "month-day-year, like 01-31-2026", literal::date)
        })
    }

    fn time(&mut self, keyword: &str) -> Option<Time> {
        self.read(keyword, Need::Required, |fields| {
            fields.literal(
                &quoted(keyword),
                Code::BadTime,
                "hours:minutes:seconds, like 08:30:00",
                literal::time,
            )
        })
    }

    fn spans(&self, keyword: &str) -> Spans {
        self.entries.find(keyword).map(Spans::of).unwrap_or_default()
    }
}

pub(super) fn read_file(document: &Document, findings: &mut Findings) -> FileInfo {
    let mut section = Scalars { entries: Entries::of(document, "File"), findings };
    FileInfo {
        description: section.string("DescText", Need::Required),
        created: Stamp { date: section.date("CreateDate"), time: section.time("CreateTime") },
        modified: Stamp { date: section.date("ModDate"), time: section.time("ModTime") },
        revision: section.read("Revision", Need::Required, |fields| {
            fields.literal("`Revision`", Code::BadRevision, "major.minor, like 1.0", literal::revision)
        }),
        home_url: section.string("HomeURL", Need::Optional),
    }
}

pub(super) fn read_device(document: &Document, findings: &mut Findings) -> Device {
    let mut section = Scalars { entries: Entries::of(document, "Device"), findings };
    let number = |section: &mut Scalars<'_, '_>, keyword: &str| {
        section.read(keyword, Need::Required, |fields| fields.number(&quoted(keyword), Need::Required))
    };
    let vendor = number(&mut section, "VendCode").map(VendorId);
    let vendor_name = section.string("VendName", Need::Required);
    let device_type = number(&mut section, "ProdType").map(DeviceType);
    let device_type_name = section.string("ProdTypeStr", Need::Required);
    let product_code = number(&mut section, "ProdCode");
    let byte = |section: &mut Scalars<'_, '_>, keyword: &str| {
        section.read(keyword, Need::Required, |fields| fields.number::<u8>(&quoted(keyword), Need::Required))
    };
    let (major, minor) = (byte(&mut section, "MajRev"), byte(&mut section, "MinRev"));
    let product_name = section.read("ProdName", Need::Required, read_product_name);
    Device {
        vendor,
        vendor_name,
        device_type,
        device_type_name,
        product_code,
        revision: major.zip(minor).map(|(major, minor)| Revision { major, minor }),
        product_name,
        catalog: section.string("Catalog", Need::Optional),
        icon: section.string("Icon", Need::Optional),
        spans: DeviceSpans {
            vendor: section.spans("VendCode"),
            product_code: section.spans("ProdCode"),
            major: section.spans("MajRev"),
            minor: section.spans("MinRev"),
        },
    }
}

pub(super) fn read_classes(document: &Document, findings: &mut Findings) -> Vec<String> {
    let classes = Entries::of(document, "Device Classification").numbered("Class");
    // A class may be followed by subclasses.
    let read = |(_, entry)| FieldReader::new(entry, findings).word("the class", Need::Required);
    classes.into_iter().filter_map(read).collect()
}

fn read_product_name(fields: &mut FieldReader<'_, '_>) -> Option<String> {
    let name = fields.string("`ProdName`", Need::Required)?;
    let len = name.chars().count();
    if len > PRODUCT_NAME_MAX {
        let message =
            format_args!("the product name has {len} characters; a device can tell {PRODUCT_NAME_MAX}");
        fields.findings.add(Code::StringTooLong, fields.last_span(), message);
    }
    Some(name)
}

fn quoted(keyword: &str) -> String {
    std::format!("`{keyword}`")
}
