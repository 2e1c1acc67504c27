//! From a recorded frame to a line of text, a JSON object, or an entry in the summary.

use crate::args::DecodeArgs;
use crate::recording::{Channels, Content, RecordedFrame};
use crate::text::push_number;
use crate::trace::{Emphasis, Trace};

use super::json;
use super::outside::Outside;
use super::summary::{Observation, Summary};

/// Decodes frame after frame; constant memory.
pub struct Decoder {
    view: View,
    node: Vec<u8>,
}

/// What becomes of the frames.
enum View {
    Text(Trace),
    Json,
    Summary {
        summary: Box<Summary>,
        json: bool,
    },
    /// Nothing: standard output gets the frames themselves.
    Silent,
}

/// What a frame came to.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Verdict {
    /// The filters leave it out.
    Hidden,
    /// It is in order, as far as can be seen.
    Fine,
    /// It is wrong or suspicious.
    Problem,
}

impl Decoder {
    /// As the command line says.
    #[must_use]
    pub fn new(args: &DecodeArgs, json: bool, coloured: bool) -> Self {
        let view = match (args.summary, json) {
            _ if args.is_record_on_stdout() => View::Silent,
            (true, json) => View::Summary { summary: Box::new(Summary::new(args.bit_rate)), json },
            (false, true) => View::Json,
            (false, false) => View::Text(Trace::new(coloured)),
        };
        Self { view, node: Vec::new() }
    }

    /// Decodes a frame, and appends its line to `out` unless there is to be a summary.
    #[inline]
    pub fn frame(&mut self, out: &mut Vec<u8>, frame: &RecordedFrame, channels: &Channels) -> Verdict {
        let outside = Outside::of(&frame.content);
        let verdict = if outside.is_some() { Verdict::Problem } else { Verdict::Fine };
        let name = frame.channel.map(|channel| channels.name(channel));
        match &mut self.view {
            View::Text(trace) => {
                self.node.clear();
                // A recording of several buses names all but the first of them.
                if let (Some(channel), Some(name)) = (frame.channel, name)
                    && channel.index() > 0
                {
                    self.node.extend_from_slice(name.as_bytes());
                    self.node.push(b'/');
                }
                match None::<u8> {
                    Some(mac) => push_number(&mut self.node, mac),
                    None => self.node.push(b'-'),
                }
                let emphasis = match verdict {
                    Verdict::Problem => Emphasis::Problem,
                    Verdict::Fine | Verdict::Hidden => Emphasis::Normal,
                };
                match outside {
                    Some(outside) => {
                        trace.entry(out, frame.at, &self.node, &frame.content, emphasis, outside)
                    }
                    None => trace.entry(out, frame.at, &self.node, &frame.content, emphasis, ""),
                }
            }
            View::Json => {
                json::begin(out, frame, name);
                if let Some(outside) = outside {
                    json::outside(out, outside);
                }
                json::end(out);
            }
            View::Summary { summary, .. } => {
                let (bits, bytes) = match &frame.content {
                    Content::Classic(frame) => (frame.bit_len() + INTERMISSION, frame.data().len()),
                    Content::Error(_) => (0, 0),
                    Content::Fd(frame) => (0, frame.data().len()),
                };
                summary.observe(&Observation {
                    bus: frame.channel.map_or(0, |channel| channel.index()),
                    at: frame.at,
                    bits,
                    bytes,
                    source: None,
                    connection: None,
                    state: None,
                    latency: None,
                    has_problem: verdict == Verdict::Problem,
                });
            }
            View::Silent => {}
        }
        verdict
    }

    /// Appends the summary, if that is what is wanted.
    pub fn finish(&self, out: &mut Vec<u8>, channels: &Channels, file: &str) {
        let View::Summary { summary, json } = &self.view else { return };
        let name = |index| channels.iter().nth(index).unwrap_or(file).to_owned();
        let text = if *json { summary.json(name) } else { summary.text(name) };
        out.extend_from_slice(text.as_bytes());
    }
}

/// Bits between two frames.
const INTERMISSION: u32 = 3;
