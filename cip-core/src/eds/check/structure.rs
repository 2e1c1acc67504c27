//! Sections and keywords: those that must be there, those that are there twice, those that nobody knows.

use std::collections::hash_map;
use std::collections::{BTreeMap, HashMap};
use std::string::String;
use std::vec::Vec;

use super::super::diagnostic::{Code, Findings};
use super::super::document::{Document, Entry, Section};
use super::super::span::Span;

pub(super) fn check(document: &Document, findings: &mut Findings) {
    required(document, findings);
    let mut seen = HashMap::new();
    for section in document.sections() {
        // An empty name is that of what stands before the first section.
        if section.name.is_empty() {
            continue;
        }
        match seen.entry(section.name.to_ascii_lowercase()) {
            hash_map::Entry::Occupied(first) => {
                let message = format_args!(
                    "section [{}] is on line {} already; put its entries there",
                    section.name,
                    first.get()
                );
                findings.add(Code::DuplicateSection, section.span, message);
            }
            hash_map::Entry::Vacant(place) => {
                place.insert(document.line_of(section.span.start));
            }
        }
        if section.entries.is_empty() {
            let message = format_args!("section [{}] has no entries; remove it, or fill it", section.name);
            findings.add(Code::EmptySection, section.span, message);
        }
        if known(&section.name).is_none() && !is_foreign_section(&section.name) {
            unknown_section(section, findings);
        }
    }
    keywords(document, findings);
}

fn required(document: &Document, findings: &mut Findings) {
    for name in ["File", "Device"] {
        if document.section(name).is_none() {
            let message = format_args!("section [{name}] is missing; every EDS has it");
            findings.add(Code::MissingSection, Span::at(0), message);
        }
    }
    let mut named = document.sections().iter().filter(|section| !section.name.is_empty());
    if let Some(first) = named.next().filter(|first| !first.is("File"))
        && document.section("File").is_some()
    {
        let message = format_args!("[{}] comes before [File]; let [File] be the first section", first.name);
        findings.add(Code::SectionOrder, first.span, message);
    }
}

fn keywords(document: &Document, findings: &mut Findings) {
    let mut names: HashMap<String, usize> = HashMap::new();
    let mut seen: HashMap<(usize, String), usize> = HashMap::new();
    let mut numbers: BTreeMap<(&str, String), Vec<(u32, Span)>> = BTreeMap::new();
    for section in document.sections() {
        // A number in its place: its name can be as long as the file, and so can be the list of its entries.
        let count = names.len();
        let name = *names.entry(section.name.to_ascii_lowercase()).or_insert(count);
        let known = known(&section.name);
        for entry in &section.entries {
            let key = (name, entry.keyword.to_ascii_lowercase());
            let line = document.line_of(entry.keyword_span.start);
            match seen.get(&key) {
                Some(first) => {
                    let message = format_args!(
                        "`{}` is on line {first} already, which counts; remove one of them",
                        entry.keyword
                    );
                    findings.add(Code::DuplicateKeyword, entry.keyword_span, message);
                }
                None => {
                    seen.insert(key, line);
                }
            }
            let Some(known) = known else { continue };
            match known.kind_of(entry) {
                Kind::Foreign => {}
                Kind::Unknown => unknown_keyword(section, entry, known, findings),
                Kind::Plain => {}
                Kind::Numbered => {
                    number(entry, findings);
                    if let Ok(number) = entry.digits().parse() {
                        let stem = entry.stem().to_ascii_lowercase();
                        numbers.entry((known.name, stem)).or_default().push((number, entry.keyword_span));
                    }
                }
            }
        }
    }
    // Parameters and assemblies may be numbered freely, what a master chooses from must be counted.
    for ((section, _), mut list) in numbers {
        if matches!(section, "IO_Info" | "Groups") {
            gaps(&mut list, findings);
        }
    }
}

fn number(entry: &Entry, findings: &mut Findings) {
    let digits = entry.digits();
    let message = match digits.parse::<u16>() {
        Ok(0) => "count from 1",
        Ok(_) if digits.starts_with('0') => "leave the zeros out",
        Ok(_) => return,
        Err(_) if digits.is_empty() => "add a number, from 1",
        Err(_) => "use a number of at most 65535",
    };
    findings.add(Code::KeywordNumber, entry.keyword_span, format_args!("`{}`: {message}", entry.keyword));
}

fn gaps(list: &mut [(u32, Span)], findings: &mut Findings) {
    list.sort_unstable();
    let mut expected: u32 = 1;
    for &(number, span) in list.iter() {
        if number > expected {
            let message = format_args!(
                "number {number} follows {}; number {expected} is missing",
                expected.saturating_sub(1)
            );
            findings.add(Code::NumberGap, span, message);
        }
        expected = number.saturating_add(1);
    }
}

fn unknown_section(section: &Section, findings: &mut Findings) {
    let names = KNOWN.iter().map(|known| known.name);
    match similar(&section.name, names) {
        Some(name) => {
            let message = format_args!("nothing is known of section [{}]; is it [{name}]?", section.name);
            findings.add(Code::MisspeltSection, section.span, message);
        }
        None => {
            let message = format_args!(
                "nothing is known of section [{}]; a section of a vendor begins with its number, like [4660_Name]",
                section.name
            );
            findings.add(Code::UnknownSection, section.span, message);
        }
    }
}

