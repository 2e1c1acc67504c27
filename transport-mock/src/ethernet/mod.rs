//! A simulated Ethernet segment in virtual time: stations on a hub, at 100 Mbit/s, with faults.
//!
//! ```text
//!  Machine   Machine   Machine     any protocol on link_core::ethernet, with a reaction time of its own
//!     |         |         |
//!  adapter   adapter   adapter     sends in order, waits while the wire is busy
//!     |         |         |
//!     +------- hub -------+        everybody hears everybody, after the propagation delay
//!                |
//!              faults              for each frame and each receiver: lost, corrupted, twice, late, replaced
//! ```
//!
//! | exact | simplified |
//! |---|---|
//! | the time of a frame: preamble, padding, CRC and gap are counted | adapters that want to send while the wire is busy take turns in the order of their wishes: there are no collisions |
//! | a frame arrives when its last byte does | one delay for all pairs of stations |
//! | own frames do not come back | an adapter delivers whatever it hears, whoever it is for |
//!
//! A protocol in which one station decides who sends has no collisions as long as all of them keep to it; who does not is seen
//! in the records, which say who sent when and what waited ([`FrameRecord::waited`]).
//!
//! Everything follows from the seed and the calls: two runs are the same to the nanosecond.
//!
//! ```
//! use std::time::Duration;
//! use link_core::ethernet::{Action, Input, Machine};
//! use link_core::{Deadline, Instant};
//! use transport_mock::ethernet::{Segment, SegmentConfig, StationConfig};
//!
//! /// Answers every frame with its last byte.
//! struct Echo(Option<u8>);
//!
//! impl Machine for Echo {
//!     type Event = ();
//!     fn input(&mut self, _: Instant, input: Input<'_>) {
//!         if let Input::Frame(bytes) = input {
//!             self.0 = bytes.last().copied();
//!         }
//!     }
//!     fn poll<'b>(&mut self, _: Instant, buffer: &'b mut [u8]) -> Option<Action<'b, ()>> {
//!         *buffer.first_mut()? = self.0.take()?;
//!         Some(Action::Transmit(&buffer[..1]))
//!     }
//!     fn deadline(&self) -> Option<Deadline> { None }
//! }
//!
//! let mut segment = Segment::new(SegmentConfig::default());
//! segment.add(StationConfig { reaction: Duration::from_micros(3), ..StationConfig::named("echo") }, Echo(None));
//! segment.inject(&[0, 42]);
//! segment.run_for(Duration::from_micros(20));
//! let frames: Vec<_> = segment.frames().map(|frame| (frame.start.as_nanos(), frame.bytes.clone())).collect();
//! // 72 bytes with the preamble take 5760 ns, and 500 ns to arrive.
//! assert_eq!(frames, [(0, vec![0, 42]), (9260, vec![42])]);
//! ```

mod fault;
mod record;
mod run;
mod segment;
mod station;
#[cfg(test)]
mod tests;

pub use fault::{Fate, FaultId, Passage, nth, rate};
pub use record::{FrameRecord, Keep, Record};
pub use segment::{Segment, SegmentConfig};
pub use station::{StationConfig, StationId};
