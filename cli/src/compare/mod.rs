//! `devicenet compare`: what DeviceNeX claims over DeviceNet, measured on the same simulated bus.
//!
//! Every figure comes from networks that are run; none is written down.

mod args;
mod bench;
mod claims;
mod devicenet;
mod devicenex;
mod half;
mod svg;

use core::fmt::{self, Write as _};
use core::time::Duration;
use std::fs;

pub use args::CompareArgs;
pub use claims::{Claim, Measure, Value};

use link_core::{BitRate, Instant};
use transport_mock::rng::Rng;

use crate::exit::{Exit, Failure};
use crate::output::Output;
use crate::table::{Cell, Table};

/// What both protocols are given.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Plan {
    /// Of the bus.
    pub bit_rate: BitRate,
    /// Devices beside the master or manager, 3 to 63.
    pub devices: u8,
    /// Of the moments at which something happens.
    pub seed: u64,
}

/// What both came to.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Comparison {
    /// What they were given.
    pub plan: Plan,
    /// The claims of the paper, in its order.
    pub claims: Vec<Claim>,
}

/// Runs the command.
///
/// # Errors
/// [`Failure`] when the picture or the output cannot be written.
pub fn run(args: &CompareArgs, json: bool) -> Result<Exit, Failure> {
    let comparison = Comparison::run(args.plan());
    let mut output = Output::new();
    if json {
        for claim in &comparison.claims {
            // Neither writing to a vector nor these types can fail.
            let _ = serde_json::to_writer(&mut output.buffer, claim);
            output.buffer.push(b'\n');
        }
    } else {
        output.buffer.extend_from_slice(comparison.to_string().as_bytes());
    }
    output.flush()?;
    if let Some(path) = &args.svg {
        fs::write(path, comparison.svg())
            .map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))?;
    }
    Ok(if comparison.claims.iter().all(|claim| claim.holds) { Exit::Done } else { Exit::Findings })
}

impl Comparison {
    /// Runs all networks.
    #[must_use]
    pub fn run(plan: Plan) -> Self {
        Self { plan, claims: claims::claims(&devicenet::measure(&plan), &devicenex::measure(&plan)) }
    }

    /// As a picture.
    #[must_use]
    pub fn svg(&self) -> String {
        svg::draw(self)
    }

    /// The figures as a table in Markdown.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = String::from("| Claim | Measured | DeviceNet | DeviceNeX |\n|---|---|---|---|\n");
        for claim in &self.claims {
            for (place, measure) in claim.measures.iter().enumerate() {
                let name = if place == 0 { claim.claim } else { "" };
                // Writing to a string cannot fail.
                let _ = writeln!(
                    text,
                    "| {name} | {} | {} | {} |",
                    measure.measure, measure.devicenet, measure.devicenex
                );
            }
        }
        text
    }
}

/// A table, and under it what each claim has come to.
impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = Table::new(&["", "DeviceNet", "DeviceNeX"]);
        for claim in &self.claims {
            table.row(vec![Cell::left(claim.claim), Cell::right(""), Cell::right("")]);
            for measure in &claim.measures {
                table.row(vec![
                    Cell::left(format!("  {}", measure.measure)),
                    Cell::right(short(measure.devicenet)),
                    Cell::right(short(measure.devicenex)),
                ]);
            }
        }
        writeln!(
            f,
            "DeviceNet and DeviceNeX at {}, {} devices\n\n{table}",
            self.plan.bit_rate, self.plan.devices
        )?;
        for claim in &self.claims {
            let verdict = if claim.holds { "holds" } else { "does not hold" };
            writeln!(f, "{}: {verdict}. {}", claim.claim, claim.finding)?;
        }
        Ok(())
    }
}

/// Words have no room in a column of figures: the finding has them.
fn short(value: Value) -> String {
    match value {
        Value::Words(words) => words.split(',').next().unwrap_or(words).to_owned(),
        Value::Count(_) | Value::Time(_) => value.to_string(),
    }
}

impl Plan {
    /// The bus, and a node that acknowledges, so that nobody is ever alone.
    fn bus(&self) -> String {
        let BitRate(rate) = self.bit_rate;
        format!("[bus]\nbit_rate = {rate}\nduration = \"1h\"\n{BYSTANDER}")
    }

    /// A moment within the next ten milliseconds: what happens at it does not keep time with the bus.
    fn moment(&self, now: Instant, round: u8) -> Instant {
        now + Duration::from_nanos(Rng::new(self.seed, round.into()).below(10_000_000))
    }

    /// What has not come by then does not come.
    const fn patience(&self) -> Duration {
        Duration::from_secs(30)
    }
}

const BYSTANDER: &str = "[[node]]\nname = \"bystander\"\nrole = \"external\"\n";
