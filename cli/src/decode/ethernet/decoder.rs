//! From a captured frame to a line of text, a JSON object, or an entry in the summary.

use powerlink_core::NodeId;
use powerlink_core::monitor::{Captured, Kind, Monitor, Reading};
use powerlink_core::wire::Body;

use super::summary::Summary;
use crate::args::DecodeArgs;
use crate::decode::buses::of_bus;
use crate::decode::clock::Clock;
use crate::decode::decoder::Verdict;
use crate::decode::json;
use crate::decode::span::Span;
use crate::recording::{Channels, EthernetFrame, RecordedFrame};
use crate::text::{printable, push_number};
use crate::trace::{Emphasis, Trace};

/// Decodes frame after frame; constant memory.
pub struct Decoder {
    span: Span,
    node: Option<NodeId>,
    kinds: Vec<&'static str>,
    /// One for each channel: every channel is a network of its own.
    monitors: Vec<Box<Monitor>>,
    view: View,
    sender: Vec<u8>,
}

/// What becomes of the frames.
enum View {
    Text { trace: Trace, clock: Clock },
    Json,
    Summary { summary: Box<Summary>, json: bool },
}

impl Decoder {
    /// As the command line says.
    #[must_use]
    pub fn new(args: &DecodeArgs, json: bool, coloured: bool) -> Self {
        let view = match (args.summary, json) {
            (true, json) => View::Summary { summary: Box::default(), json },
            (false, true) => View::Json,
            (false, false) => {
                View::Text { trace: Trace::new(coloured), clock: Clock::new(args.time.unwrap_or_default()) }
            }
        };
        Self {
            span: Span::new(args),
            node: args.mac.map(NodeId),
            kinds: args.kind.clone(),
            monitors: Vec::new(),
            view,
            sender: Vec::new(),
        }
    }

    /// Decodes a frame, and appends its line to `out` unless there is to be a summary.
    #[inline]
    pub fn frame(
        &mut self,
        out: &mut Vec<u8>,
        frame: &RecordedFrame<EthernetFrame>,
        channels: &Channels,
    ) -> Verdict {
        let bus = frame.channel.map_or(0, |channel| channel.index());
        let captured = Captured { bytes: &frame.content.bytes, length: frame.content.length };
        let monitor = of_bus(&mut self.monitors, bus, Box::default);
        let reading = monitor.observe(frame.at, frame.n, captured);
        if let View::Text { clock, .. } = &mut self.view {
            clock.see(frame.at);
        }
        let is_of_node = self.node.is_none_or(|node| concerns(&reading, node));
        let is_of_kind = self.kinds.is_empty() || self.kinds.contains(&reading.kind.name());
        if !self.span.contains(frame.at) || !is_of_node || !is_of_kind {
            return Verdict::Hidden;
        }
        let name = frame.channel.map(|channel| channels.name(channel));
        match &mut self.view {
            View::Text { trace, clock } => {
                write_sender(&mut self.sender, &reading, name.filter(|_| bus > 0));
                let emphasis = if reading.problem.is_some() { Emphasis::Problem } else { Emphasis::Normal };
                let message = (reading.kind.message(), data(&reading));
                trace.message(out, clock.show(frame.at), &self.sender, message, emphasis, &reading);
            }
            View::Json => json::ethernet(out, (frame.at, frame.digits), name, &reading),
            View::Summary { summary, .. } => summary.observe(bus, frame.digits, &reading),
        }
        if reading.problem.is_some() { Verdict::Problem } else { Verdict::Fine }
    }

    /// Appends the summary, if that is what is wanted. `file` names a network that has no name; so many of its records could
    /// not be read.
    pub fn finish(&mut self, out: &mut Vec<u8>, channels: &Channels, file: &str, unread: u64) {
        let View::Summary { summary, json } = &mut self.view else { return };
        summary.conclude(unread);
        let name = |bus| channels.iter().nth(bus).unwrap_or(file).to_owned();
        let monitors = &self.monitors;
        let origin = self.span.begin();
        let text = if *json { summary.json(monitors, name) } else { summary.text(monitors, name, origin) };
        out.extend_from_slice(text.as_bytes());
    }

    /// Whether something is or was wrong, as the summary says; `None` without one, and before [`finish`](Self::finish).
    #[must_use]
    pub fn is_bad(&self) -> Option<bool> {
        match &self.view {
            View::Summary { summary, .. } => summary.is_bad(),
            View::Text { .. } | View::Json => None,
        }
    }
}

/// What the frame carries; of a frame that is not read, what is behind its Ethernet headers.
fn data<'a>(reading: &Reading<'a>) -> &'a [u8] {
    match reading.kind {
        Kind::Foreign | Kind::Invalid | Kind::Reserved => reading.payload(),
        _ => reading.value().unwrap_or_default(),
    }
}

/// The node ID of the sender, after the channel in a capture of several networks, all but the first of which are named.
fn write_sender(sender: &mut Vec<u8>, reading: &Reading<'_>, channel: Option<&str>) {
    sender.clear();
    if let Some(name) = channel {
        sender.extend_from_slice(printable(name).as_bytes());
        sender.push(b'/');
    }
    match reading.src {
        Some(NodeId(number)) => push_number(sender, number),
        None => sender.push(b'-'),
    }
}

/// Whether a frame is from a node or to it, invites it, or is a command to all that means it.
fn concerns(reading: &Reading<'_>, node: NodeId) -> bool {
    let is_meant = match &reading.body {
        Some(Body::Soa(soa)) => soa.target == node,
        Some(Body::NmtCommand(command)) => reading.dst == Some(NodeId::BROADCAST) && command.is_for(node),
        Some(Body::NmtRequest(request)) => request.target == node,
        _ => false,
    };
    is_meant || reading.src == Some(node) || reading.dst == Some(node)
}
