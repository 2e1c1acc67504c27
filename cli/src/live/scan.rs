//! `devicenet scan`.

use cip_core::code::{AttributeId, ClassId, InstanceId};
use cip_core::codec::Wire as _;
use cip_core::identity::Revision;
use devicenet_core::MacId;
use devicenet_core::master::Cause;
use devicenet_core::monitor::NodeRecord;
use link_core::{Instant, Machine as _, Port as _};
use serde_json::{Value, json};

use super::args::ScanArgs;
use super::ask::{mac_id, refusal, trouble};
use super::attribute::AttributePath;
use super::endpoint::Endpoint;
use super::listen::Heard;
use super::permit;
use super::port::LivePort;
use super::visit::{Answer, Question, Report, Visitor};
use crate::exit::{Exit, Failure};
use crate::output::{self, Output};
use crate::simulate;
use crate::table::{Cell, Table};
use crate::text::{count, product_name};

/// Tells who is on a bus.
///
/// # Errors
/// [`Failure`] when the endpoint cannot be used, or the bus does not allow to transmit.
pub fn scan(args: &ScanArgs, json: bool) -> Result<Exit, Failure> {
    let ScanArgs { endpoint, node } = args;
    let own = mac_id(node.own_mac);
    let is_active = match endpoint {
        Endpoint::Interface(_) => node.permit.allow_tx,
        Endpoint::Scenario(_) => true,
        Endpoint::Recording(_) => false,
    };
    let (heard, reports, bad_entries) = if is_active {
        let what = "to each node that no master owns Allocate, Get_Attribute_Single of Identity 1 to 4, 6 and 7, Release";
        let mut visitor = Visitor::new(endpoint, own);
        let (mut port, heard) = permit::enter(endpoint, &node.permit, own, what, visitor.max_in_flight())?;
        for mac in MacId::all().filter(|mac| *mac != own && heard.master_of(*mac).is_none()) {
            visitor.visit(mac, identity());
        }
        let reports = visitor.run(endpoint, &mut port)?;
        (heard, reports, 0)
    } else {
        // Ctrl-C ends listening, and what was heard is told.
        let interrupted = simulate::interruption()?;
        let mut port = LivePort::open_listen_only(endpoint)?;
        port.set_interruption(interrupted);
        let until = match endpoint {
            Endpoint::Recording(_) => Instant::MAX,
            Endpoint::Interface(_) | Endpoint::Scenario(_) => port.now() + node.permit.listen.0,
        };
        let mut heard = Heard::new();
        let listened = heard.listen(&mut port, until);
        port.tell_the_rest();
        listened?;
        if matches!(endpoint, Endpoint::Interface(_)) {
            permit::link(endpoint, &heard)?;
        }
        (heard, Vec::new(), port.bad_entries())
    };
    match conclude(args, &heard, reports, json)? {
        Exit::Done if bad_entries > 0 => Ok(Exit::Findings),
        exit => Ok(exit),
    }
}

fn conclude(args: &ScanArgs, heard: &Heard, reports: Vec<Report>, json: bool) -> Result<Exit, Failure> {
    let mut output = Output::new();
    let cut = reports.iter().find_map(|report| report.cut);
    let rows = rows(heard, reports);
    let has_findings = rows.iter().any(|row| row.finding.is_some());
    if json {
        for row in &rows {
            output.buffer.extend_from_slice(format!("{}\n", row.json()).as_bytes());
        }
    } else if !rows.is_empty() {
        let mut table =
            Table::new(&["MAC", "state", "vendor", "type", "product", "rev", "serial", "name", "master"]);
        for row in &rows {
            table.row(row.cells());
        }
        output.buffer.extend_from_slice(table.to_string().as_bytes());
    }
    output.flush()?;
    for row in &rows {
        if let Some(finding) = &row.finding {
            output::warn(format_args!("node {}: {finding}", row.mac));
        }
    }
    let frames = count(heard.frames, "frame");
    match (rows.len(), &args.endpoint) {
        (0, Endpoint::Interface(_)) if !args.node.permit.allow_tx => output::note(format_args!(
            "{}: no node was heard ({frames}) in {}; --listen 10s listens longer, --allow-tx asks",
            args.endpoint, args.node.permit.listen
        )),
        (0, _) => output::note(format_args!("{}: no node ({frames} heard)", args.endpoint)),
        (_, Endpoint::Interface(_)) if !args.node.permit.allow_tx => output::note(format_args!(
            "{}: those that were heard ({frames}); --allow-tx asks all of them who they are",
            args.endpoint
        )),
        _ => {}
    }
    if let Some(cut) = cut {
        return Err(cut.failure(&args.endpoint, "every node was asked"));
    }
    Ok(if has_findings { Exit::Findings } else { Exit::Done })
}

