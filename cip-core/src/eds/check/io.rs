//! `[IO_Info]`: the connections, what they carry, and whether they go together.

use std::collections::HashMap;

use super::super::diagnostic::{Code, Findings};
use super::super::fields::Count;
use super::super::layout::Sizes;
use super::super::model::{Assembly, IoConnection, IoData, IoInfo, Model};
use crate::code::{ClassId, InstanceId};
use crate::epath::LogicalPath;
use crate::scan::{IoType, IoTypes};

pub(super) fn check(model: &Model, findings: &mut Findings) {
    let Some(io) = &model.io else { return };
    default(io, findings);
    for connection in &io.connections {
        compatible(io, connection, findings);
        carried(io, connection, findings);
    }
    for (list, what) in [(&io.inputs, "Input"), (&io.outputs, "Output")] {
        list.iter().for_each(|data| size(data, what, findings));
        same_data(list, what, findings);
    }
    described(model, io, findings);
}

fn default(io: &IoInfo, findings: &mut Findings) {
    let span = io.default_spans.field(0);
    if io.default.is_empty() {
        if !io.connections.is_empty() {
            let message = format_args!(
                "no connection is the default; a master must be told which to use, write 0x0001 for poll"
            );
            findings.add(Code::NoDefaultConnection, span, message);
        }
        return;
    }
    for ty in IoType::ALL.into_iter().filter(|ty| io.default.contains(ty.mask())) {
        let Some(connection) = io.connection(ty) else {
            let message = format_args!(
                "the default has {ty} (0x{:04X}), and `{}` is missing; add it, or clear the bit",
                ty.mask().bits(),
                super::super::model::io_keyword(ty)
            );
            findings.add(Code::DefaultConnection, span, message);
            continue;
        };
        let others = io.default.difference(ty.mask());
        let refused = others.difference(connection.compatible);
        if !refused.is_empty() {
            let message = format_args!(
                "the default uses {ty} together with {refused}, which {ty} is not compatible with"
            );
            findings.add(Code::Incompatible, span, message);
        }
    }
}

/// Whether two connections say the same of each other.
fn compatible(io: &IoInfo, connection: &IoConnection, findings: &mut Findings) {
    let (ty, span) = (connection.ty, connection.spans.field(0));
    for other in io.connections.iter().filter(|other| other.ty != ty) {
        if connection.compatible.contains(other.ty.mask()) && !other.compatible.contains(ty.mask()) {
            let message = format_args!(
                "{ty} is compatible with {}, and {} is not compatible with {ty}; let both masks agree",
                other.ty, other.ty
            );
            findings.add(Code::Incompatible, span, message);
        }
    }
    let exclusive = match ty {
        IoType::ChangeOfState => IoTypes::CYCLIC,
        IoType::Cyclic => IoTypes::CHANGE_OF_STATE,
        IoType::Poll | IoType::BitStrobe | IoType::MulticastPoll => IoTypes::empty(),
    };
    if connection.compatible.intersects(exclusive) {
        let message = format_args!(
            "change of state and cyclic are one connection and exclude each other; clear {exclusive} (0x{:04X})",
            exclusive.bits()
        );
        findings.add(Code::Incompatible, span, message);
    }
}

/// The data that a connection carries if nobody chooses.
fn carried(io: &IoInfo, connection: &IoConnection, findings: &mut Findings) {
    let ty = connection.ty;
    let carried = [
        (connection.input, connection.input.map(|number| io.input(number)), 1, "Input"),
        (connection.output, connection.output.map(|number| io.output(number)), 2, "Output"),
    ];
    for (number, data, field, what) in carried {
        let (Some(number), Some(data)) = (number, data) else { continue };
        let span = connection.spans.field(field);
        let Some(data) = data else {
            let message = format_args!("`{what}{number}` does not exist; add it, or write 0 for none");
            findings.add(Code::UnknownIo, span, message);
            continue;
        };
        if !data.types.contains(ty.mask()) {
            let message = format_args!(
                "`{what}{number}` does not allow {ty}; set 0x{:04X} in its mask, or carry another",
                ty.mask().bits()
            );
            findings.add(Code::IoType, span, message);
        }
        if ty == IoType::BitStrobe && what == "Output" && (data.size > 1 || data.significant_bits > 1) {
            let message =
                format_args!("a bit-strobe command has one bit for each device; `{what}{number}` is larger");
            findings.add(Code::StrobeSize, span, message);
        }
    }
}

