//! One client's side of the conversation, without socket and clock.

use core::time::Duration;

use link_core::{Frame, Id, Instant};

use super::broadcast::{Job, Subscription, received};
use super::message::{self, Command};

/// What a session wants done.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Effect {
    /// Write this to the client.
    Reply(String),
    /// Send this on the bus.
    Send(Frame),
    /// The client may not go on.
    Close,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Mode {
    /// No bus is open.
    NoBus,
    /// The client receives what it subscribed to, and may have frames sent in cycles.
    Bcm,
    /// The client receives everything.
    Raw,
    /// The client receives statistics only.
    Control,
}

/// What a client has said, and what it is to receive.
#[derive(Debug)]
pub(super) struct Session {
    /// The names of the buses that can be opened.
    channels: Vec<String>,
    /// The place of the open one in `channels`.
    channel: usize,
    mode: Mode,
    /// The beginning of a command whose end has not come.
    pending: Vec<u8>,
    jobs: Vec<Job>,
    subscriptions: Vec<Subscription>,
    statistics: Option<Statistics>,
    received: Count,
    sent: Count,
}

#[derive(Debug)]
struct Statistics {
    every: Duration,
    next: Instant,
}

#[derive(Clone, Copy, Debug, Default)]
struct Count {
    bytes: u64,
    frames: u64,
}

impl Count {
    fn add(&mut self, frame: &Frame) {
        self.frames += 1;
        self.bytes += frame.data().len() as u64;
    }
}

impl Session {
    /// What a server says first.
    pub(super) const GREETING: &'static str = "< hi >";

    pub(super) fn new(channels: Vec<String>) -> Self {
        Self {
            channels,
            channel: 0,
            mode: Mode::NoBus,
            pending: Vec::new(),
            jobs: Vec::new(),
            subscriptions: Vec::new(),
            statistics: None,
            received: Count::default(),
            sent: Count::default(),
        }
    }

    /// The bus that the client has opened, by its place in the list given to [`new`](Self::new).
    pub(super) fn channel(&self) -> Option<usize> {
        (self.mode != Mode::NoBus).then_some(self.channel)
    }

    /// Takes bytes of the client, in whatever pieces they come.
    pub(super) fn receive(&mut self, now: Instant, bytes: &[u8], effects: &mut Vec<Effect>) {
        for byte in bytes {
            match (self.pending.first(), byte) {
                (None, b'<') | (Some(b'<'), b'<') => {
                    self.pending.clear();
                    self.pending.push(b'<');
                }
                (None, byte) if byte.is_ascii_whitespace() => {}
                // Rubbish is reported once, and skipped up to the next command.
                (None, _) => {
                    effects.push(error("a command begins with <"));
                    self.pending.push(SKIPPING);
                }
                (Some(&SKIPPING), b'<') => {
                    self.pending.clear();
                    self.pending.push(b'<');
                }
                (Some(&SKIPPING), _) => {}
                (Some(_), b'>') => {
                    let text = core::mem::take(&mut self.pending);
                    self.command(now, &String::from_utf8_lossy(&text[1..]), effects);
                }
                (Some(_), _) if self.pending.len() == LONGEST_COMMAND => {
                    effects.push(error("the command is too long"));
                    self.pending.clear();
                    self.pending.push(SKIPPING);
                }
                (Some(_), byte) => self.pending.push(*byte),
            }
        }
    }

    /// A frame was on the bus. Not called for those of this client.
    pub(super) fn frame(&mut self, now: Instant, frame: &Frame, effects: &mut Vec<Effect>) {
        if self.mode != Mode::NoBus {
            self.received.add(frame);
        }
        match self.mode {
            Mode::NoBus | Mode::Control => {}
            Mode::Raw => effects.push(Effect::Reply(received(now, frame))),
            Mode::Bcm => {
                for subscription in self.subscriptions.iter_mut().filter(|item| item.id == frame.id()) {
                    subscription.take(now, frame, effects);
                }
            }
        }
    }

    /// An error frame was on the bus, of this SocketCAN class.
    pub(super) fn bus_error(&mut self, now: Instant, class: u32, effects: &mut Vec<Effect>) {
        if self.mode == Mode::Raw {
            effects.push(Effect::Reply(format!("< error {:08X} {now:.6} >", ERROR_FLAG | class)));
        }
    }

