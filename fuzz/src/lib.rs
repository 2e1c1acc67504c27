//! What the fuzz targets run: ordinary functions on bytes, tested like any other code.
//!
//! | Target | Under test | What must hold |
//! |---|---|---|
//! | [`bus_paths`] | the simulated bus | the cheap path and the path bit by bit come to the same |
//! | [`dn_access`] | network access | the transition table, held by a second, small program |
//! | [`dn_master`] | the master | outputs only to the right device, no torn message, nothing off line, nothing stuck |
//! | [`dn_slave`] | a slave | connections, ownership, time-outs and data, held by a second, small program |
//! | [`dn_tool`] | the offline recovery tool | the rules of the offline connection set |
//! | [`eds`] | Electronic Data Sheets | written as read; a finding has its place; what is made of a file agrees with it |
//! | [`fragment`] | the machines of fragmentation | each is its table, held by a second, small program |
//! | [`frame_decode`] | identifiers, and the passive decoder on one frame | fields, line and JSON object agree |
//! | [`monitor`] | the passive decoder on a session | what it puts together was sent, what it pairs came before |
//! | [`net_dn`] | whole networks, with a tool, a UCMM and bus-off | who may be on line, who owns what, data from the owner only; undisturbed, every slave is served |
//! | [`net_nx`] | whole DeviceNeX networks, with a spare, a second manager, strangers, faults and segments | who may be on line with which address, who may say what; undisturbed, one manager works and what it plans runs |
//! | [`net_pl`] | whole POWERLINK networks | one frame for each invitation, nobody out of turn, outputs of the application only; undisturbed, every node is in operation |
//! | [`nx_manager`] | a DeviceNeX network manager | who gets which address, whom it asks for connections, what consumers are told; nothing off line, nothing stuck |
//! | [`nx_monitor`] | the passive decoder of DeviceNeX on a session | the same |
//! | [`nx_node`] | a DeviceNeX device | who is answered, what is sent when, one history of events; connectionless requests change nothing |
//! | [`pl_cn`] | a controlled node of POWERLINK | what is sent when, and what follows from what, held by a second, small program |
//! | [`pl_monitor`] | the passive decoder of POWERLINK on a session | what it counts and which states it tells, held by a second, small program |
//! | [`pl_wire`] | the frames of POWERLINK | the laws of the byte layouts |
//! | [`text`] | readers of recordings and scenarios | an error has its place; what was written is read back |
//! | [`wire`] | every wire type, paths, fragments, the bits of a frame | the laws of the byte layouts |
//!
//! Each target is one module with `pub fn run(data: &[u8])`, which panics when something does not hold; the file of that
//! name in `fuzz_targets` is one line. What bytes mean as frames and operations is in [`input`], apart from the oracles.
//! The committed seeds in `seeds/TARGET` run with `cargo test`; `cargo fuzz run TARGET` searches on from them:
//!
//! ```sh
//! mkdir -p fuzz/corpus/wire
//! cargo +nightly fuzz run wire fuzz/corpus/wire fuzz/seeds/wire -- -max_total_time=600 -max_len=512
//! ```

#![allow(
    clippy::arithmetic_side_effects,
    clippy::as_conversions,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used
)] // A panic is how an oracle says what it found, and an overflow in an oracle is a finding too.

pub mod bus_paths;
pub mod dn_access;
pub mod dn_master;
pub mod dn_slave;
pub mod dn_tool;
pub mod eds;
pub mod fragment;
pub mod frame_decode;
pub mod input;
pub mod monitor;
pub mod net_dn;
pub mod net_nx;
pub mod net_pl;
pub mod nx_manager;
pub mod nx_monitor;
pub mod nx_node;
mod passive;
pub mod pl_cn;
pub mod pl_monitor;
pub mod pl_wire;
mod plant;
mod readings;
pub mod text;
pub mod wire;

/// A fuzz target.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Its name: that of the module, of the file in `fuzz_targets` and of the folder in `seeds`.
    pub name: &'static str,
    /// Its body.
    pub run: fn(&[u8]),
}

/// Every target.
pub const TARGETS: &[Target] = &[
    Target { name: "bus_paths", run: bus_paths::run },
    Target { name: "dn_access", run: dn_access::run },
    Target { name: "dn_master", run: dn_master::run },
    Target { name: "dn_slave", run: dn_slave::run },
    Target { name: "dn_tool", run: dn_tool::run },
    Target { name: "eds", run: eds::run },
    Target { name: "fragment", run: fragment::run },
    Target { name: "frame_decode", run: frame_decode::run },
    Target { name: "monitor", run: monitor::run },
    Target { name: "net_dn", run: net_dn::run },
    Target { name: "net_nx", run: net_nx::run },
    Target { name: "net_pl", run: net_pl::run },
    Target { name: "nx_manager", run: nx_manager::run },
    Target { name: "nx_monitor", run: nx_monitor::run },
    Target { name: "nx_node", run: nx_node::run },
    Target { name: "pl_cn", run: pl_cn::run },
    Target { name: "pl_monitor", run: pl_monitor::run },
    Target { name: "pl_wire", run: pl_wire::run },
    Target { name: "text", run: text::run },
    Target { name: "wire", run: wire::run },
];
