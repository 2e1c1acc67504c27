//! `[[fault]]`

use core::time::Duration;

use link_core::Instant;

use super::{NodeIndex, Scenario};
use crate::scenario::values::Time;

/// `[[fault]]`
#[derive(Clone, PartialEq, Debug)]
pub struct Fault {
    /// From when.
    pub from: Instant,
    /// Until when; `None` is the end of the run.
    pub to: Option<Instant>,
    /// What is wrong.
    pub kind: FaultKind,
}

/// What a fault does.
#[derive(Clone, PartialEq, Debug)]
pub enum FaultKind {
    /// Bits are flipped, each with probability `rate`.
    BitErrors {
        /// Per bit.
        rate: f64,
        /// Only what these hear; empty: the bus.
        nodes: Vec<NodeIndex>,
    },
    /// One bit of one frame is flipped.
    BitError {
        /// Which attempt to send: 0 is the first that begins after `from`.
        frame: u64,
        /// Which bit, 0 is the start of frame, stuff bits count.
        bit: u32,
        /// Only what these hear; empty: the bus.
        nodes: Vec<NodeIndex>,
    },
    /// Frames do not arrive at these nodes though they arrive at all others.
    LostFrame {
        /// The probability per frame.
        rate: f64,
        /// Only this identifier.
        id: Option<u32>,
        /// They are lost after they were acknowledged; else these nodes see the last bit but one of the frame wrong.
        overrun: bool,
        /// Who misses them.
        nodes: Vec<NodeIndex>,
    },
    /// Bursts in which each bit is flipped with probability one half.
    Noise {
        /// Mean time from the end of one burst to the begin of the next.
        gap: Duration,
        /// Length of a burst.
        length: Duration,
        /// Only what these hear; empty: the bus.
        nodes: Vec<NodeIndex>,
    },
    /// A transceiver pulls the bus dominant.
    Babble {
        /// How long.
        pull: Duration,
        /// From the begin of one pull to that of the next; `pull` is a bus that is dominant for good.
        every: Duration,
    },
    /// The clocks of these nodes are off.
    Clock {
        /// Millionths.
        ppm: i32,
        /// Whose.
        nodes: Vec<NodeIndex>,
    },
    /// These nodes are a segment of their own, apart from all others.
    Segment {
        /// Who.
        nodes: Vec<NodeIndex>,
    },
}

impl FaultKind {
    /// What is wrong, in words.
    #[must_use]
    pub fn words(&self, scenario: &Scenario) -> String {
        let names = |nodes: &[NodeIndex]| scenario.names(nodes);
        let heard = |nodes: &[NodeIndex]| match nodes {
            [] => "on the bus".to_owned(),
            [_] => format!("in what {} hears", names(nodes)),
            _ => format!("in what {} hear", names(nodes)),
        };
        match self {
            Self::BitErrors { rate, nodes } => format!("bit errors {}, {rate} per bit", heard(nodes)),
            Self::BitError { frame, bit, nodes } => {
                format!("an error {} in bit {bit} of frame {frame} from now", heard(nodes))
            }
            Self::LostFrame { rate, id, overrun, nodes } => {
                let which = match id {
                    Some(id) => format!("frames {id:03X}"),
                    None => "frames".to_owned(),
                };
                let share = if *rate < 1.0 { format!(", {rate} of them") } else { String::new() };
                match (overrun, nodes.as_slice()) {
                    (false, nodes) => format!("the end of {which} is wrong {}{share}", heard(nodes)),
                    (true, [_]) => format!("{} is too slow to read {which}{share}", names(nodes)),
                    (true, _) => format!("{} are too slow to read {which}{share}", names(nodes)),
                }
            }
            Self::Noise { gap, length, nodes } => {
                format!(
                    "noise {}, bursts of {} about every {}",
                    heard(nodes),
                    Time(*length),
                    Time(*gap + *length)
                )
            }
            Self::Babble { pull, every } if pull < every => {
                format!("a transceiver holds the bus dominant, for {} every {}", Time(*pull), Time(*every))
            }
            Self::Babble { .. } => "a transceiver holds the bus dominant".to_owned(),
            Self::Clock { ppm, nodes } => format!("the clock of {} is off by {ppm} ppm", names(nodes)),
            Self::Segment { nodes } => format!("{} apart", names(nodes)),
        }
    }
}
