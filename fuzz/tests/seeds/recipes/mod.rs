//! What the seeds are made of: vectors from manuals, captures, and scripts by hand.

mod buses;
mod controlled_node;
mod device;
mod files;
mod frames;
mod machines;
mod powerlink;
mod slave;

use std::path::{Path, PathBuf};

use devicenet_cli::recording::{Content, Recording};
use link_core::{Frame, Instant};

type Seeds = Vec<(String, Vec<u8>)>;

/// The seeds of a target, by name.
pub(crate) fn of(target: &str) -> Seeds {
    match target {
        "bus_paths" => buses::bus_paths(),
        "dn_access" => machines::dn_access(),
        "dn_slave" => slave::dn_slave(),
        "eds" => files::eds(),
        "fragment" => slave::fragment(),
        "dn_master" => machines::dn_master(),
        "dn_tool" => machines::dn_tool(),
        "frame_decode" => frames::frame_decode(),
        "monitor" => frames::monitor(),
        "net_dn" => buses::net_dn(),
        "net_nx" => buses::net_nx(),
        "net_pl" => powerlink::net_pl(),
        "nx_manager" => machines::nx_manager(),
        "nx_monitor" => frames::nx_monitor(),
        "nx_node" => device::nx_node(),
        "pl_cn" => controlled_node::pl_cn(),
        "pl_monitor" => powerlink::pl_monitor(),
        "pl_wire" => controlled_node::pl_wire(),
        "text" => files::text(),
        "wire" => frames::wire(),
        other => panic!("no recipes for {other}"),
    }
}

fn capture(name: &str) -> impl Iterator<Item = (Instant, Frame)> + use<> {
    let recording = Recording::open(&captures().join(name)).unwrap();
    recording.map(Result::unwrap).filter_map(|recorded| match recorded.content {
        Content::Classic(frame) => Some((recorded.at, frame)),
        Content::Error(_) | Content::Fd(_) => None,
    })
}

fn captures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/captures")
}
