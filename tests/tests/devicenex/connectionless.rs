//! Without a connection a device can be asked, and not changed.

use std::time::Duration;

use devicenex_core::Identifier;
use devicenex_core::device::DeviceEvent;
use devicenex_core::id::{Direction, Framing, Route};
use devicenex_core::message::{MiniWho, Roam};
use link_core::{Action, Frame, Input, Instant, LinkCommand, LinkEvent, Machine, TxOutcome};

use super::block::{Node, node};
use super::plant::{device, oa};

/// Every service but one, of every object that a device has, with and without data: refused with 0x08, and nothing is
/// another than before.
#[test]
fn every_service_but_get_attribute_single_is_refused_without_a_connection() {
    let mut rig = Rig::on_line();
    let before = rig.picture();
    let mut refused = 0;
    for service in (0..0x80_u8).filter(|service| *service != 0x0E) {
        for class in [0x01, 0x02, 0x03, 0x05, 0x2B] {
            for rest in [&[][..], &[1], &[1, 1], &[1, 1, 67], &[1, 3, 1, 0]] {
                let body: Vec<u8> = [service, class].iter().chain(rest).copied().collect();
                // Without an instance it is no request to an object.
                let answer = rig.ask(&body);
                if rest.is_empty() {
                    continue;
                }
                // Profile, section on connectionless messages: 0x94, service not supported, no additional code.
                assert_eq!(answer, [[0x94, 0x08, 0xFF]], "{body:02X?}");
                refused += 1;
            }
        }
    }
    assert_eq!(refused, 127 * 5 * 4);
    assert_eq!(rig.picture(), before);
    assert!(rig.node.access().is_online());
}

/// The one that is allowed reads, and changes nothing either.
#[test]
fn every_attribute_can_be_read_and_nothing_changes() {
    let mut rig = Rig::on_line();
    let before = rig.picture();
    let mut read = 0;
    for class in 0..=0x30 {
        for attribute in 0..=20 {
            for answer in rig.ask(&[0x0E, class, 1, attribute]) {
                read += usize::from(answer[0] != 0x94);
            }
        }
    }
    assert!(read > 12, "{read}");
    assert_eq!(rig.picture(), before);
}

/// A device that is told by hand, and what it sent.
struct Rig {
    node: Node,
    now: Instant,
    sent: Vec<Frame>,
}

impl Rig {
    fn on_line() -> Self {
        let mut rig = Self { node: node(SERIAL), now: Instant::ZERO, sent: Vec::new() };
        rig.tell(Input::Link(LinkEvent::Up));
        rig.wait_until(|node| node.access().state().kind() == devicenex_core::access::StateKind::Standby);
        rig.tell(Input::Frame(Roam { target: device(SERIAL), requested: oa(67) }.frame().unwrap()));
        rig.wait_until(|node| node.access().is_online());
        rig.sent.clear();
        rig
    }

    fn wait_until(&mut self, is_so: impl Fn(&Node) -> bool) {
        while !is_so(&self.node) {
            self.now = self.node.deadline().unwrap().at;
            self.tell(Input::Tick);
        }
    }

    fn tell(&mut self, input: Input) {
        let mini_who = MiniWho { serial_low: 1 }.frame().unwrap();
        let mut inputs = vec![input];
        while let Some(input) = inputs.pop() {
            for action in self.node.handle(self.now, input) {
                match action {
                    Action::Transmit(token, frame) => {
                        self.sent.push(frame);
                        inputs.push(Input::TxDone(token, TxOutcome::Sent));
                    }
                    Action::Link(LinkCommand::SetMode(mode)) => {
                        if mode.listen_only {
                            inputs.extend([Input::Frame(mini_who); 2]);
                        }
                        inputs.push(Input::Link(LinkEvent::ModeSet(mode)));
                    }
                    Action::Event(event) => assert!(!matches!(event, DeviceEvent::Reset(_))),
                    Action::Withdraw(_) | Action::Link(_) => {}
                }
            }
        }
    }

    /// Asks from OA 1, and returns the answers.
    fn ask(&mut self, body: &[u8]) -> Vec<Vec<u8>> {
        let route = Route { destination: oa(67), direction: Direction::Request, source: oa(1) };
        let id = Identifier::connectionless(route, Framing::Complete { transaction: 5 });
        self.tell(Input::Frame(id.frame(body).unwrap()));
        let answers = core::mem::take(&mut self.sent);
        // A response in fragments is given up when nobody acknowledges it.
        for _ in 0..3 {
            self.now += Duration::from_secs(2);
            self.tell(Input::Tick);
        }
        self.sent.clear();
        answers.iter().map(|frame| frame.data().to_vec()).collect()
    }

    /// All that a request could change.
    fn picture(&self) -> String {
        let access = self.node.access();
        format!(
            "{:?} {:?} {:?} {:?} {} {}",
            self.node.application(),
            self.node.connections().collect::<Vec<_>>(),
            access.address(),
            access.bus_off_interrupt(),
            access.hello_wait(),
            access.bus_off_counter()
        )
    }
}

const SERIAL: u32 = 0x1122_3344;
