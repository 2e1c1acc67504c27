//! `devicenet eds check`.

use std::io::{self, Write};

use anstyle::{AnsiColor, Style};
use cip_core::eds::{Code, Diagnostic, Eds, Severity, Span};
use serde_json::json;

use super::{CheckArgs, name, read};
use crate::excerpt::Excerpt;
use crate::exit::{Exit, Failure};
use crate::output::{self, Output};
use crate::standard::at_most_one;
use crate::text::{count, printable};

pub(super) fn run(args: &CheckArgs, json: bool) -> Result<Exit, Failure> {
    at_most_one(args.files.iter().map(|file| &**file))?;
    let mut output = Output::new();
    let mut exit = Exit::Done;
    for path in &args.files {
        let eds = match read(path) {
            Ok(eds) => eds,
            // The other files are still looked at.
            Err(failure) => {
                output.flush()?;
                output::error(failure);
                exit = Exit::Usage;
                continue;
            }
        };
        let report = Report::new(name(path), &eds, &args.allow);
        if report.findings().any(|found| found.severity() > Severity::Note) && exit == Exit::Done {
            exit = Exit::Findings;
        }
        match json {
            true => report.json(&mut output.buffer)?,
            false => {
                let is_coloured = output.is_coloured();
                report.text(&mut output.buffer, is_coloured)?;
            }
        }
        output.line_done()?;
    }
    output.flush()?;
    Ok(exit)
}

/// What is to be said of a file.
pub struct Report<'a> {
    file: String,
    eds: &'a Eds,
    allowed: &'a [Code],
}

impl<'a> Report<'a> {
    /// Of a file with this name, without the findings that are allowed.
    #[must_use]
    pub fn new(file: impl Into<String>, eds: &'a Eds, allowed: &'a [Code]) -> Self {
        Self { file: file.into(), eds, allowed }
    }

    fn findings(&self) -> impl Iterator<Item = &Diagnostic> {
        self.eds.diagnostics().iter().filter(|found| !self.allowed.contains(&found.code))
    }

    fn counts(&self) -> [u64; 3] {
        let of = |severity| self.findings().filter(|found| found.severity() == severity).count() as u64;
        [of(Severity::Error), of(Severity::Warning), of(Severity::Note)]
    }

    /// Each finding with its line, then how many there are.
    ///
    /// # Errors
    /// When `out` fails.
    pub fn text(&self, out: &mut impl Write, is_coloured: bool) -> io::Result<()> {
        let file = &self.file;
        for found in self.findings() {
            let style = if is_coloured { style(found.severity()) } else { Style::new() };
            let bold = if is_coloured { Style::new().bold() } else { Style::new() };
            let Diagnostic { place, message, code, .. } = found;
            writeln!(
                out,
                "{bold}{file}:{}:{}:{bold:#} {style}{}[{code}]{style:#}: {}\n{}",
                place.line,
                place.column,
                found.severity(),
                printable(message),
                self.excerpt(found, style)
            )?;
        }
        let [errors, warnings, notes] = self.counts();
        let counted = [(errors, "error"), (warnings, "warning"), (notes, "note")];
        let counted: Vec<String> =
            counted.iter().filter(|(n, _)| *n > 0).map(|(n, what)| count(*n, what)).collect();
        let summary = if counted.is_empty() { "nothing is wrong".to_owned() } else { counted.join(", ") };
        writeln!(out, "{file}: {summary}{}", self.left_out())?;
        Ok(())
    }

    /// The line and the marks; nothing of a line that is too long to look at.
    fn excerpt(&self, found: &Diagnostic, style: Style) -> String {
        let document = self.eds.document();
        let line = document.line(found.place.line);
        if line.end - line.start > LONGEST_LINE {
            return String::new();
        }
        let text = document.text(line);
        let end = found.span.end.min(line.end).max(found.span.start);
        let marked = document.text(Span { start: found.span.start, end });
        let excerpt = Excerpt {
            line: found.place.line,
            text: text.trim_end(),
            column: found.place.column,
            width: marked.trim_end().chars().count().max(1),
        };
        let shown = excerpt.to_string();
        match shown.rsplit_once("| ") {
            Some((lines, marks)) => format!("{lines}| {style}{marks}{style:#}\n"),
            None => shown,
        }
    }

    fn left_out(&self) -> String {
        match self.eds.diagnostics_left_out() {
            0 => String::new(),
            left_out => format!(", and {} that are not shown", count(left_out as u64, "finding")),
        }
    }

    fn json(&self, out: &mut impl Write) -> io::Result<()> {
        let file = &self.file;
        for found in self.findings() {
            let object = json!({
                "kind": "finding",
                "file": file,
                "line": found.place.line,
                "column": found.place.column,
                "severity": found.severity().name(),
                "code": found.code.name(),
                "message": found.message,
                "text": format!("{file}:{found}"),
            });
            writeln!(out, "{object}")?;
        }
        let [errors, warnings, notes] = self.counts();
        let object = json!({
            "kind": "file",
            "file": file,
            "errors": errors,
            "warnings": warnings,
            "notes": notes,
            "left_out": self.eds.diagnostics_left_out(),
        });
        writeln!(out, "{object}")?;
        Ok(())
    }
}

fn style(severity: Severity) -> Style {
    let colour = match severity {
        Severity::Error => AnsiColor::Red,
        Severity::Warning => AnsiColor::Yellow,
        Severity::Note => AnsiColor::Cyan,
    };
    colour.on_default().bold()
}

/// Of an excerpt, in bytes.
const LONGEST_LINE: usize = 64 * 1024;