/// What is known of a node, from what it said by itself and from what it answered.
struct Row {
    mac: MacId,
    record: Option<NodeRecord>,
    /// The Identity object: attributes that were answered.
    identity: Vec<(AttributePath, Vec<u8>)>,
    has_answered: bool,
    /// Another master has it.
    is_owned: bool,
    finding: Option<String>,
}

fn rows(heard: &Heard, reports: Vec<Report>) -> Vec<Row> {
    let mut rows: Vec<Row> = heard
        .nodes()
        .map(|record| Row {
            mac: record.mac,
            is_owned: heard.master_of(record.mac).is_some(),
            record: Some(record),
            identity: Vec::new(),
            has_answered: false,
            finding: None,
        })
        .collect();
    for report in reports {
        let place = rows.binary_search_by_key(&report.mac, |row| row.mac);
        // Nobody there: no row, unless somebody was heard there.
        if place.is_err() && !has_answered(&report) {
            continue;
        }
        let place = place.unwrap_or_else(|place| {
            let row = Row {
                mac: report.mac,
                record: None,
                identity: Vec::new(),
                has_answered: false,
                is_owned: false,
                finding: None,
            };
            rows.insert(place, row);
            place
        });
        rows[place].answered(report);
    }
    rows
}

/// Whether anything came from the node, be it a refusal.
fn has_answered(report: &Report) -> bool {
    let has_refused =
        matches!(report.trouble, Some(Cause::OwnedByAnother | Cause::Refused | Cause::CheckHeard));
    has_refused || !report.answers.is_empty()
}

impl Row {
    fn answered(&mut self, report: Report) {
        self.has_answered = has_answered(&report);
        if report.trouble == Some(Cause::OwnedByAnother) {
            self.is_owned = true;
        } else if report.trouble.is_some() {
            self.finding = Some(trouble(report.trouble).to_owned());
        }
        for (question, answer) in identity().iter().zip(report.answers) {
            match answer {
                Answer::Done(data) => self.identity.push((question.path, data)),
                Answer::Refused(status, additional) => {
                    self.finding = Some(format!("{}: {}", question.path, refusal(status, additional)));
                }
                Answer::Silent(failure) => self.finding = Some(format!("{}: {failure}", question.path)),
                Answer::Unsent(why) => self.finding = Some(format!("{}: {why}", question.path)),
            }
        }
    }

    /// In words; what was answered counts more than what was heard.
    fn word(&self, attribute: u16, heard: impl FnOnce(&NodeRecord) -> Option<String>) -> Option<String> {
        let answered = self.answer(attribute).map(|data| path(attribute).words(data).to_string());
        answered.or_else(|| heard(self.record.as_ref()?))
    }

    /// Vendor, device type, product code, revision, serial number, product name.
    fn words(&self) -> [Option<String>; 6] {
        [
            self.word(1, |node| Some(path(1).words(&node.vendor?.0.to_le_bytes()).to_string())),
            self.word(2, |node| Some(path(2).words(&node.device_type?.0.to_le_bytes()).to_string())),
            self.word(3, |node| Some(node.product?.to_string())),
            self.revision(),
            self.serial().map(|serial| format!("0x{serial:08X}")),
            self.word(7, name),
        ]
    }