fn size(data: &IoData, what: &str, findings: &mut Findings) {
    let (number, size) = (data.number, data.size);
    if size == 0 {
        let message = format_args!("`{what}{number}` has no data; remove it, or write its size");
        findings.add(Code::ZeroSize, data.spans.field(0), message);
    }
    if u32::from(data.significant_bits) > u32::from(size).saturating_mul(8) {
        let message = format_args!(
            "{} significant bits do not fit into {}; write 0 for all",
            data.significant_bits,
            Count(size, "byte")
        );
        findings.add(Code::SignificantBits, data.spans.field(1), message);
    }
    if what == "Input" && data.types.contains(IoTypes::BIT_STROBE) && size > STROBE_MAX {
        let message = format_args!(
            "a bit-strobe response has at most {STROBE_MAX} bytes, and this has {size}; clear 0x0002"
        );
        findings.add(Code::StrobeSize, data.spans.field(2), message);
    }
}

/// One path with two sizes.
fn same_data(list: &[IoData], what: &str, findings: &mut Findings) {
    let mut seen: HashMap<&[u8], &IoData> = HashMap::new();
    for data in list.iter().filter(|data| !data.path.is_empty()) {
        let first = *seen.entry(&data.path).or_insert(data);
        if first.size != data.size {
            let message = format_args!(
                "`{what}{}` has {} at the same path, and this has {}",
                first.number,
                Count(first.size, "byte"),
                data.size
            );
            findings.add(Code::SizesDiffer, data.spans.field(0), message);
        }
    }
}

/// Whether `[Assembly]` says the same of the data.
fn described(model: &Model, io: &IoInfo, findings: &mut Findings) {
    if model.assemblies.is_empty() {
        return;
    }
    let mut by_path: HashMap<(Option<ClassId>, Option<InstanceId>), &Assembly> = HashMap::new();
    for assembly in &model.assemblies {
        if let Some(LogicalPath { class, instance, .. }) = assembly.target() {
            by_path.entry((class, instance)).or_insert(assembly);
        }
    }
    let mut sizes = Sizes::new(model);
    let lists = [(&io.inputs, "Input"), (&io.outputs, "Output")];
    for (data, what) in lists.into_iter().flat_map(|(list, what)| list.iter().map(move |data| (data, what))) {
        let Some(target) = data.epath().logical().ok().filter(|path| path.class == Some(ClassId::ASSEMBLY))
        else {
            continue;
        };
        let by_number = || {
            let assembly = model.assembly(target.instance?.0)?;
            assembly.path.is_empty().then_some(assembly)
        };
        let found = by_path.get(&(target.class, target.instance)).copied().or_else(by_number);
        let Some(assembly) = found else {
            let message = format_args!("[Assembly] does not describe what `{what}{}` carries", data.number);
            findings.add(Code::AssemblyNotDescribed, data.spans.field(5), message);
            continue;
        };
        let bits = match assembly.size {
            Some(size) => Some(u32::from(size).saturating_mul(8)),
            None => sizes.sum(assembly, 0),
        };
        let Some(bits) = bits.filter(|&bits| bits.div_ceil(8) != u32::from(data.size)) else { continue };
        let message = format_args!(
            "`{what}{}` has {}, and `Assem{}` at its path has {}; correct one of them",
            data.number,
            Count(data.size, "byte"),
            assembly.number,
            bits.div_ceil(8)
        );
        findings.add(Code::SizesDiffer, data.spans.field(0), message);
    }
}

/// A frame.
const STROBE_MAX: u16 = 8;
