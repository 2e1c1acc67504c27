//! What is wrong with a file, where, and what to do.

use core::fmt;
use std::string::String;
use std::vec::Vec;

use super::{Place, Span};

/// How much a finding matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "lowercase"))]
pub enum Severity {
    /// Worth knowing. The file may well be right.
    Note,
    /// A tool can misunderstand the file.
    Warning,
    /// The file is wrong: a tool refuses it, or works with wrong data.
    Error,
}

impl Severity {
    /// `note`, `warning`, `error`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A finding in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Diagnostic {
    /// What kind of finding it is.
    pub code: Code,
    /// Which bytes are meant.
    pub span: Span,
    /// Where they begin.
    pub place: Place,
    /// What was found, and what to do.
    pub message: String,
}

impl Diagnostic {
    /// How much it matters.
    #[must_use]
    pub const fn severity(&self) -> Severity {
        self.code.severity()
    }
}

/// `12:7: error: no such parameter [unknown_parameter]`
impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { code, place, message, .. } = self;
        write!(f, "{}:{}: {}: {message} [{code}]", place.line, place.column, code.severity())
    }
}

macro_rules! codes {
    ($($(#[$meta:meta])* $Code:ident = $name:literal, $Severity:ident;)*) => {
        /// The kind of a finding: stable names, for scripts and for lists of what is tolerated.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Code {
            $($(#[$meta])* #[doc = concat!("\n\n`", $name, "`, ", stringify!($Severity), ".")] $Code,)*
        }

        impl Code {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$Code),*];

            /// The name.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$Code => $name,)* }
            }

            /// How much it matters.
            #[must_use]
            pub const fn severity(self) -> Severity {
                match self { $(Self::$Code => Severity::$Severity,)* }
            }
        }
    };
}

