//! `devicenet simulate` on the command line.

use std::path::PathBuf;

use clap::Args;

use super::selection::EventKind;
use crate::args::parse_seed;
use crate::scenario::{LONGEST_RUN, Time};

/// `devicenet simulate`.
#[derive(Args, Clone, Debug, Default)]
#[command(after_long_help = "\
A scenario is a TOML file: nodes, what happens to them, faults of the bus, expectations. Without one, the built-in plant is \
simulated: a master, a slave of every kind, a duplicate MAC ID, a cable, a replacement; its figures come last. I/O frames and \
answers that say nothing new are counted; --all-frames tells them. The same scenario and seed give \
the same output, byte for byte. docs/scenarios.md describes every table and key; --print-plant prints one to start from.

Exit codes:
  0  every expectation held
  1  an expectation failed
  2  wrong usage, or a defect of the scenario
  3  the address to serve at cannot be used
  4  refused to serve at an address that other machines can reach

Examples:
  devicenet simulate
  devicenet simulate --summary --svg plant.svg
  devicenet simulate --print-plant > mine.toml
  devicenet simulate - < mine.toml
  devicenet simulate --seed 7 --until 10s --record plant.pcapng scenario.toml
  devicenet simulate --json scenario.toml | jq -c 'select(.event == \"state\")'
  devicenet simulate --event input,output,slave scenario.toml
  devicenet simulate --json --no-event scan,node scenario.toml
  devicenet simulate --serve 127.0.0.1:29536 scenario.toml

Ctrl-C ends a run by the clock as its end would: recording and picture are complete, and what was expected later is not \
judged. A second one ends it at once.

With --serve, python-can sits on the bus:
  can.Bus(interface=\"socketcand\", host=\"127.0.0.1\", port=29536, channel=\"can0\")")]
pub struct SimulateArgs {
    /// The scenario, `-` for standard input; without one, the built-in plant
    pub scenario: Option<PathBuf>,
    /// Print the scenario of the built-in plant, to start from
    #[arg(long, exclusive = true)]
    pub print_plant: bool,
    /// The seed of everything random, instead of that of the scenario
    #[arg(long, value_name = "N", value_parser = parse_seed, allow_hyphen_values = true)]
    pub seed: Option<u64>,
    /// How long to run, instead of the duration of the scenario, such as 10s or 250ms; at most 24h
    #[arg(long, value_name = "TIME", value_parser = parse_until, allow_hyphen_values = true)]
    pub until: Option<Time>,
    /// Record the bus: pcapng for a name that ends so, else a candump log; failed attempts become error frames, each
    /// once, where a listener with `devicenet record` counts those that it sees
    #[arg(long, short = 'o', value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Print every I/O frame of the trace, also those with the same data as the last of their kind; and every connectionless
    /// request of DeviceNeX, also those that are answered as the last time
    #[arg(long, conflicts_with = "summary")]
    pub all_frames: bool,
    /// Only events of this kind, named as in the JSON output; several with commas, or given more than once. In the words of the
    /// trace also what they leave out else: `scan`, `input`, `output`, and all of `connection` and `node`
    #[arg(
        long,
        value_enum,
        value_name = "EVENT",
        value_delimiter = ',',
        conflicts_with = "summary",
        hide_possible_values = true
    )]
    pub event: Vec<EventKind>,
    /// No events of this kind, named as in the JSON output; several with commas, or given more than once
    #[arg(long, value_enum, value_name = "EVENT", value_delimiter = ',', conflicts_with_all = ["summary", "event"])]
    pub no_event: Vec<EventKind>,
    /// Instead of the trace, what each node and the bus have come to
    #[arg(long)]
    pub summary: bool,
    /// Draw a time line of the states of the nodes and the load of the bus
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// Run by the clock on the wall, instead of as fast as possible
    #[arg(long)]
    pub realtime: bool,
    /// Offer the bus to socketcand clients such as python-can, until interrupted or --until; implies --realtime. Port 0 is
    /// any
    #[arg(long, value_name = "HOST:PORT")]
    pub serve: Option<String>,
    /// Serve at an address that other machines can reach: they may then send on the simulated bus
    #[arg(long, requires = "serve")]
    pub allow_remote: bool,
}

/// As the `duration` of a scenario.
fn parse_until(text: &str) -> Result<Time, String> {
    let time: Time = text.parse().map_err(|error: crate::scenario::TimeError| error.to_string())?;
    if time.0.is_zero() || time.0 > LONGEST_RUN {
        return Err(format!("more than 0s expected, at most {}", Time(LONGEST_RUN)));
    }
    Ok(time)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_as_long_as_a_scenario_may_be() {
        assert_eq!(parse_until("24h").map(|time| time.0), Ok(LONGEST_RUN));
        for text in ["0s", "9000h", "1441min"] {
            assert_eq!(parse_until(text), Err("more than 0s expected, at most 86400s".to_owned()), "{text}");
        }
        assert!(parse_until("-1s").unwrap_err().contains("must not be negative"));
    }
}
