//! What a node sends, in numbers.

use core::time::Duration;

use link_core::Instant;

/// What a node has sent. All counts are of its own frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Traffic {
    /// Frames.
    pub frames: u64,
    /// Data bytes in them.
    pub bytes: u64,
    /// Responses, I/O included, whose request was seen.
    pub responses: u64,
    /// Error responses.
    pub error_responses: u64,
    /// Frames with a problem.
    pub problems: u64,
    /// Response time of the last response.
    pub last_latency: Option<Duration>,
    /// Of the first frame and of the last.
    heard: Option<(Instant, Instant)>,
}

/// A frame, as it is counted for its sender.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sent {
    /// When.
    pub at: Instant,
    /// Data bytes.
    pub bytes: usize,
    /// It has a problem.
    pub is_problem: bool,
    /// It is an error response, or completes one.
    pub is_error_response: bool,
    /// How long the request has waited that it answers.
    pub latency: Option<Duration>,
}

impl Traffic {
    /// Nothing.
    pub const NONE: Self = Self {
        frames: 0,
        bytes: 0,
        responses: 0,
        error_responses: 0,
        problems: 0,
        last_latency: None,
        heard: None,
    };

    /// When the node was first heard.
    #[must_use]
    pub fn first_seen(&self) -> Option<Instant> {
        self.heard.map(|(first, _)| first)
    }

    /// When it was last heard.
    #[must_use]
    pub fn last_seen(&self) -> Option<Instant> {
        self.heard.map(|(_, last)| last)
    }

    /// Counts a frame.
    pub fn count(&mut self, sent: Sent) {
        let first = self.first_seen().unwrap_or(sent.at);
        self.heard = Some((first, sent.at));
        let bytes = u64::try_from(sent.bytes).unwrap_or_default();
        self.frames = self.frames.saturating_add(1);
        self.bytes = self.bytes.saturating_add(bytes);
        self.problems = self.problems.saturating_add(u64::from(sent.is_problem));
        self.error_responses = self.error_responses.saturating_add(u64::from(sent.is_error_response));
        if sent.latency.is_some() {
            self.responses = self.responses.saturating_add(1);
            self.last_latency = sent.latency;
        }
    }
}