    /// The bytes of an attribute that was answered.
    fn answer(&self, attribute: u16) -> Option<&[u8]> {
        let answered = self.identity.iter().find(|(path, _)| path.attribute.0 == attribute);
        answered.map(|(_, data)| data.as_slice())
    }

    fn uint(&self, attribute: u16) -> Option<u16> {
        self.answer(attribute)?.try_into().ok().map(u16::from_le_bytes)
    }

    fn revision(&self) -> Option<String> {
        let answered = self.answer(4).and_then(|data| Some(Revision::parse(data).ok()?.to_string()));
        let heard = || self.record.as_ref()?.revision.map(|(major, minor)| format!("{major}.{minor}"));
        answered.or_else(heard)
    }

    fn serial(&self) -> Option<u32> {
        let answered = self.answer(6).and_then(|data| Some(u32::from_le_bytes(data.try_into().ok()?)));
        answered.or_else(|| self.record.as_ref()?.serial)
    }

    fn product_name(&self) -> Option<String> {
        let answered = self.answer(7).and_then(|data| product_name(data.get(1..)?));
        answered.or_else(|| product_name(&self.record.as_ref()?.product_name))
    }

    fn state(&self) -> &'static str {
        match &self.record {
            _ if self.has_answered => "online",
            Some(record) => record.access.name(),
            None => "unknown",
        }
    }

    fn master(&self) -> Option<MacId> {
        self.record.as_ref().and_then(|record| record.master)
    }

    /// In the table; not every master was heard.
    fn master_words(&self) -> String {
        match self.master() {
            Some(master) => master.to_string(),
            None if self.is_owned => "?".into(),
            None => "-".into(),
        }
    }

    fn cells(&self) -> Vec<Cell> {
        let mut cells = vec![Cell::right(self.mac.to_string()), Cell::left(self.state())];
        cells.extend(self.words().map(|word| Cell::left(word.unwrap_or_else(|| "-".into()))));
        cells.push(Cell::right(self.master_words()));
        cells
    }

    /// With the fields of a node in a summary of `monitor`, as far as they are known.
    fn json(&self) -> Value {
        let mut object = json!({ "mac": self.mac.number(), "state": self.state() });
        let heard = self.record.as_ref();
        let known = [
            ("vendor", self.uint(1).or_else(|| Some(heard?.vendor?.0)).map(Value::from)),
            ("device_type", self.uint(2).or_else(|| Some(heard?.device_type?.0)).map(Value::from)),
            ("product", self.uint(3).or_else(|| heard?.product).map(Value::from)),
            ("revision", self.revision().map(Value::from)),
            ("serial", self.serial().map(Value::from)),
            ("product_name", self.product_name().map(Value::from)),
        ];
        for (key, value) in known {
            if let Some(value) = value {
                object[key] = value;
            }
        }
        if let Some(master) = self.master() {
            object["master"] = master.number().into();
        }
        object["owned"] = self.is_owned.into();
        if let Some(record) = &self.record {
            object["frames"] = record.traffic.frames.into();
        }
        if let Some(finding) = &self.finding {
            object["problem"] = finding.clone().into();
        }
        object
    }
}

/// ISO 8859-1, in quotation marks as the value of the attribute is.
fn name(record: &NodeRecord) -> Option<String> {
    let name: String = record.product_name.iter().map(|&byte| char::from(byte)).collect();
    (!name.is_empty()).then(|| format!("\"{name}\""))
}

/// An attribute of the Identity object.
const fn path(attribute: u16) -> AttributePath {
    AttributePath { class: ClassId::IDENTITY, instance: InstanceId(1), attribute: AttributeId(attribute) }
}

/// Vendor, device type, product code, revision, serial number, product name.
fn identity() -> Vec<Question> {
    [1, 2, 3, 4, 6, 7].map(|attribute| Question { path: path(attribute), value: None }).to_vec()
}
