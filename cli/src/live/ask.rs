//! `devicenet get` and `devicenet set`.

use cip_core::code::{AdditionalCode, GeneralStatus};
use devicenet_core::MacId;
use devicenet_core::master::Cause;
use link_core::Machine as _;
use serde_json::json;

use super::args::{AskArgs, GetArgs, SetArgs};
use super::permit;
use super::visit::{Answer, Question, Report, Visitor};
use crate::exit::{Exit, Failure};
use crate::output::{self, Output};
use crate::text::{LOWER, push_hex};

/// Reads an attribute.
///
/// # Errors
/// [`Failure`] when the command line, the endpoint or the bus does not allow it.
pub fn get(args: &GetArgs, json: bool) -> Result<Exit, Failure> {
    ask(&args.ask, None, json)
}

/// Writes an attribute.
///
/// # Errors
/// [`Failure`] when the command line, the endpoint or the bus does not allow it.
pub fn set(args: &SetArgs, json: bool) -> Result<Exit, Failure> {
    let value = args.ask.attribute.value(&args.value).map_err(Failure::Usage)?;
    ask(&args.ask, Some(value), json)
}

fn ask(args: &AskArgs, value: Option<Vec<u8>>, json: bool) -> Result<Exit, Failure> {
    let AskArgs { endpoint, attribute, node, .. } = args;
    let (mac, own) = (mac_id(args.mac), mac_id(node.own_mac));
    if mac == own {
        return Err(Failure::Usage(format!(
            "node {mac} is asked, so this command needs another MAC ID: choose a free one with --own-mac"
        )));
    }
    let service = if value.is_some() { "Set" } else { "Get" };
    let mut visitor = Visitor::new(endpoint, own);
    visitor.visit(mac, vec![Question { path: *attribute, value }]);
    let what = format!("to node {mac} Allocate, {service}_Attribute_Single {attribute}, Release");
    let (mut port, heard) = permit::enter(endpoint, &node.permit, own, &what, visitor.max_in_flight())?;
    let reports = match permit::is_owned(mac, &heard) {
        true => vec![Report::owned(mac)],
        false => visitor.run(endpoint, &mut port)?,
    };
    let Some(report) = reports.first() else {
        return Err(Failure::Transport(format!("node {mac} was not visited")));
    };
    if let Some(cut) = report.cut {
        return Err(cut.failure(endpoint, &format!("node {mac} had answered")));
    }
    conclude(args, report, json)
}

fn conclude(args: &AskArgs, report: &Report, json: bool) -> Result<Exit, Failure> {
    let mut output = Output::new();
    let AttributeWords { object, line, exit } = words(args, report);
    if json {
        output.buffer.extend_from_slice(format!("{object}\n").as_bytes());
    } else if exit == Exit::Done {
        output.buffer.extend_from_slice(format!("{line}\n").as_bytes());
    } else {
        output::error(line);
    }
    output.flush()?;
    Ok(exit)
}

struct AttributeWords {
    object: serde_json::Value,
    line: String,
    exit: Exit,
}

fn words(args: &AskArgs, report: &Report) -> AttributeWords {
    let (mac, path) = (report.mac, &args.attribute);
    let mut object = json!({
        "mac": mac.number(),
        "class": path.class.0,
        "instance": path.instance.0,
        "attribute": path.attribute.0,
    });
    if let Some(info) = path.info() {
        object["attribute_name"] = info.name.into();
    }
    let (line, exit) = match (report.answers.first(), report.trouble) {
        (Some(Answer::Done(data)), _) => {
            let mut hex = Vec::new();
            push_hex(&mut hex, data, LOWER);
            let text = path.words(data).to_string();
            let line = if data.is_empty() {
                format!("node {mac}  {path}: done")
            } else {
                format!("node {mac}  {path}: {text}")
            };
            object["value"] = String::from_utf8_lossy(&hex).into();
            object["value_text"] = text.into();
            (line, Exit::Done)
        }
        (Some(Answer::Refused(status, additional)), _) => {
            object["status"] = status.0.into();
            if *additional != AdditionalCode::NONE {
                object["additional"] = additional.0.into();
            }
            object["status_name"] = status.name().into();
            (format!("node {mac} refuses {path}: {}", refusal(*status, *additional)), Exit::Findings)
        }
        (Some(Answer::Silent(failure)), _) => {
            object["problem"] = failure.to_string().into();
            (format!("node {mac}, {path}: {failure}"), Exit::Findings)
        }
        (None, Some(Cause::OwnedByAnother)) => {
            object["owned"] = true.into();
            object["problem"] = trouble(report.trouble).into();
            (permit::owned(mac), Exit::Refused)
        }
        (None, cause) => {
            let why = trouble(cause);
            object["problem"] = why.into();
            (format!("node {mac}: {why}"), Exit::Findings)
        }
    };
    AttributeWords { object, line, exit }
}

/// `error 0x14 Attribute not supported`
pub(super) fn refusal(status: GeneralStatus, additional: AdditionalCode) -> String {
    use cip_core::message::Response;
    Response::Error { status, additional }.to_string()
}

/// Why there is no connection, and what to do.
pub(super) const fn trouble(cause: Option<Cause>) -> &'static str {
    match cause {
        Some(Cause::NoAnswer) => {
            "no answer: it is absent, faulted, or at another bit rate; `devicenet scan` lists who is there"
        }
        Some(Cause::OwnedByAnother) => "it belongs to another master, and is left alone",
        Some(Cause::Refused) => {
            "it refuses an explicit connection: another client may have it; ask again in ten seconds"
        }
        Some(Cause::TimedOut | Cause::CheckHeard) => "it restarted while it was asked: ask again",
        Some(_) | None => "the connection ended before it answered: ask again",
    }
}

pub(super) fn mac_id(number: u8) -> MacId {
    // The command line takes no other.
    MacId::new(number).unwrap_or(MacId::DEFAULT)
}
