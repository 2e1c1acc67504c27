//! `devicenet eds show`.

use core::fmt::Display;
use std::io::{self, Write};

use cip_core::eds::{
    Assembly, Device, Eds, FileInfo, Group, GroupMember, IoData, IoInfo, Param, ParamClass, Reference,
    Severity, Stamp, Variant,
};
use cip_core::epath::Epath;
use cip_core::parameter::ParameterDescriptor;
use cip_core::scan::{IoType, ScanEntry};
use serde::Serialize;
use serde_json::{Value, json};

use super::{ShowArgs, name, read_sheet};
use crate::exit::{Exit, Failure};
use crate::output::{self, Output};
use crate::table::{Cell, Table};
use crate::text::{count, printable};

pub(super) fn run(args: &ShowArgs, json: bool) -> Result<Exit, Failure> {
    let eds = read_sheet(&args.file)?;
    let mut output = Output::new();
    match json {
        true => object(&eds, &name(&args.file), &mut output.buffer)?,
        false => text(&eds, &mut output.buffer)?,
    }
    output.flush()?;
    let of = |severity| eds.diagnostics().iter().filter(|found| found.severity() == severity).count() as u64;
    let (errors, warnings) = (of(Severity::Error), of(Severity::Warning));
    if errors + warnings > 0 {
        output::note(format_args!(
            "{}: {} and {}, which `devicenet eds check` tells",
            name(&args.file),
            count(errors, "error"),
            count(warnings, "warning")
        ));
    }
    Ok(Exit::Done)
}

/// The object of a file. It is written as it is: a [`Value`] has no room for every number that a file may have.
#[derive(Serialize)]
struct Sheet<'a> {
    file: &'a str,
    encoding: &'static str,
    description: &'a FileInfo,
    device: &'a Device,
    classes: &'a [String],
    io_info: Option<&'a IoInfo>,
    param_class: Option<&'a ParamClass>,
    params: &'a [Param],
    groups: &'a [Group],
    assemblies: Vec<Value>,
    variants: &'a [Variant],
    scan_entry: Option<ScanEntry>,
    scan_entry_problem: Option<String>,
}

fn object(eds: &Eds, file: &str, out: &mut impl Write) -> io::Result<()> {
    let scan_entry = eds.scan_entry();
    let sheet = Sheet {
        file,
        encoding: eds.document().encoding().name(),
        description: eds.file(),
        device: eds.device(),
        classes: eds.classes(),
        io_info: eds.io_info(),
        param_class: eds.param_class(),
        params: eds.params(),
        groups: eds.groups(),
        assemblies: eds.assemblies().iter().map(|assembly| assembly_object(eds, assembly)).collect(),
        variants: eds.variants(),
        scan_entry_problem: scan_entry.as_ref().err().map(ToString::to_string),
        scan_entry: scan_entry.ok(),
    };
    serde_json::to_writer(&mut *out, &sheet)?;
    writeln!(out)
}

fn assembly_object(eds: &Eds, assembly: &Assembly) -> Value {
    let mut object = json!(assembly);
    let layout = eds.layout(assembly).map(|slots| {
        let slot = |slot: &cip_core::eds::Slot<'_>| {
            json!({
                "name": slot.name,
                "first_bit": slot.first_bit,
                "bits": slot.bits,
                "param": slot.param.map(|param| param.number),
                "param_bit": slot.param_bit,
            })
        };
        slots.iter().map(slot).collect::<Vec<_>>()
    });
    object["layout"] = json!(layout);
    object
}

/// Everything that a file says, in tables.
///
/// # Errors
/// When `out` fails.
pub fn text(eds: &Eds, out: &mut impl Write) -> io::Result<()> {
    device(eds, out)?;
    if let Some(io) = eds.io_info() {
        connections(io, out)?;
        data("Inputs: what the device can produce", &io.inputs, out)?;
        data("Outputs: what the device can consume", &io.outputs, out)?;
    }
    params(eds.params(), out)?;
    groups(eds, out)?;
    for assembly in eds.assemblies() {
        layout(eds, assembly, out)?;
    }
    Ok(())
}

fn device(eds: &Eds, out: &mut impl Write) -> io::Result<()> {
    let (device, file) = (eds.device(), eds.file());
    let name = device.product_name.as_deref().unwrap_or("a device without a name");
    let catalog = device.catalog.as_deref().map(|catalog| format!(" ({catalog})"));
    writeln!(out, "{}", printable(&format!("{name}{}", catalog.unwrap_or_default())))?;
    let numbered = |number: Option<u16>, name: &Option<String>| {
        number.map(|number| format!("{number} {}", name.as_deref().unwrap_or_default()))
    };
    let stamp = |stamp: Stamp| stamp.date.map(|date| format!("{date} {}", or_nothing(stamp.time)));
    let lines = [
        ("vendor", numbered(device.vendor.map(|vendor| vendor.0), &device.vendor_name)),
        ("device type", numbered(device.device_type.map(|ty| ty.0), &device.device_type_name)),
        ("product code", device.product_code.map(|code| code.to_string())),
        ("revision", device.revision.map(|revision| revision.to_string())),
        ("file", file.description.clone()),
        ("file revision", file.revision.map(|(major, minor)| format!("{major}.{minor}"))),
        ("modified", stamp(file.modified).or(stamp(file.created))),
    ];
    for (what, value) in lines {
        let value = value.as_deref().unwrap_or("not given").trim_end();
        writeln!(out, "  {what:<14} {}", printable(value))?;
    }
    Ok(())
}

