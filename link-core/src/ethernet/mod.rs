//! Raw Ethernet: addresses, lengths, the contract of a machine on it, and the run loop.

mod address;
pub mod drive;
mod machine;

pub use address::MacAddress;
pub use drive::{Port, drive};
pub use machine::{Action, Input, LinkEvent, Machine};

/// The shortest frame that a station sends: from the destination address on, without the CRC, which the adapter makes and checks.
pub const MIN_FRAME: usize = 60;
/// The longest frame, counted in the same way.
pub const MAX_FRAME: usize = 1514;
/// Destination, source and EtherType.
pub const HEADER: usize = 14;
/// The longest payload.
pub const MAX_PAYLOAD: usize = MAX_FRAME - HEADER;
