//! `[ParamClass]`, `[Params]`, `[EnumPar]` and `[Groups]`.

use std::collections::{HashMap, HashSet};

use super::super::diagnostic::{Code, Findings};
use super::super::fields::Count;
use super::super::model::{Constant, GroupMember, Model, Param, param_field as field};
use crate::code::ClassId;
use crate::data_type::DataType;
use crate::names::{self, Access};
use crate::parameter::{ParameterClassDescriptor, ParameterDescriptor};

pub(super) fn check(model: &Model, findings: &mut Findings) {
    class(model, findings);
    let mut paths: HashMap<&[u8], u16> = HashMap::new();
    for param in &model.params {
        data_type(param, findings);
        limits(param, findings);
        texts_of_object(param, findings);
        path(param, findings);
        scaling(model, param, findings);
        enumeration(param, findings);
        if !param.path.is_empty() {
            let first = *paths.entry(&param.path).or_insert(param.number);
            if first != param.number {
                let message = format_args!("parameter {first} has the same path");
                findings.add(Code::SamePath, param.spans.field(field::PATH), message);
            }
        }
    }
    groups(model, findings);
}

fn class(model: &Model, findings: &mut Findings) {
    let Some(class) = &model.param_class else { return };
    let highest = model.params.last().map_or(0, |param| param.number);
    if let Some(max) = class.max_instance.filter(|&max| max != highest) {
        let message =
            format_args!("`MaxInst` is {max}, and the highest parameter is {highest}; write {highest}");
        findings.add(Code::ParameterCount, class.max_instance_spans.field(0), message);
    }
    let descriptor = class.descriptor.unwrap_or_default();
    let reserved = descriptor.difference(ParameterClassDescriptor::all()).bits();
    if reserved != 0 {
        let message = format_args!("bits 4 to 15 of the descriptor are reserved; clear 0x{reserved:04X}");
        findings.add(Code::Reserved, class.descriptor_spans.field(0), message);
    }
}

fn data_type(param: &Param, findings: &mut Findings) {
    let Some(code) = param.type_code else { return };
    let span = param.spans.field(field::DATA_TYPE);
    let Some(ty) = param.data_type else {
        let message = format_args!("0x{code:02X} is no data type; write 0xC1 to 0xDE, such as 0xC7 for UINT");
        findings.add(Code::UnknownDataType, span, message);
        return;
    };
    let canonical = ty.code();
    if code != canonical.0 {
        let message =
            format_args!("{code} is the number of {canonical} in old files; write 0x{:02X}", canonical.0);
        findings.add(Code::OldDataType, span, message);
    }
    if let Some(size) = ty.size().filter(|&size| size != usize::from(param.size)) {
        let message = format_args!(
            "{canonical} has {}, and the data size is {}; write {size}",
            Count(size, "byte"),
            param.size
        );
        findings.add(Code::DataSize, param.spans.field(field::SIZE), message);
    }
}

fn limits(param: &Param, findings: &mut Findings) {
    let Some(ty) = param.data_type else { return };
    let named = [
        (&param.minimum, field::MINIMUM, "the minimum"),
        (&param.maximum, field::MAXIMUM, "the maximum"),
        (&param.default, field::DEFAULT, "the default"),
    ];
    // Of a string, minimum and maximum are lengths.
    let range = range(ty);
    for (constant, index, what) in named {
        let Some(constant) = constant else { continue };
        let span = param.spans.field(index);
        match (constant, range) {
            (Constant::Integer(number), Some((least, most))) if !(least..=most).contains(number) => {
                let name = ty.code();
                let message = format_args!("{what} is {number}; {name} has {least} to {most}");
                findings.add(Code::ValueRange, span, message);
            }
            (Constant::Real(number), Some(_)) => {
                let message = format_args!("{what} is {number}; {} has whole numbers", ty.code());
                findings.add(Code::ValueRange, span, message);
            }
            (Constant::Text(text), Some(_)) => {
                let message = format_args!("{what} is \"{text}\"; {} has numbers", ty.code());
                findings.add(Code::ValueRange, span, message);
            }
            (Constant::Integer(_) | Constant::Real(_) | Constant::Text(_), _) => {}
        }
    }
    let (minimum, maximum) = (number(&param.minimum), number(&param.maximum));
    if let (Some(least), Some(most)) = (minimum, maximum)
        && least > most
    {
        let message = format_args!("the minimum {least} is above the maximum {most}; exchange them");
        findings.add(Code::MinimumAboveMaximum, param.spans.field(field::MINIMUM), message);
        return;
    }
    let Some(default) = number(&param.default) else { return };
    let is_outside =
        minimum.is_some_and(|least| default < least) || maximum.is_some_and(|most| default > most);
    if is_outside && !is_string(ty) {
        let message =
            format_args!("the default {default} is not between minimum and maximum; correct one of them");
        findings.add(Code::DefaultOutOfRange, param.spans.field(field::DEFAULT), message);
    }
}

