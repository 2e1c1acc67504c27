//! A slave on the simulated bus, among nodes that say what an exchange has them say.

use core::time::Duration;
use std::collections::VecDeque;

use devicenet_core::slave;
use link_core::{BitRate, Frame, Instant};
use transport_mock::nodes::External;
use transport_mock::{
    BusConfig, Change, Fault, FaultId, Network, NodeConfig, NodeId, Reaction, Record, Scope,
};

use crate::host::{Device, Host};
use crate::log::Log;

/// What the slave tells; the others have nothing to tell.
#[derive(Clone, Debug)]
pub(crate) struct Told(pub(crate) slave::Event);

impl From<slave::Event> for Told {
    fn from(event: slave::Event) -> Self {
        Self(event)
    }
}

/// A frame of the slave that was sent to its end.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Sent {
    pub(crate) asked: Instant,
    pub(crate) end: Instant,
    pub(crate) frame: Frame,
}

pub(crate) struct Bus {
    network: Network<Told>,
    slave: NodeId,
    /// By name.
    peers: Vec<(String, NodeId)>,
    bit: Duration,
    pub(crate) log: Log,
}

impl Bus {
    /// The slave without power, and the others with it.
    pub(crate) fn new(bit_rate: BitRate, host: Host, peers: impl IntoIterator<Item = String>) -> Self {
        let config = BusConfig { strict: true, shared: None, ..BusConfig::new(bit_rate, 1) };
        let mut network = Network::new(config);
        let slave = network.add(NodeConfig { power_up: None, ..NodeConfig::named("slave") }, host);
        let peers: Vec<(String, NodeId)> = peers
            .into_iter()
            .map(|name| {
                let id = network.add_silent(NodeConfig::named(name.as_str()), External::<()>::new());
                (name, id)
            })
            .collect();
        let names = network.nodes().map(|node| network.name(node).to_owned()).collect();
        let bit = Duration::from_nanos(bit_rate.bit_time_nanos().expect("a rate of DeviceNet"));
        let mut bus = Self { network, slave, peers, bit, log: Log::new(slave, names, 3 * bit) };
        bus.run_until(Instant::ZERO);
        bus
    }

    pub(crate) fn now(&self) -> Instant {
        self.network.now()
    }

    pub(crate) fn run_until(&mut self, end: Instant) {
        let log = &mut self.log;
        self.network.run_until(end, &mut |record: &Record<'_, Told>| log.record(record));
    }

    /// The slave gets power, or its cable.
    pub(crate) fn up(&mut self) {
        let change = if self.network.is_powered(self.slave) { Change::Plug } else { Change::PowerOn };
        self.change(change(self.slave));
    }

    /// The cable of the slave is unplugged.
    pub(crate) fn down(&mut self) {
        self.change(Change::Cut(self.slave));
    }

    /// The cables of all others are plugged, or unplugged.
    pub(crate) fn others(&mut self, plugged: bool) {
        for at in 0..self.peers.len() {
            let node = self.peers[at].1;
            self.change(if plugged { Change::Plug(node) } else { Change::Cut(node) });
        }
    }

    /// The controller of the slave starts anew, and gives back what waits in it.
    pub(crate) fn restart_controller(&mut self) {
        self.change(Change::SetBitRate(self.slave, self.network.mode(self.slave).bit_rate));
    }

    /// From now on the slave takes so long from an input to what follows from it.
    pub(crate) fn slow(&mut self, reaction: Duration) {
        self.change(Change::SetReaction(self.slave, Reaction::Fixed(reaction)));
    }

    /// What the slave hears of the next frames is wrong in one bit of their data.
    pub(crate) fn spoil(&mut self, frames: u32) {
        for frame in 0..frames {
            let scope = Scope::Node(self.slave);
            let fault = Fault::FlipBit { frame: frame.into(), bit: SPOILT_BIT, scope };
            self.change(Change::FaultOn(FaultId(frame), fault));
        }
    }

    fn change(&mut self, change: Change<Told>) {
        self.network.apply(change);
        self.run_until(self.now());
    }

    /// Whatever is done to the slave without the bus.
    pub(crate) fn host(&mut self, act: impl FnOnce(&mut Host, Instant)) {
        self.network.command(self.slave, act).expect("the slave has power");
        self.run_until(self.now());
    }

    pub(crate) fn device(&self) -> &dyn Device {
        let host: &Host = self.network.machine(self.slave).expect("it is the slave");
        &*host.device
    }

    /// A peer wants to send a frame.
    #[track_caller]
    pub(crate) fn says(&mut self, peer: &str, frame: Frame) {
        let (_, node) = self.peers.iter().find(|(name, _)| name == peer).expect("the node is there");
        let inject = |peer: &mut External<()>, now| {
            while peer.take().is_some() {}
            peer.inject(now, (), frame)
        };
        self.network.command(*node, inject).expect("it has power").expect("there is room");
        self.run_until(self.now());
    }

    /// A peer sends a frame. The end of it.
    #[track_caller]
    pub(crate) fn sends(&mut self, peer: &str, frame: Frame) -> Instant {
        self.says(peer, frame);
        self.finish_peers();
        self.log.last_heard
    }

    /// Until what the peers want to send was sent.
    #[track_caller]
    pub(crate) fn finish_peers(&mut self) {
        let limit = self.now() + PATIENCE;
        while self.log.peers_wait() {
            assert!(self.now() < limit, "what a peer sends does not get through:\n{}", self.log.text());
            self.run_until(self.now() + self.bit);
        }
    }

    /// The moment at which a frame must begin so that it ends at another.
    pub(crate) fn begin_of(&self, frame: &Frame, end: Instant) -> Instant {
        end.saturating_sub(self.bit * frame.bit_len())
    }

    /// The next frame that the slave sends, if it wants to send one.
    #[track_caller]
    pub(crate) fn next_sent(&mut self) -> Option<Sent> {
        self.settle();
        self.log.sent.pop_front()
    }

    /// Until the slave has sent something, or gives up.
    #[track_caller]
    pub(crate) fn settle(&mut self) {
        let limit = self.now() + PATIENCE;
        while self.log.sent.is_empty() && self.log.slave_waits().is_some() {
            assert!(self.now() < limit, "what the slave sends does not get through:\n{}", self.log.text());
            self.run_until(self.now() + self.bit);
        }
    }

    /// Every frame of the slave that nobody has looked at.
    pub(crate) fn all_sent(&mut self) -> VecDeque<Sent> {
        core::mem::take(&mut self.log.sent)
    }
}

/// In the data of a frame with some.
const SPOILT_BIT: u32 = 30;
/// Longer than any frame waits.
const PATIENCE: Duration = Duration::from_secs(10);
