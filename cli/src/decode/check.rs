//! What the command line allows, but cannot be done.

use powerlink_core::monitor as powerlink;

use super::protocol::Spoken;
use crate::args::{DecodeArgs, Protocol};
use crate::exit::Failure;
use crate::recording::Network;
use crate::standard::at_most_one;

/// The network that the command line names; `None` if the recording has to tell.
pub(super) fn network(args: &DecodeArgs) -> Option<Network> {
    match args.protocol {
        Protocol::Auto => None,
        Protocol::Devicenet | Protocol::Devicenex => Some(Network::Can),
        Protocol::Powerlink => Some(Network::Ethernet),
    }
}

/// Whatever the recording is.
pub(super) fn check(args: &DecodeArgs, json: bool) -> Result<(), Failure> {
    match args.protocol {
        Protocol::Auto if of_devicenet(args).is_none() => {}
        Protocol::Auto | Protocol::Devicenet | Protocol::Devicenex => check_can(args)?,
        Protocol::Powerlink => check_ethernet(args)?,
    }
    at_most_one(args.eds.iter().map(|eds| &*eds.path).chain([&*args.file]))?;
    if let (Some(from), Some(to)) = (args.from, args.to)
        && from > to
    {
        return Err(Failure::Usage(format!("--from {from} is after --to {to}: no frame can be shown")));
    }
    check_words(args, json)?;
    if args.scanlist && (json || args.is_record_on_stdout()) {
        return Err(Failure::Usage(
            "a scan list is TOML on standard output: leave --json and `--record -` out".to_owned(),
        ));
    }
    if args.is_record_on_stdout() && (json || args.summary) {
        let other = if json { "--json" } else { "--summary" };
        return Err(Failure::Usage(format!(
            "{other} and `--record -` both want standard output: record into a file, or leave {other} out"
        )));
    }
    Ok(())
}

/// Refuses an option that could change nothing.
fn check_words(args: &DecodeArgs, json: bool) -> Result<(), Failure> {
    if args.bit_rate.is_some() && !args.summary {
        return Err(Failure::Usage(
            "--bit-rate is for the bus load of a summary: add --summary, or leave it out".to_owned(),
        ));
    }
    let without_lines = [
        (args.summary, "--summary"),
        (args.scanlist, "--scanlist"),
        (json, "--json"),
        (args.is_record_on_stdout(), "`--record -`"),
    ];
    match without_lines.into_iter().find(|(is_wanted, _)| *is_wanted) {
        Some((_, other)) if args.time.is_some() => Err(Failure::Usage(format!(
            "--time is for the lines of the text, and {other} prints none: leave one of them out"
        ))),
        _ => Ok(()),
    }
}

/// Refuses what the other protocol of CAN has.
pub(super) fn check_can(args: &DecodeArgs) -> Result<(), Failure> {
    match (args.protocol, args.mac) {
        (Protocol::Devicenet, Some(mac @ 64..)) => {
            return Err(Failure::Usage(format!("--mac {mac}: a MAC ID of DeviceNet is 0 to 63")));
        }
        (_, Some(mac @ 128..)) => {
            return Err(Failure::Usage(format!(
                "--mac {mac}: a MAC ID is 0 to 63, an operational address of DeviceNeX 0 to 127"
            )));
        }
        _ => {}
    }
    match of_devicenet(args) {
        Some(option) if Spoken::of(args) == Some(Spoken::DeviceNex) => {
            Err(Failure::Usage(format!("{option} is for DeviceNet, and the frames are to be DeviceNeX")))
        }
        _ => Ok(()),
    }
}

/// Refuses what Ethernet POWERLINK has not.
pub(super) fn check_ethernet(args: &DecodeArgs) -> Result<(), Failure> {
    let of_can = args.bit_rate.map(|_| "--bit-rate");
    if let Some(option) = of_devicenet(args).or(of_can) {
        return Err(Failure::Usage(format!(
            "{option} is for DeviceNet, and the frames are Ethernet POWERLINK"
        )));
    }
    if args.record.is_some() {
        return Err(Failure::Usage(
            "--record writes CAN frames, and these are Ethernet: `tshark -r FILE -Y FILTER -w FILE` copies some of them"
                .to_owned(),
        ));
    }
    let of_powerlink = powerlink::Kind::ALL.map(powerlink::Kind::name);
    match args.kind.iter().find(|kind| !of_powerlink.contains(kind)) {
        Some(kind) => {
            let kinds = of_powerlink.join(", ");
            Err(Failure::Usage(format!(
                "--kind {kind} is for DeviceNet; those of Ethernet POWERLINK are {kinds}"
            )))
        }
        None => Ok(()),
    }
}

/// An option that only DeviceNet has.
fn of_devicenet(args: &DecodeArgs) -> Option<&'static str> {
    let options =
        [("--scanlist", args.scanlist), ("--expect", args.expect.is_some()), ("--eds", !args.eds.is_empty())];
    options.into_iter().find_map(|(option, is_given)| is_given.then_some(option))
}