    /// When [`tick`](Self::tick) has something to do next.
    pub(super) fn deadline(&self) -> Option<Instant> {
        let jobs = self.jobs.iter().map(|job| job.next);
        let held = self.subscriptions.iter().filter_map(Subscription::due);
        jobs.chain(held).chain(self.statistics.as_ref().map(|statistics| statistics.next)).min()
    }

    /// Time has passed.
    pub(super) fn tick(&mut self, now: Instant, effects: &mut Vec<Effect>) {
        for job in self.jobs.iter_mut().filter(|job| job.next <= now) {
            effects.push(Effect::Send(job.frame));
            self.sent.add(&job.frame);
            // A server that fell behind sends once, not all that it missed.
            job.next = (job.next + job.every).max(now + Duration::from_nanos(1));
        }
        for subscription in &mut self.subscriptions {
            subscription.tick(now, effects);
        }
        if let Some(statistics) = self.statistics.as_mut().filter(|statistics| statistics.next <= now) {
            statistics.next = now + statistics.every;
            let (rx, tx) = (self.received, self.sent);
            let text = format!("< stat {} {} {} {} >", rx.bytes, rx.frames, tx.bytes, tx.frames);
            effects.push(Effect::Reply(text));
        }
    }

    fn command(&mut self, now: Instant, text: &str, effects: &mut Vec<Effect>) {
        match message::parse(text).and_then(|command| self.execute(now, command, effects)) {
            Ok(()) => {}
            Err(problem) => {
                effects.push(error(&problem));
                if text.trim_start().starts_with("open") && self.mode == Mode::NoBus {
                    effects.push(Effect::Close);
                }
            }
        }
    }

    fn execute(&mut self, now: Instant, command: Command, effects: &mut Vec<Effect>) -> Result<(), String> {
        let ok = Effect::Reply("< ok >".to_owned());
        match (self.mode, command) {
            (_, Command::Echo) => effects.push(Effect::Reply("< echo >".to_owned())),
            (Mode::NoBus, Command::Open { channel }) => {
                let found = self.channels.iter().position(|name| *name == channel);
                self.channel =
                    found.ok_or_else(|| format!("no such bus, there is {}", self.channels.join(", ")))?;
                self.mode = Mode::Bcm;
                effects.push(ok);
            }
            (_, Command::Open { .. }) => return Err("a bus is open".to_owned()),
            (Mode::NoBus, _) => return Err("no bus is open".to_owned()),
            (_, Command::RawMode) => {
                self.enter(Mode::Raw);
                effects.push(ok);
            }
            (_, Command::BcmMode) => {
                self.enter(Mode::Bcm);
                effects.push(ok);
            }
            (_, Command::ControlMode) => {
                self.enter(Mode::Control);
                effects.push(ok);
            }
            (Mode::Raw | Mode::Bcm, Command::Send(frame)) => {
                self.sent.add(&frame);
                effects.push(Effect::Send(frame));
            }
            (Mode::Control, Command::Statistics { every }) => {
                self.statistics = (!every.is_zero()).then(|| Statistics { every, next: now + every });
            }
            (Mode::Bcm, Command::Add { every, frame }) => self.add(now, every, frame, effects)?,
            (Mode::Bcm, Command::Update(frame)) => {
                let job = self.jobs.iter_mut().find(|job| job.frame.id() == frame.id());
                job.ok_or("nothing is sent with this identifier")?.frame = frame;
            }
            (Mode::Bcm, Command::Delete(id)) => {
                let before = self.jobs.len();
                self.jobs.retain(|job| job.frame.id() != id);
                if self.jobs.len() == before {
                    return Err("nothing is sent with this identifier".to_owned());
                }
            }
            (Mode::Bcm, Command::Subscribe { every, id }) => self.subscribe(every, id, None)?,
            (Mode::Bcm, Command::Filter { every, id, mask }) => self.subscribe(every, id, Some(mask))?,
            (Mode::Bcm, Command::Unsubscribe(id)) => self.subscriptions.retain(|item| item.id != id),
            (Mode::Raw | Mode::Bcm, Command::Statistics { .. }) => {
                return Err("statistics are for controlmode".to_owned());
            }
            (Mode::Raw | Mode::Control, _) => return Err("not in this mode, say bcmmode first".to_owned()),
        }
        Ok(())
    }