fn texts_of_object(param: &Param, findings: &mut Findings) {
    // What is seen by an assembly only, no Parameter object has to tell.
    if param.target().is_none_or(|target| target.class != Some(ClassId::PARAMETER)) {
        return;
    }
    let texts = [
        (&param.name, field::NAME, 16, "name"),
        (&param.units, field::UNITS, 4, "unit"),
        (&param.help, field::HELP, 64, "help text"),
    ];
    for (text, index, most, what) in texts {
        let len = text.chars().count();
        if len > most {
            let message = format_args!("the {what} has {len} characters; a Parameter object can tell {most}");
            findings.add(Code::LongParameterText, param.spans.field(index), message);
        }
    }
}

fn path(param: &Param, findings: &mut Findings) {
    let span = param.spans.field(field::PATH);
    let Some(target) = param.target() else { return };
    let (Some(class), Some(instance)) = (target.class, target.instance) else {
        let message = format_args!("the path names no class and instance; a tool cannot read the parameter");
        findings.add(Code::PathIncomplete, span, message);
        return;
    };
    let Some(attribute) = target.attribute else {
        let message = format_args!("the path names no attribute; add it, like 30 01");
        findings.add(Code::PathIncomplete, span, message);
        return;
    };
    if class == ClassId::PARAMETER && attribute.0 == 1 && instance.0 != param.number {
        let message = format_args!(
            "the path leads to instance {} of the Parameter object; parameter {} is instance {}",
            instance.0, param.number, param.number
        );
        findings.add(Code::ParameterInstance, span, message);
    }
    let Some(info) = names::attribute_info(class, instance, attribute) else { return };
    if let (Some(theirs), Some(ours)) = (info.shape.data_type(), param.data_type)
        && theirs.size() != ours.size()
    {
        let message = format_args!(
            "{class} attribute {} ({}) is {}, and the data type is {}",
            attribute.0,
            info.name,
            theirs.code(),
            ours.code()
        );
        findings.add(Code::ObjectMismatch, param.spans.field(field::DATA_TYPE), message);
    }
    if info.access == Access::Get && !param.descriptor.contains(ParameterDescriptor::READ_ONLY) {
        let message = format_args!(
            "{class} attribute {} ({}) cannot be written; set 0x0010 (read only)",
            attribute.0, info.name
        );
        findings.add(Code::ObjectMismatch, param.spans.field(field::DESCRIPTOR), message);
    }
}

fn scaling(model: &Model, param: &Param, findings: &mut Findings) {
    let scaling = &param.scaling;
    let has = |bits| param.descriptor.contains(bits);
    if !has(ParameterDescriptor::SCALING) {
        let is_neutral = |number: Option<u32>| matches!(number, None | Some(0 | 1));
        let is_unused = is_neutral(scaling.multiplier)
            && is_neutral(scaling.divisor)
            && is_neutral(scaling.base)
            && scaling.offset.unwrap_or(0) == 0;
        if !is_unused {
            let message = format_args!(
                "scaling is given, and descriptor bit 2 does not announce it; set 0x0004, or write 1, 1, 1, 0"
            );
            findings.add(Code::ScalingUnused, param.spans.field(field::MULTIPLIER), message);
        }
    } else {
        let given = [
            (scaling.multiplier, field::MULTIPLIER, "multiplier"),
            (scaling.divisor, field::DIVISOR, "divisor"),
            (scaling.base, field::BASE, "base"),
        ];
        for ((number, index, what), link) in given.into_iter().zip(scaling.links) {
            if number.unwrap_or(0) == 0 && (link == 0 || !has(ParameterDescriptor::SCALING_LINKS)) {
                let message = format_args!(
                    "the value is scaled (descriptor bit 2), and the {what} is missing or 0; write 1 if it shall not matter"
                );
                findings.add(Code::Scaling, param.spans.field(index), message);
            }
        }
    }
    if has(ParameterDescriptor::EXTENDED_PRECISION) && !has(ParameterDescriptor::SCALING) {
        let message = format_args!(
            "extended precision (bit 6) is of scaling, which bit 2 does not announce; set 0x0004, or clear 0x0040"
        );
        findings.add(Code::ScalingLink, param.spans.field(field::DESCRIPTOR), message);
    }
    if has(ParameterDescriptor::SCALING_LINKS) && scaling.links == [0; 4] {
        let message = format_args!(
            "scaling links (descriptor bit 3) without a link; name the parameters, or clear 0x0008"
        );
        findings.add(Code::ScalingLink, param.spans.field(field::DESCRIPTOR), message);
    }
    for (offset, &link) in scaling.links.iter().enumerate().filter(|&(_, &link)| link != 0) {
        if model.param(link).is_none() {
            let message = format_args!("there is no parameter {link}; name one of [Params], or write 0");
            let index = field::LINKS.saturating_add(offset);
            findings.add(Code::UnknownParameter, param.spans.field(index), message);
        }
    }
}

