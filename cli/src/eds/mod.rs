//! `devicenet eds`: Electronic Data Sheets, checked and shown.

mod check;
mod show;

pub use check::Report;
pub use show::text;

use std::fs::File;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

use cip_core::eds::{Code, Eds, MAX_FILE, Section};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Subcommand};

use crate::exit::{Exit, Failure};
use crate::standard::{is_standard, shown};

/// `devicenet eds`.
#[derive(Args, Clone, Debug)]
pub struct EdsArgs {
    /// What to do with the files.
    #[command(subcommand)]
    pub command: EdsCommand,
}

/// What to do with Electronic Data Sheets.
#[derive(Subcommand, Clone, Debug)]
pub enum EdsCommand {
    /// Say what is wrong with files, where, and what to do
    Check(CheckArgs),
    /// Show what a file says of a device: identity, I/O, parameters, assemblies
    Show(ShowArgs),
}

/// `devicenet eds check`.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = "\
Errors are what a tool refuses or misunderstands, warnings what it can misunderstand, notes what is worth knowing. Each has a \
stable code in brackets, for --allow.

Exit codes:
  0  nothing is wrong; there may be notes
  1  some file has an error or a warning
  2  wrong usage, or a file that cannot be read

Examples:
  devicenet eds check valve.eds
  devicenet eds check --allow long_parameter_text,same_path *.eds
  devicenet eds check --json valve.eds | jq -r 'select(.severity == \"error\") | .code'")]
pub struct CheckArgs {
    /// The files; `-` is standard input
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Say nothing of findings with this code; several with commas, or given more than once
    #[arg(long, value_name = "CODE", value_parser = code_parser(), value_delimiter = ',', hide_possible_values = true)]
    pub allow: Vec<Code>,
}

/// `devicenet eds show`.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = "\
Exit codes:
  0  done; the file may have findings, which a note on standard error counts
  2  wrong usage, or a file that cannot be read, or that is no EDS

Examples:
  devicenet eds show valve.eds
  devicenet eds show --json valve.eds | jq '.params[] | [.number, .name]'")]
pub struct ShowArgs {
    /// The file; `-` is standard input
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
}

/// Runs the command.
///
/// # Errors
/// [`Failure`] when the command line is wrong or the output fails.
pub fn run(args: &EdsArgs, json: bool) -> Result<Exit, Failure> {
    match &args.command {
        EdsCommand::Check(args) => check::run(args, json),
        EdsCommand::Show(args) => show::run(args, json),
    }
}

/// Reads a file.
///
/// # Errors
/// [`Failure::Usage`] when it cannot be read, or is longer than any EDS.
pub fn read(path: &Path) -> Result<Eds, Failure> {
    let failed = |error: &dyn core::fmt::Display| Failure::Usage(format!("{}: {error}", name(path)));
    let mut bytes = Vec::new();
    // One byte more than is read shows that there are too many.
    let limit = MAX_FILE as u64 + 1;
    let done = match is_standard(path) {
        true => io::stdin().lock().take(limit).read_to_end(&mut bytes),
        false => File::open(path).and_then(|file| file.take(limit).read_to_end(&mut bytes)),
    };
    done.map_err(|error| failed(&error))?;
    if bytes.len() > MAX_FILE {
        return Err(failed(&format_args!("too long for an EDS, at most {MAX_FILE} bytes are read")));
    }
    Eds::parse(bytes).map_err(|error| failed(&error))
}

/// Reads a file that is an EDS, whatever is wrong in it.
///
/// # Errors
/// As [`read`], and when nothing in it is of an EDS.
pub fn read_sheet(path: &Path) -> Result<Eds, Failure> {
    let eds = read(path)?;
    let document = eds.document();
    if document.sections().iter().any(Section::is_known) {
        return Ok(eds);
    }
    let what =
        if document.bytes().is_empty() { "the file is empty" } else { "no section such as [Device] in it" };
    Err(Failure::Usage(format!("{}: {what}: it is no EDS", name(path))))
}

/// A file in messages.
fn name(path: &Path) -> String {
    shown(path, "<stdin>")
}

fn code_parser() -> impl TypedValueParser<Value = Code> {
    PossibleValuesParser::new(Code::ALL.iter().map(|code| code.name()))
        .try_map(|name| Code::ALL.iter().copied().find(|code| code.name() == name).ok_or("no such code"))
}
