//! `devicenet monitor`: a bus at a glance.
//!
//! ```text
//! port ─▶ model ─▶ picture ─┬─▶ lines: text or JSON, for a file, a pipe, a log
//!                           └─▶ screen
//! ```

mod lines;
mod model;
mod screen;
mod words;

use std::io::{self, IsTerminal as _};

use link_core::{BitRate, Port as _};

use super::args::MonitorArgs;
use super::endpoint::Endpoint;
use super::permit;
use super::port::LivePort;
use crate::bus_rate::BusRate;
use crate::exit::{Exit, Failure};
use crate::health;
use crate::output::{self, Output};
use crate::simulate;
use crate::standard::shown;
use model::{LinkState, Model};
use screen::Theme;

/// Watches a bus.
///
/// # Errors
/// [`Failure`] when the endpoint cannot be used or fails, or the output cannot be written.
pub fn monitor(args: &MonitorArgs, json: bool) -> Result<Exit, Failure> {
    let expected = args.expect.as_deref().map(health::expected).transpose()?;
    let mut port = LivePort::open_listen_only(&args.endpoint)?;
    let interrupted = simulate::interruption()?;
    port.set_interruption(interrupted);
    if let Some(span) = args.span {
        let end = port.now() + span.0;
        port.set_end(end);
    }
    let bit_rate = bit_rate(args, &port)?;
    let learning = args.learn.map(|span| span.0);
    let known = bit_rate.and_then(BusRate::known);
    let mut model = Model::new(bit_rate, health::doctor(known, expected.as_ref(), learning));
    let output = Output::new();
    let ended = if json || args.text || !output.is_terminal() || !io::stdin().is_terminal() {
        lines::run(args, &mut port, &mut model, output, json)
    } else {
        let theme = Theme { is_coloured: output.is_coloured() };
        // The screen writes to the same standard output.
        drop(output);
        let ended = screen::run(args, &mut port, &mut model, interrupted, theme);
        // Also of a bus that fails, but not of a terminal on which nothing was seen.
        let is_nothing = ended.is_err() && model.begin().is_none();
        let told = if is_nothing { Ok(()) } else { lines::last_words(&model.report()) };
        ended.and(told)
    };
    port.tell_the_rest();
    if let Endpoint::Recording(path) = &args.endpoint
        && model.is_silent()
    {
        output::note(format_args!("{}: no frames", shown(path, "<stdin>")));
    }
    port.note_early_end(&args.endpoint, args.span);
    ended?;
    conclude(&args.endpoint, &model)
}

/// The bit rate as the bus tells it, or else the user.
fn bit_rate(args: &MonitorArgs, port: &LivePort) -> Result<Option<BusRate>, Failure> {
    let said = args.bit_rate.map(BitRate);
    match (port.bit_rate(), said) {
        (Some(known), Some(said)) if known != said => Err(Failure::Usage(format!(
            "{}: --bit-rate says {said}, but it has {known}: leave --bit-rate out",
            args.endpoint
        ))),
        (known, said) => Ok(known.map(BusRate::Known).or(said.map(BusRate::Said))),
    }
}

/// How it ends.
fn conclude(endpoint: &Endpoint, model: &Model) -> Result<Exit, Failure> {
    match (endpoint, model.link()) {
        (Endpoint::Interface(_), LinkState::Down) => Err(permit::down(endpoint)),
        (Endpoint::Interface(_), LinkState::BusOff) => Err(permit::bus_off(endpoint)),
        _ if model.verdict().is_bad() => Ok(Exit::Findings),
        _ => Ok(Exit::Done),
    }
}
