//! Commands on a live bus. The same work on the simulated bus, and what only listens on a recording.
//!
//! ```text
//! can0      sim:FILE      log:FILE         endpoint
//!   │           │             │            port: a link_core::Port of each
//!   └───────────┼─────────────┘
//!             listen ────────────────────▶ who is there, who polls whom, is the bit rate right
//!               │  permit: --allow-tx, the bit rate is confirmed, no other master has the node
//!             visit ─────────────────────▶ explicit connection, requests, release
//! ```

mod args;
mod ask;
mod assignment;
mod attribute;
mod endpoint;
mod errand;
mod listen;
mod monitor;
mod permit;
mod port;
mod record;
mod recorded;
mod recover;
mod run;
mod scan;
mod trigger;
mod visit;
mod watch;

pub(crate) use args::parse_span;
pub use args::{
    AskArgs, GetArgs, MonitorArgs, NodeArgs, PermitArgs, RecordArgs, RecoverArgs, RunArgs, ScanArgs, SetArgs,
};
pub use ask::{get, set};
pub use assignment::{Assignment, Device};
pub use attribute::AttributePath;
pub use endpoint::Endpoint;
pub use monitor::monitor;
pub use record::record;
pub use recover::recover;
pub use run::{master, slave};
pub use scan::scan;
pub use trigger::{FrameFilter, Trigger};