fn connections(io: &IoInfo, out: &mut impl Write) -> io::Result<()> {
    let mut table = Table::new(&["connection", "produces", "consumes", "together with", ""]);
    for connection in &io.connections {
        let carried = |number: Option<u16>, what: &str, find: &dyn Fn(u16) -> Option<u16>| match number {
            None => "nothing".to_owned(),
            Some(number) => match find(number) {
                Some(size) => format!("{what}{number}, {}", count(u64::from(size), "byte")),
                None => format!("{what}{number}, which is missing"),
            },
        };
        let others = connection.compatible.difference(connection.ty.mask());
        let is_default = io.default.contains(connection.ty.mask());
        table.row(vec![
            Cell::left(connection.ty.name()),
            Cell::left(carried(connection.input, "Input", &|number| Some(io.input(number)?.size))),
            Cell::left(carried(connection.output, "Output", &|number| Some(io.output(number)?.size))),
            Cell::left(others.to_string()),
            Cell::left(if is_default { "default" } else { "" }),
        ]);
    }
    section("I/O connections", &table, io.connections.is_empty(), out)
}

fn data(title: &str, list: &[IoData], out: &mut impl Write) -> io::Result<()> {
    let mut table = Table::new(&["no", "bytes", "name", "path", "connections"]);
    for data in list {
        let types: Vec<&str> =
            IoType::ALL.into_iter().filter(|ty| data.types.contains(ty.mask())).map(IoType::name).collect();
        table.row(vec![
            Cell::right(data.number.to_string()),
            Cell::right(data.size.to_string()),
            Cell::left(&data.name),
            Cell::left(path(&data.path)),
            Cell::left(types.join(", ")),
        ]);
    }
    section(title, &table, list.is_empty(), out)
}

fn params(params: &[Param], out: &mut impl Write) -> io::Result<()> {
    let mut table = Table::new(&["no", "name", "type", "access", "range", "default", "path"]);
    for param in params {
        let text = |constant: &Option<_>| constant.as_ref().map(|constant| param.text_of_constant(constant));
        let range = match (text(&param.minimum), text(&param.maximum)) {
            (None, None) => String::new(),
            (minimum, maximum) => format!("{} .. {}", or_nothing(minimum), or_nothing(maximum)),
        };
        let is_read_only = param.descriptor.contains(ParameterDescriptor::READ_ONLY);
        table.row(vec![
            Cell::right(param.number.to_string()),
            Cell::left(&param.name),
            Cell::left(param.data_type.map_or("unknown".to_owned(), |ty| ty.code().to_string())),
            Cell::left(if is_read_only { "get" } else { "get, set" }),
            Cell::left(range),
            Cell::left(or_nothing(text(&param.default))),
            Cell::left(path(&param.path)),
        ]);
    }
    section("Parameters", &table, params.is_empty(), out)
}

fn groups(eds: &Eds, out: &mut impl Write) -> io::Result<()> {
    let mut table = Table::new(&["no", "name", "parameters"]);
    for group in eds.groups() {
        let name = |member: &GroupMember| match member {
            GroupMember::Param(number) => match eds.param(*number) {
                Some(param) => format!("{number} {}", param.name),
                None => format!("{number} (missing)"),
            },
            GroupMember::Other(name) => name.clone(),
        };
        table.row(vec![
            Cell::right(group.number.to_string()),
            Cell::left(&group.name),
            Cell::left(group.members.iter().map(name).collect::<Vec<_>>().join(", ")),
        ]);
    }
    section("Groups", &table, eds.groups().is_empty(), out)
}

fn layout(eds: &Eds, assembly: &Assembly, out: &mut impl Write) -> io::Result<()> {
    let size = assembly.size.map_or("size not given".to_owned(), |size| count(u64::from(size), "byte"));
    let title = format!("Assembly {} {} ({size}; {})", assembly.number, assembly.name, path(&assembly.path));
    let mut table = Table::new(&["first bit", "bits", "member"]);
    let Some(slots) = eds.layout(assembly) else {
        let members = members(assembly);
        let (title, members) = (printable(&title), printable(&members));
        writeln!(out, "\n{title}\n  the size of a member is not known: {members}")?;
        return Ok(());
    };
    for slot in &slots {
        let parameter = slot.param.map(|param| format!(" (parameter {})", param.number));
        table.row(vec![
            Cell::right(format!("{}.{}", slot.first_bit / 8, slot.first_bit % 8)),
            Cell::right(slot.bits.to_string()),
            Cell::left(format!("{}{}", slot.name, parameter.unwrap_or_default())),
        ]);
    }
    section(&title, &table, slots.is_empty() && assembly.members.is_empty(), out)
}

fn members(assembly: &Assembly) -> String {
    let name = |reference: &Reference| match reference {
        Reference::Padding => "bits that fill up".to_owned(),
        Reference::Param { number, .. } => format!("Param{number}"),
        Reference::Assembly(number) => format!("Assem{number}"),
        Reference::Variant(number) => format!("Variant{number}"),
        Reference::BitVariant(number) => format!("BitStringVariant{number}"),
        Reference::Path(bytes) => path(bytes),
        Reference::Other(name) => name.clone(),
    };
    assembly.members.iter().map(|member| name(&member.reference)).collect::<Vec<_>>().join(", ")
}

fn section(title: &str, table: &Table, is_empty: bool, out: &mut impl Write) -> io::Result<()> {
    if is_empty {
        return Ok(());
    }
    writeln!(out, "\n{}", printable(title))?;
    for line in table.to_string().lines() {
        writeln!(out, "  {line}")?;
    }
    Ok(())
}

fn path(bytes: &[u8]) -> String {
    if bytes.is_empty() { "no path".to_owned() } else { Epath::packed(bytes).to_string() }
}

fn or_nothing(value: Option<impl Display>) -> String {
    value.map(|value| value.to_string()).unwrap_or_default()
}
