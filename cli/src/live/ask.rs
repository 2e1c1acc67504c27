//! `devicenet get` and `devicenet set`.

use cip_core::code::{AdditionalCode, ClassId, GeneralStatus};
use devicenet_core::MacId;
use devicenet_core::master::Cause;
use link_core::Machine as _;
use serde_json::json;

use super::args::{AskArgs, GetArgs, SetArgs};
use super::attribute::AttributePath;
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
    let moves_to = value.as_deref().and_then(|value| new_mac_id(attribute, value)).filter(|new| *new != mac);
    if moves_to == Some(own) {
        return Err(Failure::Usage(format!(
            "MAC ID {own} is this command's own while it works: give node {mac} another, or choose one with --own-mac"
        )));
    }
    let mut visitor = Visitor::new(endpoint, own);
    let mut what = format!("to node {mac} Allocate, {service}_Attribute_Single {attribute}");
    if let Some(value) = &value {
        what += &format!(" = {}", attribute.words(value));
    }
    what += ", Release";
    let questions = vec![Question { path: *attribute, value }];
    match moves_to {
        Some(new) => {
            visitor.visit_if_absent(new, mac, questions);
            what = format!("to node {new} Allocate, to see whether it is there; {what}");
        }
        None => visitor.visit(mac, questions),
    }
    let (mut port, heard) = permit::enter(endpoint, &node.permit, own, &what, visitor.max_in_flight())?;
    if let Some(new) = moves_to
        && heard.node(new).is_some_and(|node| node.traffic.first_seen().is_some())
    {
        return Err(in_use(mac, new));
    }
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
    if report.mac != mac {
        return Err(in_use(mac, report.mac));
    }
    let exit = conclude(args, report, json)?;
    if let Some(new) = moves_to.filter(|_| exit == Exit::Done) {
        output::note(format_args!(
            "node {mac} now checks MAC ID {new}, and comes back as node {new}; its master has to be told"
        ));
    }
    Ok(exit)
}

/// The MAC ID that the node will have: attribute 1 of the DeviceNet object.
fn new_mac_id(path: &AttributePath, value: &[u8]) -> Option<MacId> {
    let is_mac_id = (path.class, path.instance.0, path.attribute.0) == (ClassId::DEVICENET, 1, 1);
    let [number] = value else { return None };
    if is_mac_id { MacId::new(*number) } else { None }
}

/// A node that takes a MAC ID that is taken finds its duplicate, and falls silent.
fn in_use(mac: MacId, new: MacId) -> Failure {
    Failure::Refused(format!(
        "MAC ID {new} is in use, and node {mac} would fall silent with it: choose one that `devicenet scan` does not list, or move \
         node {new} first"
    ))
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
        (Some(Answer::Unsent(why)), _) => {
            object["problem"] = why.to_string().into();
            (format!("node {mac} cannot be asked for {path}: {why}"), Exit::Findings)
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
