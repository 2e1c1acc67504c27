//! `[File]`, `[Device]` and `[Device Classification]`.

use super::super::diagnostic::{Code, Findings};
use super::super::document::Document;
use super::super::model::Model;
use super::super::span::Span;
use crate::code::VendorId;

pub(super) fn check(document: &Document, model: &Model, findings: &mut Findings) {
    identity(model, findings);
    dates(document, model, findings);
    classification(document, model, findings);
}

fn identity(model: &Model, findings: &mut Findings) {
    let device = &model.device;
    let spans = &device.spans;
    if device.vendor == Some(VendorId(0)) {
        let message = format_args!("vendor 0 is nobody; write the number that ODVA gave to the vendor");
        findings.add(Code::Identity, spans.vendor.field(0), message);
    }
    if device.product_code == Some(0) {
        let message = format_args!("product code 0 is not allowed; write 1 to 65535");
        findings.add(Code::Identity, spans.product_code.field(0), message);
    }
    let Some(revision) = device.revision else { return };
    if !(1..=127).contains(&revision.major) {
        let message = format_args!("major revision {} is not allowed; write 1 to 127", revision.major);
        findings.add(Code::Identity, spans.major.field(0), message);
    }
    if revision.minor == 0 {
        let message = format_args!("minor revision 0 is not allowed; write 1 to 255");
        findings.add(Code::Identity, spans.minor.field(0), message);
    }
}

fn dates(document: &Document, model: &Model, findings: &mut Findings) {
    let (created, modified) = (model.file.created, model.file.modified);
    let (Some(created_on), Some(modified_on)) = (created.date, modified.date) else { return };
    if modified < created {
        let span =
            document.section("File").and_then(|section| section.entries.iter().find(|it| it.is("ModDate")));
        let span = span.map_or(Span::at(0), |entry| entry.field_span(0));
        let message =
            format_args!("modified on {modified_on}, and created on {created_on}; correct one of them");
        findings.add(Code::ModifiedBeforeCreated, span, message);
    }
}

fn classification(document: &Document, model: &Model, findings: &mut Findings) {
    let Some(section) = document.section("Device Classification") else { return };
    if !model.classes.iter().any(|class| class.eq_ignore_ascii_case("DeviceNet")) {
        let message = format_args!(
            "the device is not classified for DeviceNet; add `ClassN = DeviceNet;` if it is one"
        );
        findings.add(Code::NotDeviceNet, section.span, message);
    }
}