fn unknown_keyword(section: &Section, entry: &Entry, known: &Known, findings: &mut Findings) {
    let stem = entry.stem();
    let candidates = known.plain.iter().chain(known.numbered).copied();
    let suggestion = similar(stem, candidates).map(|keyword| {
        let number = if known.numbered.contains(&keyword) { entry.digits() } else { "" };
        std::format!("is it `{keyword}{number}`?")
    });
    let hint =
        suggestion.as_deref().unwrap_or("a keyword of a vendor begins with its number, like `4660_Name`");
    let message = format_args!("`{}` is no keyword of [{}]; {hint}", entry.keyword, section.name);
    findings.add(Code::UnknownKeyword, entry.keyword_span, message);
}

/// The name that is most like the one written, if one is.
fn similar<'a>(written: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let lower: String = written.chars().take(LONGEST_NAME).collect::<String>().to_ascii_lowercase();
    let score = |name: &str| strsim::jaro_winkler(&lower, &name.to_ascii_lowercase());
    let scored = names.map(|name| (score(name), name)).filter(|&(score, _)| score >= SIMILAR);
    scored.max_by(|one, other| one.0.total_cmp(&other.0)).map(|(_, name)| name)
}

/// A section that is not judged: of a vendor, or of an object or network that DeviceNet does not need.
fn is_foreign_section(name: &str) -> bool {
    let lower = name.to_ascii_lowercase();
    is_of_vendor(name)
        || lower.ends_with(" class")
        || FOREIGN.iter().any(|prefix| lower.starts_with(&prefix.to_ascii_lowercase()))
}

/// Whether a name begins with the number of a vendor.
fn is_of_vendor(name: &str) -> bool {
    name.split_once('_').is_some_and(|(vendor, _)| {
        !vendor.is_empty() && vendor.chars().all(|character| character.is_ascii_digit())
    })
}

/// The keywords of a section.
struct Known {
    name: &'static str,
    plain: &'static [&'static str],
    /// Those with a number behind them.
    numbered: &'static [&'static str],
}

enum Kind {
    Plain,
    Numbered,
    Foreign,
    Unknown,
}

impl Known {
    fn kind_of(&self, entry: &Entry) -> Kind {
        let is = |keyword: &&&str, written: &str| keyword.eq_ignore_ascii_case(written);
        if is_of_vendor(&entry.keyword) {
            Kind::Foreign
        } else if self.plain.iter().any(|keyword| is(&keyword, &entry.keyword)) {
            Kind::Plain
        } else if self.numbered.iter().any(|keyword| is(&keyword, entry.stem())) {
            Kind::Numbered
        } else {
            Kind::Unknown
        }
    }
}

/// Whether the entries of a section of this name are read.
pub(in crate::eds) fn is_known(name: &str) -> bool {
    known(name).is_some()
}

fn known(name: &str) -> Option<&'static Known> {
    KNOWN.iter().find(|known| known.name.eq_ignore_ascii_case(name))
}

static KNOWN: [Known; 9] = [
    Known {
        name: "File",
        plain: &[
            "DescText",
            "CreateDate",
            "CreateTime",
            "ModDate",
            "ModTime",
            "Revision",
            "HomeURL",
            "License",
            "Exclude",
            "EDSFileCRC",
        ],
        numbered: &[],
    },
    Known {
        name: "Device",
        plain: &[
            "VendCode",
            "VendName",
            "ProdType",
            "ProdTypeStr",
            "ProdCode",
            "MajRev",
            "MinRev",
            "ProdName",
            "Catalog",
            "Icon",
            "IconContents",
            "DeviceStatusAssembly",
        ],
        numbered: &["DeviceStatusAssembly"],
    },
    Known { name: "Device Classification", plain: &[], numbered: &["Class"] },
    Known {
        name: "IO_Info",
        plain: &["Default", "PollInfo", "StrobeInfo", "COSInfo", "CyclicInfo", "MPollInfo"],
        numbered: &["Input", "Output"],
    },
    Known {
        name: "ParamClass",
        plain: &["MaxInst", "Descriptor", "CfgAssembly", "CfgAssemblyExa"],
        numbered: &[],
    },
    Known {
        name: "Params",
        plain: &[],
        numbered: &[
            "Param",
            "Enum",
            "Variant",
            "ProxyParam",
            "ProxyEnum",
            "ProxiedParam",
            "ProxiedEnum",
            "ProxyParamSizeAdder",
        ],
    },
    Known { name: "EnumPar", plain: &[], numbered: &["Param"] },
    Known { name: "Groups", plain: &[], numbered: &["Group"] },
    Known {
        name: "Assembly",
        plain: &[
            "Revision",
            "ObjectName",
            "Object_Name",
            "ObjectClassCode",
            "Object_Class_Code",
            "MaxInst",
            "Number_Of_Static_Instances",
            "Max_Number_Of_Dynamic_Instances",
            "Instance_Attributes",
            "Class_Attributes",
        ],
        numbered: &[
            "Assem",
            "AssemExa",
            "Variant",
            "VariantExa",
            "BitStringVariant",
            "Array",
            "ProxyAssem",
            "ProxiedAssem",
            "ProxyVariant",
            "ProxiedVariant",
        ],
    },
];

/// How sections begin that are known and not judged.
const FOREIGN: [&str; 14] = [
    "Modular",
    "Capacity",
    "Port",
    "Connection Manager",
    "Connection Configuration",
    "Variant",
    "Proxy",
    "Internationalization",
    "Symbolic Translation",
    "Event",
    "Safety",
    "Parameter Class",
    "Object",
    "Ethernet",
];

/// Of Jaro-Winkler; what is less alike is another word.
const SIMILAR: f64 = 0.85;
const LONGEST_NAME: usize = 64;
