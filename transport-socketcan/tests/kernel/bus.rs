//! The run loop over a port.

use core::ops::ControlFlow;
use core::time::Duration;

use link_core::timers::TimerKey;
use link_core::{Action, Deadline, Input, Instant, LinkEvent, Machine, Timers, TxToken, drive};

use crate::rig::{Interface, frame};

/// Sends a frame every ten milliseconds once the link is up, and counts those of others.
struct Beacon {
    id: u16,
    timers: Timers<Beat, 1>,
    due: bool,
    beats: usize,
    heard: usize,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash)]
struct Beat;
impl TimerKey<1> for Beat {
    const ALL: [Self; 1] = [Self];
    const WHY: [&'static str; 1] = ["the next beat"];
    fn index(self) -> usize {
        0
    }
}

impl Machine for Beacon {
    type Event = ();

    fn input(&mut self, now: Instant, input: Input) {
        let now = self.timers.advance(now);
        match input {
            Input::Link(LinkEvent::Up) => self.due = true,
            Input::TxDone(..) => self.timers.set(Beat, now + Duration::from_millis(10)),
            Input::Frame(_) => self.heard += 1,
            Input::Tick | Input::Link(_) => {}
        }
        self.due |= self.timers.take_expired(now).is_some();
    }

    fn poll(&mut self, _: Instant) -> Option<Action<()>> {
        if !core::mem::take(&mut self.due) {
            return None;
        }
        self.beats += 1;
        if self.beats > 20 {
            return Some(Action::Event(()));
        }
        Some(Action::Transmit(TxToken(0), frame(self.id, &[])))
    }

    fn deadline(&self) -> Option<Deadline> {
        self.timers.next()
    }

    fn max_in_flight(&self) -> usize {
        1
    }
}

impl Beacon {
    fn new(id: u16) -> Self {
        Self { id, timers: Timers::new(), due: false, beats: 0, heard: 0 }
    }
}

#[test]
#[ignore = "needs vcan"]
fn two_machines_on_one_bus() {
    let _bus = Interface::new("vcan50");
    let run = |id: u16| {
        let mut port = transport_socketcan::SocketCanPort::open("vcan50").unwrap();
        let mut beacon = Beacon::new(id);
        drive(&mut beacon, &mut port, |_, _, ()| ControlFlow::Break(())).unwrap();
        beacon.heard
    };
    let heard = std::thread::scope(|scope| {
        let other = scope.spawn(move || run(0x100));
        [run(0x200), other.join().unwrap()]
    });
    // They begin and end within a few beats of one another.
    assert!(heard.iter().all(|heard| (10..=20).contains(heard)), "{heard:?}");
}

#[cfg(feature = "tokio")]
#[test]
#[ignore = "needs vcan"]
fn many_machines_in_one_thread() {
    let bus = Interface::new("vcan51");
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let run = async |id: u16| {
        let port = transport_socketcan::SocketCanPort::open("vcan51").unwrap();
        let mut port = transport_socketcan::TokioPort::new(port).unwrap();
        let mut beacon = Beacon::new(id);
        transport_socketcan::drive(&mut beacon, &mut port, |_, _, ()| ControlFlow::Break(())).await.unwrap();
        beacon.heard
    };
    let flap = async {
        tokio::time::sleep(Duration::from_millis(50)).await;
        bus.set("down");
        bus.set("up");
    };
    let heard = runtime.block_on(async { tokio::join!(run(0x100), run(0x200), run(0x300), flap) });
    let heard = [heard.0, heard.1, heard.2];
    assert!(heard.iter().all(|heard| *heard >= 10), "{heard:?}");
}

/// The runtime may come back to a port late.
#[cfg(feature = "tokio")]
#[test]
#[ignore = "needs vcan"]
fn a_frame_that_waits_in_the_socket_comes_before_the_deadline() {
    use link_core::Port as _;
    let bus = Interface::new("vcan52");
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let mut port = transport_socketcan::TokioPort::new(bus.port()).unwrap();
        let mut other = bus.port();
        let deadline = Some(Deadline { at: port.port().now() + Duration::from_millis(10), why: "the test" });
        assert_eq!(port.wait(deadline).await.unwrap().1, Input::Tick);
        other.transmit(TxToken(0), frame(0x100, &[])).unwrap();
        assert_eq!(port.wait(deadline).await.unwrap().1, Input::Frame(frame(0x100, &[])));
        assert_eq!(port.wait(deadline).await.unwrap().1, Input::Tick);
    });
}