fn enumeration(param: &Param, findings: &mut Findings) {
    let span = param.spans.field(field::DESCRIPTOR);
    match (param.descriptor.contains(ParameterDescriptor::ENUMERATED), param.texts.is_empty()) {
        (true, true) => {
            let number = param.number;
            let message =
                format_args!("descriptor bit 1 announces texts; add `Enum{number}`, or clear 0x0002");
            findings.add(Code::EnumAnnounced, span, message);
        }
        (false, false) => {
            let message = format_args!(
                "there are texts for its values, and descriptor bit 1 does not announce them; set 0x0002"
            );
            findings.add(Code::EnumAnnounced, span, message);
        }
        (true, false) | (false, true) => {}
    }
    let mut seen = HashSet::new();
    let (least, most) = match param.is_bit_string() {
        true => (Some(0.0), Some(f64::from(param.size) * 8.0 - 1.0)),
        false => (number(&param.minimum), number(&param.maximum)),
    };
    for text in &param.texts {
        if !seen.insert(text.value) {
            let message = format_args!("value {} has a text already; the first counts", text.value);
            findings.add(Code::EnumDuplicate, text.span, message);
        }
        let Ok(value) = i32::try_from(text.value).map(f64::from) else { continue };
        if least.is_some_and(|least| value < least) || most.is_some_and(|most| value > most) {
            let what = if param.is_bit_string() { "bit" } else { "value" };
            let message =
                format_args!("the parameter has no {what} {}; correct it, or the limits", text.value);
            findings.add(Code::EnumOutOfRange, text.span, message);
        }
    }
}

fn groups(model: &Model, findings: &mut Findings) {
    for group in &model.groups {
        let found = group.members.len();
        if let Some(count) = group.count.filter(|&count| usize::from(count) != found) {
            let message =
                format_args!("the group has {found} members, and {count} are announced; write {found}");
            findings.add(Code::MemberCount, group.spans.field(1), message);
        }
        let mut seen = HashSet::new();
        for (index, member) in group.members.iter().enumerate() {
            let span = group.spans.field(index.saturating_add(2));
            if !seen.insert(member) {
                findings.add(
                    Code::DuplicateMember,
                    span,
                    format_args!("the group has this member already; remove it"),
                );
            }
            if let GroupMember::Param(number) = *member
                && model.param(number).is_none()
            {
                let message = format_args!(
                    "there is no parameter {number} in [Params]; remove it, or add the parameter"
                );
                findings.add(Code::UnknownParameter, span, message);
            }
        }
    }
}

/// The whole numbers of a type; `None` if it has others.
const fn range(ty: DataType) -> Option<(i128, i128)> {
    Some(match ty {
        DataType::Bool => (0, 1),
        DataType::Sint => (-0x80, 0x7F),
        DataType::Int | DataType::Itime => (-0x8000, 0x7FFF),
        DataType::Dint | DataType::Ftime | DataType::Time => (-0x8000_0000, 0x7FFF_FFFF),
        DataType::Lint | DataType::Ltime => (-0x8000_0000_0000_0000, 0x7FFF_FFFF_FFFF_FFFF),
        DataType::Usint | DataType::Byte => (0, 0xFF),
        DataType::Uint | DataType::Word | DataType::Engunit => (0, 0xFFFF),
        DataType::Udint | DataType::Dword | DataType::Stime => (0, 0xFFFF_FFFF),
        DataType::Ulint | DataType::Lword => (0, 0xFFFF_FFFF_FFFF_FFFF),
        DataType::Real | DataType::Lreal => return None,
        DataType::Date | DataType::TimeOfDay | DataType::DateAndTime => return None,
        DataType::String | DataType::String2 | DataType::StringN | DataType::ShortString => return None,
        DataType::Epath | DataType::StringI => return None,
    })
}

const fn is_string(ty: DataType) -> bool {
    ty.size().is_none()
}

/// For comparing: limits of 64 bits lose digits that nobody writes.
fn number(constant: &Option<Constant>) -> Option<f64> {
    match constant {
        Some(Constant::Real(number)) => Some(*number),
        Some(Constant::Integer(number)) => std::format!("{number}").parse().ok(),
        Some(Constant::Text(_)) | None => None,
    }
}
