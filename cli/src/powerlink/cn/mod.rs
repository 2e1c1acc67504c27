//! `devicenet powerlink cn`: a controlled node with inputs and outputs.

mod io;

use link_core::Instant;
use link_core::ethernet::Port as _;
use powerlink_core::dictionary::Device;
use powerlink_core::nmt::NmtState;
use powerlink_core::node::{Config, DefaultMapping, NodeEvent};
use powerlink_core::wire::Identity;
use powerlink_core::{ControlledNode, MacAddress, NodeId};

use super::args::CnArgs;
use super::log::Log;
use super::session::{News, Session};
use crate::exit::{Exit, Failure};
use io::{DEVICE_TYPE, Direction, Io, mapping};

/// Is a controlled node.
pub(super) fn run(args: &CnArgs, json: bool) -> Result<Exit, Failure> {
    let (digital, analog) = (usize::from(args.digital), usize::from(args.analog));
    let room = digital + 2 * analog;
    if args.inputs.0.len() > room {
        return Err(Failure::Usage(format!(
            "--inputs has {} bytes, but --digital {digital} and --analog {analog} have {room}",
            args.inputs.0.len()
        )));
    }
    let what = format!("as node {}: answers to a managing node", args.node);
    let mut session = Session::open(&args.station, Some(args.answer_within.0), &what)?;

    let mut objects = Io::default();
    objects.mirror = args.mirror;
    objects.set_inputs(&args.inputs.0, digital);
    let mut node: Node = ControlledNode::new(config(args, session.interface().mac())?, objects)
        .map_err(|error| Failure::Usage(error.to_string()))?;
    let mut log = Log::new(NodeId(args.node), json);
    let mut outputs = Outputs { digital, analog, told: None };
    log.start(session.now(), session.zero())?;
    node.power_on(session.now());
    let tell = |node: &mut Node, now, news| match news {
        News::Event(NodeEvent::ProcessData { is_valid, .. }) => outputs.tell(node, now, is_valid, &mut log),
        News::Event(event) => {
            log.event(now, &event)?;
            match event {
                NodeEvent::StateChanged { to, .. } => outputs.follow(node, now, to, &mut log),
                _ => Ok(()),
            }
        }
        News::Link(event) => log.link(now, event),
        News::Time => log.time(now),
    };
    let ran = session.run(&mut node, tell, |_| false);
    let ended = log.end(session.now(), &node.state(), node.counters());
    // The first failure is the one that is told.
    ran.and(ended.map_err(Failure::from))?;
    session.finish()?;
    Ok(if node.error_led() { Exit::Findings } else { Exit::Done })
}

/// All inputs and outputs fit into process data of 36 bytes or a little more.
type Node = ControlledNode<Io, 64>;

fn config(args: &CnArgs, mac: MacAddress) -> Result<Config, Failure> {
    let identity = Identity {
        vendor_id: args.vendor,
        product_code: args.product,
        revision: args.revision,
        serial_number: args.serial,
    };
    // It was checked that they fit.
    let [latency, tolerance] = [args.answer_within, args.loss_of_soc_tolerance]
        .map(|time| u32::try_from(time.0.as_nanos()).unwrap_or(u32::MAX));
    let device = Device {
        device_type: DEVICE_TYPE,
        name: "devicenet powerlink cn",
        software_version: env!("CARGO_PKG_VERSION"),
        pres_latency: latency,
        asnd_latency: latency,
        ..Device::new(identity)
    };
    let mut config =
        Config::new(NodeId(args.node), mac, device).map_err(|error| Failure::Usage(error.to_string()))?;
    // Once in the life of the program.
    let entries = |direction| &*mapping(direction, args.digital, args.analog).leak();
    config.mapping =
        DefaultMapping { receive: entries(Direction::Outputs), transmit: entries(Direction::Inputs) };
    let size = u16::from(args.digital) + 2 * u16::from(args.analog);
    let values = &mut config.values;
    values.loss_of_soc_tolerance = tolerance;
    (values.preq_limit, values.pres_limit) = (values.preq_limit.max(size), values.pres_limit.max(size));
    Ok(config)
}

/// Outputs are told when they change, not in every cycle.
struct Outputs {
    digital: usize,
    analog: usize,
    told: Option<(Vec<u8>, bool)>,
}

impl Outputs {
    /// They count in `Operational` only, and a reset restores them.
    fn follow(&mut self, node: &Node, now: Instant, to: NmtState, log: &mut Log) -> std::io::Result<()> {
        match self.told {
            Some(_) if to != NmtState::Operational => self.tell(node, now, false, log),
            _ => Ok(()),
        }
    }

    fn tell(&mut self, node: &Node, now: Instant, is_valid: bool, log: &mut Log) -> std::io::Result<()> {
        let outputs = node.objects().outputs(self.digital, self.analog);
        let is_known = self.told.as_ref().is_some_and(|(told, valid)| (told, *valid) == (&outputs, is_valid));
        if is_known {
            return Ok(());
        }
        log.outputs(now, &outputs, is_valid)?;
        self.told = Some((outputs, is_valid));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::*;

    #[derive(clap::Parser)]
    struct Line {
        #[command(flatten)]
        args: CnArgs,
    }

    /// A program on a computer hears a SoC later than the 100 us of the specification at times.
    #[test]
    fn a_soc_may_be_late() {
        for (given, expected) in [("", 50_000_000), ("--loss-of-soc-tolerance=2ms", 2_000_000)] {
            let line = ["cn", "eth0", "--node", "1", given].into_iter().filter(|word| !word.is_empty());
            let args = Line::parse_from(line).args;
            let config = config(&args, MacAddress::default()).unwrap();
            assert_eq!(config.values.loss_of_soc_tolerance, expected);
        }
    }
}
