//! A controlled node with a byte each way.

use core::convert::Infallible;
use core::ops::ControlFlow;
use core::time::Duration;
use std::io::Write as _;
use std::process::ExitCode;

use link_core::codec::Writer;
use link_core::ethernet::{Port as _, drive};
use powerlink_core::dictionary::{Access, Device, Entry, Mappable, ObjectAddress, ObjectSet, ObjectType};
use powerlink_core::ethernet::{ETHERTYPE, group};
use powerlink_core::nmt::NmtState;
use powerlink_core::node::{Config, DefaultMapping, NodeEvent};
use powerlink_core::pdo::MappingEntry;
use powerlink_core::wire::{AbortCode, Identity};
use powerlink_core::{ControlledNode, NodeId};
use transport_ethernet::{EthernetPort, Options};

struct Io {
    output: u8,
}

impl ObjectSet for Io {
    const ENTRIES: &'static [Entry] = &[
        Entry::new(0x6000, 1, "input", ObjectType::Unsigned(1), Access::ReadOnly).mapped(Mappable::Transmit),
        Entry::new(0x6200, 1, "output", ObjectType::Unsigned(1), Access::ReadWrite).mapped(Mappable::Receive),
    ];

    fn read(&self, _: ObjectAddress, out: &mut Writer<'_>) -> Result<(), AbortCode> {
        out.u8(self.output).map_err(|_| AbortCode::OUT_OF_MEMORY)
    }

    fn write(&mut self, _: ObjectAddress, data: &[u8]) -> Result<(), AbortCode> {
        self.output = *data.first().ok_or(AbortCode::LENGTH)?;
        Ok(())
    }

    fn restore(&mut self) {}
}

const fn byte(index: u16) -> MappingEntry {
    MappingEntry { object: ObjectAddress::new(index, 1), offset: 0, length: 8 }
}

pub(crate) fn run(interface: &str) -> ExitCode {
    let groups = &[group::SOC, group::SOA, group::ASND];
    let options = Options { groups, answer_within: Some(Duration::from_secs(1)), ..Options::new(ETHERTYPE) };
    let mut port = EthernetPort::open(interface, options).expect("the interface");
    let identity = Identity { vendor_id: 0, product_code: 0, revision: 0, serial_number: 0 };
    let mut config =
        Config::new(NodeId(1), port.interface().mac(), Device::new(identity)).expect("a configuration");
    config.mapping =
        DefaultMapping { receive: const { &[byte(0x6200)] }, transmit: const { &[byte(0x6000)] } };
    let mut node: ControlledNode<Io> = ControlledNode::new(config, Io { output: 0 }).expect("a node");
    node.power_on(port.now());
    let ended: Result<Infallible, _> = drive(&mut node, &mut port, |_, _, event| {
        if matches!(event, NodeEvent::StateChanged { to: NmtState::NotActive, .. }) {
            println!("ready");
            std::io::stdout().flush().expect("a pipe");
        }
        ControlFlow::Continue(())
    });
    let Err(error) = ended;
    panic!("{error}");
}
