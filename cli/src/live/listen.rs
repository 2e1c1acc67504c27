//! Listening before talking: who is there, and whose.

use std::collections::BTreeSet;

use devicenet_core::MacId;
use devicenet_core::monitor::{Kind, Monitor, MonitorConfig, NodeRecord, Reading};
use link_core::machine::Deadline;
use link_core::{Input, Instant, LinkEvent, Port};

use super::port::PortError;
use crate::exit::Failure;

/// What was heard.
pub(super) struct Heard {
    monitor: Box<Monitor>,
    /// Frames.
    pub(super) frames: u64,
    /// Errors on the bus.
    pub(super) errors: u64,
    /// Who has I/O with a master, be it only the half of it that was heard.
    slaves: BTreeSet<MacId>,
    link: Link,
}

/// Whether the interface takes part in the bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Link {
    Up,
    Down,
    BusOff,
}

impl Heard {
    pub(super) fn new() -> Self {
        let monitor = Box::new(Monitor::new(MonitorConfig::default()));
        Self { monitor, frames: 0, errors: 0, slaves: BTreeSet::new(), link: Link::Down }
    }

    /// Takes note of an input.
    pub(super) fn note(&mut self, at: Instant, input: Input) {
        match input {
            Input::Frame(frame) => {
                self.frames += 1;
                let reading = self.monitor.observe(at, self.frames, &frame);
                self.slaves.extend(slave(&reading));
            }
            Input::Link(LinkEvent::BusError(_)) => self.errors += 1,
            Input::Link(LinkEvent::Up) => self.link = Link::Up,
            Input::Link(LinkEvent::Down) => self.link = Link::Down,
            Input::Link(LinkEvent::BusOff) => self.link = Link::BusOff,
            Input::Link(_) | Input::TxDone(..) | Input::Tick => {}
        }
    }

    /// Listens until a moment, or for as long as there is something to hear.
    pub(super) fn listen(
        &mut self,
        port: &mut impl Port<Error = PortError>,
        until: Instant,
    ) -> Result<(), Failure> {
        let deadline = Some(Deadline { at: until, why: "listening" }).filter(|_| until < Instant::MAX);
        loop {
            match port.wait(deadline) {
                Ok((_, Input::Tick)) | Err(PortError::Over) => return Ok(()),
                Ok((at, input)) => {
                    self.note(at, input);
                    // On a bus that is faster than this program there is always one more.
                    if at > until {
                        return Ok(());
                    }
                }
                Err(PortError::Failed(failure)) => return Err(failure),
            }
        }
    }

    pub(super) const fn link(&self) -> Link {
        self.link
    }

    pub(super) fn node(&self, mac: MacId) -> Option<NodeRecord> {
        self.monitor.node(mac)
    }

    /// Every node that has sent something, in the order of the MAC IDs.
    pub(super) fn nodes(&self) -> impl Iterator<Item = NodeRecord> {
        self.monitor.nodes().filter(|node| node.traffic.first_seen().is_some())
    }

    /// Another master that has the node, or `None` in its place if it is not known who sends it its data.
    pub(super) fn master_of(&self, mac: MacId) -> Option<Option<MacId>> {
        let master = self.node(mac).and_then(|node| node.master);
        if master.is_some() || self.slaves.contains(&mac) { Some(master) } else { None }
    }
}

/// The slave that a frame of I/O comes from or goes to. A strobe or a multicast poll is for several.
fn slave(reading: &Reading<'_>) -> Option<MacId> {
    match reading.kind {
        Kind::PollCommand
        | Kind::PollResponse
        | Kind::BitStrobeResponse
        | Kind::MulticastPollResponse
        | Kind::CosCyclic
        | Kind::CosCyclicAck => {
            // In the predefined connection set a slave produces in Group 1, and consumes in Group 2.
            if reading.group == Some(1) { reading.src } else { reading.dst }
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::time::Duration;
    use link_core::frame::standard_id;
    use link_core::{Frame, LinkCommand, TxToken};

    /// A bus on which the next frame is there already, whenever it is asked.
    struct Crowded(Instant);

    impl Port for Crowded {
        type Error = PortError;

        fn now(&mut self) -> Instant {
            self.0
        }

        fn transmit(&mut self, _: TxToken, _: Frame) -> Result<(), PortError> {
            Ok(())
        }

        fn withdraw(&mut self, _: TxToken) -> Result<(), PortError> {
            Ok(())
        }

        fn command(&mut self, _: LinkCommand) -> Result<(), PortError> {
            Ok(())
        }

        fn wait(&mut self, _: Option<Deadline>) -> Result<(Instant, Input), PortError> {
            self.0 += Duration::from_millis(1);
            let frame = Frame::new(standard_id(0x455), &[]).unwrap();
            if self.0 < Instant::from_millis(1_000) {
                Ok((self.0, Input::Frame(frame)))
            } else {
                Err(PortError::Over)
            }
        }
    }

    #[test]
    fn listening_ends_on_a_bus_that_is_never_silent() {
        let mut heard = Heard::new();
        heard.listen(&mut Crowded(Instant::ZERO), Instant::from_millis(10)).unwrap();
        assert_eq!(heard.frames, 11);
    }

    fn heard(frames: &[(u16, &[u8])]) -> Heard {
        let mut heard = Heard::new();
        for (n, (id, data)) in (0..).zip(frames) {
            let frame = Frame::new(standard_id(*id), data).unwrap();
            heard.note(Instant::from_millis(n), Input::Frame(frame));
        }
        heard
    }

    /// Identifiers of the predefined connection set (CIP Vol. 3, chapter 3), for a slave with MAC ID 10.
    #[test]
    fn half_of_the_io_shows_that_a_slave_has_a_master() {
        for (id, what) in [
            (0x455, "poll command"),
            (0x3CA, "poll response"),
            (0x38A, "bit-strobe response"),
            (0x30A, "multicast poll response"),
            (0x34A, "change of state"),
            (0x452, "its acknowledge"),
        ] {
            assert_eq!(heard(&[(id, &[1])]).master_of(mac(10)), Some(None), "{what}");
        }
        assert_eq!(heard(&[(0x457, &[0, 0x34, 0x12, 1, 0, 0, 0])]).master_of(mac(10)), None, "a check");
    }

    #[test]
    fn who_is_sent_a_change_of_state_is_no_slave() {
        // Allocate explicit, change of state, without acknowledge; then the slave produces.
        let heard = heard(&[(0x456, &[1, 0x4B, 3, 1, 0x51, 1]), (0x453, &[1, 0xCB, 0]), (0x34A, &[0x55])]);
        assert_eq!(heard.master_of(mac(10)), Some(Some(mac(1))));
        assert_eq!(heard.master_of(mac(1)), None);
    }

    fn mac(number: u8) -> MacId {
        MacId::new(number).unwrap()
    }
}