    /// What the broadcast manager did ends with its mode.
    fn enter(&mut self, mode: Mode) {
        self.mode = mode;
        self.jobs.clear();
        self.subscriptions.clear();
    }

    fn add(
        &mut self,
        now: Instant,
        every: Duration,
        frame: Frame,
        effects: &mut Vec<Effect>,
    ) -> Result<(), String> {
        self.jobs.retain(|job| job.frame.id() != frame.id());
        if !every.is_zero() {
            if self.jobs.len() == MOST_ENTRIES {
                return Err(format!("at most {MOST_ENTRIES} frames are sent in cycles"));
            }
            self.jobs.push(Job { frame, every, next: now + every });
        }
        self.sent.add(&frame);
        effects.push(Effect::Send(frame));
        Ok(())
    }

    fn subscribe(&mut self, every: Duration, id: Id, mask: Option<[u8; 8]>) -> Result<(), String> {
        self.subscriptions.retain(|item| item.id != id);
        if self.subscriptions.len() == MOST_ENTRIES {
            return Err(format!("at most {MOST_ENTRIES} subscriptions"));
        }
        self.subscriptions.push(Subscription::new(every, id, mask));
        Ok(())
    }
}

fn error(problem: &str) -> Effect {
    Effect::Reply(format!("< error {problem} >"))
}

/// Stands first in `pending` while rubbish is skipped; no command begins with it.
const SKIPPING: u8 = 0;
/// The longest is `add` with eight bytes.
const LONGEST_COMMAND: usize = 256;
const MOST_ENTRIES: usize = 256;
/// `CAN_ERR_FLAG` of linux/can.h.
const ERROR_FLAG: u32 = 0x2000_0000;

#[cfg(test)]
mod tests {
    use super::*;
    use link_core::frame::standard_id;

    struct Client(Session);

    impl Client {
        fn connected() -> Self {
            Self(Session::new(vec!["can0".to_owned(), "can1".to_owned()]))
        }

        fn open() -> Self {
            let mut client = Self::connected();
            assert_eq!(client.says("< open can0 >"), ["< ok >"]);
            client
        }

        #[track_caller]
        fn says(&mut self, text: &str) -> Vec<String> {
            let mut effects = Vec::new();
            self.0.receive(Instant::ZERO, text.as_bytes(), &mut effects);
            show(effects)
        }

        fn hears(&mut self, millis: u64, data: &[u8]) -> Vec<String> {
            let frame = Frame::new(standard_id(0x123), data).unwrap();
            let mut effects = Vec::new();
            self.0.frame(Instant::from_millis(millis), &frame, &mut effects);
            show(effects)
        }

        fn ticks(&mut self, millis: u64) -> Vec<String> {
            let mut effects = Vec::new();
            self.0.tick(Instant::from_millis(millis), &mut effects);
            show(effects)
        }
    }

    fn show(effects: Vec<Effect>) -> Vec<String> {
        let show = |effect| match effect {
            Effect::Reply(text) => text,
            Effect::Send(frame) => format!("sends {frame}"),
            Effect::Close => "closed".to_owned(),
        };
        effects.into_iter().map(show).collect()
    }

    #[test]
    fn raw_mode_gives_everything() {
        let mut client = Client::open();
        assert_eq!(client.hears(1, &[1]), [""; 0]);
        assert_eq!(client.says("< rawmode >"), ["< ok >"]);
        assert_eq!(client.hears(1_500, &[0x11, 0x02]), ["< frame 123 1.500000 1102 >"]);
        assert_eq!(client.hears(2_000, &[]), ["< frame 123 2.000000  >"]);
        assert_eq!(client.says("< send 123 3 1 f 33 >"), ["sends 123 [3] 01 0F 33"]);
        let mut effects = Vec::new();
        client.0.bus_error(Instant::from_millis(3), 0x8, &mut effects);
        assert_eq!(show(effects), ["< error 20000008 0.003000 >"]);
    }