codes! {
    // The characters.
    /// The file is UTF-16, which tools for EDS files do not read.
    EncodingUtf16 = "encoding_utf16", Error;
    /// The file has characters in UTF-8, where ISO 8859-1 is expected.
    EncodingUtf8 = "encoding_utf8", Warning;
    /// The file begins with a byte order mark, which belongs to its first word for many tools.
    ByteOrderMark = "byte_order_mark", Warning;
    /// The file has characters that Windows-1252 has and ISO 8859-1 has not.
    EncodingWindows1252 = "encoding_windows_1252", Warning;
    /// The file has bytes that are no character in its encoding.
    BrokenCharacter = "broken_character", Error;
    /// The file has control characters other than tab, form feed and line ends.
    ControlCharacter = "control_character", Warning;
    /// Lines end in different ways.
    MixedLineEnds = "mixed_line_ends", Note;

    // The words.
    /// A string goes on to the end of the line.
    UnterminatedString = "unterminated_string", Error;
    /// A string ends that has not begun.
    UnopenedString = "unopened_string", Error;
    /// A string whose last quote is escaped.
    EscapedQuote = "escaped_quote", Warning;
    /// A string stands between typographic quotes.
    TypographicQuotes = "typographic_quotes", Error;
    /// `[` without `]`.
    UnterminatedSection = "unterminated_section", Error;
    /// An entry goes on into the next one, the next section, or the end of the file.
    MissingSemicolon = "missing_semicolon", Error;
    /// Two values stand side by side.
    MissingComma = "missing_comma", Error;
    /// Something stands where an entry or a section should begin.
    StrayText = "stray_text", Error;
    /// A semicolon that ends nothing.
    StraySemicolon = "stray_semicolon", Warning;
    /// An entry before the first section.
    EntryOutsideSection = "entry_outside_section", Error;

    // The structure.
    /// A section that every file needs is missing.
    MissingSection = "missing_section", Error;
    /// A section is there twice.
    DuplicateSection = "duplicate_section", Error;
    /// `[File]` does not come first.
    SectionOrder = "section_order", Warning;
    /// A section has no entries.
    EmptySection = "empty_section", Note;
    /// Nothing is known of the section.
    UnknownSection = "unknown_section", Note;
    /// Nothing is known of the section, and it is named nearly as one of which much is.
    MisspeltSection = "misspelt_section", Warning;
    /// An entry is there twice.
    DuplicateKeyword = "duplicate_keyword", Error;
    /// An entry that its section needs is missing.
    MissingKeyword = "missing_keyword", Error;
    /// Nothing is known of the keyword in its section.
    UnknownKeyword = "unknown_keyword", Warning;
    /// The number of a keyword is missing, zero, too large, or has leading zeros.
    KeywordNumber = "keyword_number", Warning;
    /// The numbers of keywords leave one out.
    NumberGap = "number_gap", Note;

    // The fields.
    /// A field that is needed is empty or missing.
    MissingField = "missing_field", Error;
    /// An entry has more fields than are defined.
    TooManyFields = "too_many_fields", Warning;
    /// A number is expected.
    NotANumber = "not_a_number", Error;
    /// A string in quotes is expected.
    NotAString = "not_a_string", Error;
    /// The number does not fit into its type.
    NumberRange = "number_range", Error;
    /// A date is expected, `mm-dd-yyyy`.
    BadDate = "bad_date", Error;
    /// A time is expected, `hh:mm:ss`.
    BadTime = "bad_time", Error;
    /// A revision is expected, `major.minor`.
    BadRevision = "bad_revision", Error;
    /// The string is longer than a device can tell it.
    StringTooLong = "string_too_long", Warning;
    /// A reserved field or a reserved bit is set.
    Reserved = "reserved", Warning;
    /// A path is not a row of bytes in hexadecimal.
    BadPath = "bad_path", Error;
    /// The number of bytes of a path is not what is said.
    PathSize = "path_size", Error;
    /// The bytes are no path.
    PathSegments = "path_segments", Error;
    /// The path leads to no attribute.
    PathIncomplete = "path_incomplete", Warning;

    // [File], [Device] and [Device Classification].
    /// The file was changed before it was created.
    ModifiedBeforeCreated = "modified_before_created", Warning;
    /// A number of the identity cannot be one of a device.
    Identity = "identity", Error;
    /// The device is not classified as a DeviceNet device.
    NotDeviceNet = "not_devicenet", Warning;

    // [IO_Info]
    /// The default is a connection that the file does not describe.
    DefaultConnection = "default_connection", Error;
    /// There is no default connection.
    NoDefaultConnection = "no_default_connection", Warning;
    /// Two connections cannot be used at the same time, and one of them says that they can.
    Incompatible = "incompatible", Warning;
    /// There is no such input or output.
    UnknownIo = "unknown_io", Error;
    /// An input or output does not allow the connection that uses it.
    IoType = "io_type", Warning;
    /// A bit-strobe connection cannot carry it.
    StrobeSize = "strobe_size", Warning;
    /// More significant bits than bytes.
    SignificantBits = "significant_bits", Error;
    /// No data.
    ZeroSize = "zero_size", Warning;
    /// Two descriptions of the same data differ in their size.
    SizesDiffer = "sizes_differ", Error;

    // [ParamClass], [Params], [EnumPar] and [Groups]
    /// The number of parameters is not that of `[ParamClass]`.
    ParameterCount = "parameter_count", Error;
    /// There is no such data type.
    UnknownDataType = "unknown_data_type", Error;
    /// A data type of the first edition.
    OldDataType = "old_data_type", Note;
    /// The size is not that of the data type.
    DataSize = "data_size", Error;
    /// Minimum, maximum or default is no value of the data type.
    ValueRange = "value_range", Error;
    /// The minimum is above the maximum.
    MinimumAboveMaximum = "minimum_above_maximum", Error;
    /// The default is not between minimum and maximum.
    DefaultOutOfRange = "default_out_of_range", Error;
    /// The text is longer than a Parameter object can tell it.
    LongParameterText = "long_parameter_text", Note;
    /// The path leads to another instance of the Parameter object.
    ParameterInstance = "parameter_instance", Warning;
    /// The object that the path leads to has another data type there, or cannot be written.
    ObjectMismatch = "object_mismatch", Warning;
    /// Two parameters have the same path.
    SamePath = "same_path", Note;
    /// Scaling is announced and not given, or it cannot be computed.
    Scaling = "scaling", Error;
    /// Scaling is given and not announced.
    ScalingUnused = "scaling_unused", Note;
    /// A parameter that scaling is taken from is not named.
    ScalingLink = "scaling_link", Warning;
    /// There is no such parameter.
    UnknownParameter = "unknown_parameter", Error;
    /// Enumerated texts are announced and not given, or the other way round.
    EnumAnnounced = "enum_announced", Warning;
    /// Values and texts do not come in pairs.
    EnumPairs = "enum_pairs", Error;
    /// A value has two texts.
    EnumDuplicate = "enum_duplicate", Warning;
    /// A text is for a value that the parameter cannot have.
    EnumOutOfRange = "enum_out_of_range", Warning;
    /// The number of members is not what is said.
    MemberCount = "member_count", Error;
    /// A member is there twice.
    DuplicateMember = "duplicate_member", Warning;

    // [Assembly]
    /// There is no such assembly or variant.
    UnknownAssembly = "unknown_assembly", Error;
    /// Member sizes and references do not come in pairs.
    MemberPairs = "member_pairs", Error;
    /// The members do not make the size of the assembly.
    AssemblySize = "assembly_size", Error;
    /// A member is larger than what it refers to.
    MemberSize = "member_size", Error;
    /// An assembly has itself as a member.
    AssemblyCycle = "assembly_cycle", Error;
    /// A member reference is neither a parameter, nor an assembly, nor a path.
    MemberReference = "member_reference", Error;
    /// A connection carries data that `[Assembly]` does not describe.
    AssemblyNotDescribed = "assembly_not_described", Note;
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for Code {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// Collects findings, up to [`MAX_DIAGNOSTICS`]; the others are counted.
#[derive(Debug, Default)]
pub(super) struct Findings {
    found: Vec<(Span, Code, String)>,
    left_out: usize,
}

impl Findings {
    pub(super) fn add(&mut self, code: Code, span: Span, message: fmt::Arguments<'_>) {
        if self.is_full() {
            self.left_out = self.left_out.saturating_add(1);
        } else {
            let mut short = Short(String::new());
            // It fails when it has enough.
            let _ = fmt::write(&mut short, message);
            self.found.push((span, code, short.0));
        }
    }

    /// Whether further ones are only counted.
    pub(super) const fn is_full(&self) -> bool {
        self.found.len() >= MAX_DIAGNOSTICS
    }

    /// The findings in the order of their places, and how many there was no room for. `places` tells ascending places.
    pub(super) fn finish(
        mut self,
        places: impl FnOnce(&mut dyn Iterator<Item = usize>) -> Vec<Place>,
    ) -> (Vec<Diagnostic>, usize) {
        self.found.sort_by_key(|&(span, code, _)| (span.start, code));
        let places = places(&mut self.found.iter().map(|(span, ..)| span.start));
        let diagnostics = self.found.into_iter().zip(places);
        let diagnostics =
            diagnostics.map(|((span, code, message), place)| Diagnostic { code, span, place, message });
        (diagnostics.collect(), self.left_out)
    }
}

/// The beginning of a message. What a file says in it can be as long as the file.
struct Short(String);

impl fmt::Write for Short {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let room = LONGEST_MESSAGE.saturating_sub(self.0.len());
        if text.len() <= room {
            self.0.push_str(text);
            return Ok(());
        }
        self.0.extend(text.char_indices().take_while(|&(at, _)| at < room).map(|(_, character)| character));
        self.0.push('…');
        Err(fmt::Error)
    }
}

/// In bytes.
const LONGEST_MESSAGE: usize = 500;
/// The most findings that are kept. A file with more of them is no EDS.
pub const MAX_DIAGNOSTICS: usize = 1000;

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn names_are_distinct() {
        let names: HashSet<_> = Code::ALL.iter().map(|code| code.name()).collect();
        assert_eq!(names.len(), Code::ALL.len());
        assert!(
            names
                .iter()
                .all(|name| name.chars().all(|c| c.is_ascii_lowercase() || "_0123456789".contains(c)))
        );
    }

    #[test]
    fn findings_are_bounded() {
        let mut findings = Findings::default();
        for at in (0..=MAX_DIAGNOSTICS).rev() {
            findings.add(Code::StrayText, Span::at(at), format_args!("x"));
        }
        let place = Place { line: 1, column: 1 };
        let (diagnostics, left_out) = findings.finish(|places| places.map(|_| place).collect());
        assert_eq!((diagnostics.len(), left_out), (MAX_DIAGNOSTICS, 1));
        assert!(diagnostics.is_sorted_by_key(|diagnostic| diagnostic.span.start));
    }
}