    #[test]
    fn a_command_may_come_in_pieces_and_several_at_once() {
        let mut client = Client::connected();
        assert_eq!(client.says("< op"), [""; 0]);
        assert_eq!(client.says("en can1 >< rawmode ><echo>\r\n"), ["< ok >", "< ok >", "< echo >"]);
        assert_eq!(client.0.channel(), Some(1));
    }

    #[test]
    fn a_bad_client_is_told_and_goes_on() {
        let mut client = Client::open();
        assert_eq!(client.says("hello < echo >"), ["< error a command begins with < >", "< echo >"]);
        assert_eq!(client.says("< send 123 1 xx >"), ["< error xx is not a byte >"]);
        assert_eq!(client.says("< \u{e9} >"), ["< error unknown command  >"]);
        assert_eq!(client.says("< open can0 >"), ["< error a bus is open >"]);
        let long = format!("< {} >", "x".repeat(10_000));
        assert_eq!(client.says(&long), ["< error the command is too long >"]);
        assert_eq!(client.says("< statistics 10 >"), ["< error statistics are for controlmode >"]);
        assert_eq!(client.says("< echo >"), ["< echo >"]);
    }

    #[test]
    fn a_bus_that_does_not_exist_ends_the_conversation() {
        let mut client = Client::connected();
        assert_eq!(client.says("< rawmode >"), ["< error no bus is open >"]);
        assert_eq!(client.says("< open vcan9 >"), ["< error no such bus, there is can0, can1 >", "closed"]);
    }

    #[test]
    fn cyclic_frames_are_sent_until_deleted() {
        let mut client = Client::open();
        assert_eq!(client.says("< add 0 20000 123 1 42 >"), ["sends 123 [1] 42"]);
        assert_eq!(client.0.deadline(), Some(Instant::from_millis(20)));
        assert_eq!(client.ticks(19), [""; 0]);
        assert_eq!(client.ticks(20), ["sends 123 [1] 42"]);
        assert_eq!(client.says("< update 123 1 43 >"), [""; 0]);
        assert_eq!(client.ticks(100), ["sends 123 [1] 43"]);
        assert_eq!(client.says("< delete 123 >"), [""; 0]);
        assert_eq!(client.0.deadline(), None);
        assert_eq!(client.says("< delete 123 >"), ["< error nothing is sent with this identifier >"]);
    }

    #[test]
    fn a_subscription_throttles_and_keeps_the_newest() {
        let mut client = Client::open();
        assert_eq!(client.says("< subscribe 0 100000 123 >"), [""; 0]);
        assert_eq!(client.hears(10, &[1]), ["< frame 123 0.010000 01 >"]);
        assert_eq!(client.hears(20, &[2]), [""; 0]);
        assert_eq!(client.hears(30, &[3]), [""; 0]);
        assert_eq!(client.0.deadline(), Some(Instant::from_millis(110)));
        assert_eq!(client.ticks(110), ["< frame 123 0.110000 03 >"]);
    }

    #[test]
    fn a_filter_passes_what_has_changed_under_its_mask() {
        let mut client = Client::open();
        assert_eq!(client.says("< filter 0 0 123 2 00 F0 >"), [""; 0]);
        assert_eq!(client.hears(1, &[1, 0x10]).len(), 1);
        assert_eq!(client.hears(2, &[2, 0x1F]).len(), 0);
        assert_eq!(client.hears(3, &[2, 0x20]).len(), 1);
        assert_eq!(client.says("< unsubscribe 123 >"), [""; 0]);
        assert_eq!(client.hears(4, &[2, 0x30]).len(), 0);
    }

    #[test]
    fn statistics_come_in_their_interval() {
        let mut client = Client::open();
        assert_eq!(client.says("< send 123 2 1 2 >").len(), 1);
        client.hears(1, &[1, 2, 3]);
        assert_eq!(client.says("< controlmode >< statistics 1000 >"), ["< ok >"]);
        assert_eq!(client.ticks(1_000), ["< stat 3 1 2 1 >"]);
        assert_eq!(client.says("< statistics 0 >"), [""; 0]);
        assert_eq!(client.0.deadline(), None);
    }
}
