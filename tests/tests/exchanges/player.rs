//! Plays an exchange: line by line, on the bus.

use core::time::Duration;

use devicenet_core::MacId;
use devicenet_core::access::MacIdSource;
use devicenet_core::slave::{Config, Options, Slave};
use devicenet_tests::block::Block;
use devicenet_tests::notation::{bytes, frame};
use link_core::{BitRate, Instant};

use crate::bus::Bus;
use crate::device::{Full, Odd, device};
use crate::host::Host;
use crate::script::{Exchange, spoken};

impl Exchange {
    /// Plays it; panics with the line that does not come true. Its trace.
    pub(crate) fn play(&self) -> String {
        let mut player = Player::new(self);
        for (number, line) in (1..).zip(&self.lines) {
            player.place = format!("{}, \"{}\", line {number}: {line}", self.file, self.name);
            player.line(line);
        }
        player.end()
    }

    /// Who else is on the bus.
    fn peers(&self) -> Vec<String> {
        let mut peers = vec!["4".to_owned()];
        for line in &self.lines {
            let line = line
                .strip_prefix("repeat ")
                .and_then(|rest| rest.split_once(": "))
                .map_or(&**line, |(_, line)| line);
            let line = line
                .strip_prefix("+ ")
                .and_then(|rest| rest.split_once(" ms "))
                .map_or(line, |(_, line)| line);
            if let Some(frame) = line.strip_prefix(">> ").or_else(|| line.strip_prefix("> ")) {
                peers.push(spoken(frame).0);
            }
        }
        peers.sort();
        peers.dedup();
        peers
    }
}

struct Player {
    peers: Vec<String>,
    bus: Option<Bus>,
    device: String,
    config: Config,
    place: String,
    /// The end of the last frame, or of the time that passed.
    mark: Instant,
    last_sent: Instant,
    /// Frames of the slave may wait while others are sent.
    overlapping: bool,
}

impl Player {
    fn new(exchange: &Exchange) -> Self {
        Self {
            peers: exchange.peers(),
            bus: None,
            device: "block".to_owned(),
            config: Config::new(&device(), MacId::DEFAULT),
            place: exchange.name.clone(),
            mark: Instant::ZERO,
            last_sent: Instant::ZERO,
            overlapping: false,
        }
    }

    fn line(&mut self, line: &str) {
        if let Some((times, line)) = line.strip_prefix("repeat ").and_then(|rest| rest.split_once(": ")) {
            for _ in 0..self.parse::<u32>(times) {
                self.line(line);
            }
            return;
        }
        let (word, rest) = line.split_once([' ', ':']).unwrap_or((line, ""));
        let rest = rest.trim_start_matches(':').trim();
        match word {
            "device" => self.device = rest.to_owned(),
            "option" => {
                let option = Options::from_name(rest).unwrap_or_else(|| panic!("{}: no option", self.place));
                self.config.options.toggle(option);
            }
            "config" => self.configure(rest),
            "start" => self.start(rest),
            ">" | ">>" => self.hears(rest, word == ">>"),
            "<" => self.sends(rest),
            "!" => {
                let place = self.place.clone();
                let told = &self.bus().log.told;
                assert!(told.iter().any(|told| told.contains(rest)), "{place}: told was {told:#?}");
            }
            "+" => self.passes(rest),
            "-" => {
                let span = self.millis(rest.trim_end_matches(" ms"));
                self.act(format!("clock set back by {} ms", span.as_millis()), |bus| {
                    bus.host(|host, _| host.behind += span);
                });
            }
            "slow" => {
                let reaction = self.millis(rest.trim_end_matches(" ms"));
                self.overlapping = !reaction.is_zero();
                self.act(format!("takes {} ms for a frame", reaction.as_millis()), |bus| bus.slow(reaction));
            }
            "spoil" => {
                let frames = self.parse(rest);
                self.act_now(format!("hears {frames} frames wrong"), |bus| {
                    bus.spoil(frames);
                    bus.settle();
                });
                self.mark = self.bus().now();
            }
            "link" => match rest {
                "up" => self.act("power on".to_owned(), Bus::up),
                "down" => self.act_now("cable unplugged".to_owned(), Bus::down),
                "restart" => self.act_now("controller restarted".to_owned(), Bus::restart_controller),
                _ => panic!("{}: no event", self.place),
            },
            "others" => {
                self.overlapping = rest == "off";
                self.bus().others(rest != "off");
            }
            "in" => self.act(format!("inputs {rest}"), |bus| {
                bus.host(|host, now| host.set_inputs(now, &bytes(rest)));
            }),
            "out" => {
                let place = self.place.clone();
                assert_eq!(self.bus().device().outputs(), bytes(rest), "{place}");
            }
            "lamp" => {
                let place = self.place.clone();
                assert_eq!(self.bus().device().lamp(), rest, "{place}");
            }
            _ => {}
        }
    }

    fn parse<T: core::str::FromStr>(&self, text: &str) -> T {
        text.trim().parse().unwrap_or_else(|_| panic!("{}: no number", self.place))
    }

    fn millis(&self, text: &str) -> Duration {
        let millis: f64 = self.parse(text);
        Duration::from_nanos((millis * 1e6).round() as u64)
    }

    fn bus(&mut self) -> &mut Bus {
        if self.bus.is_none() {
            self.start("online");
        }
        self.bus.as_mut().expect("it was started")
    }

    fn configure(&mut self, what: &str) {
        let config = &mut self.config;
        let (what, number) = what.rsplit_once(' ').unwrap_or((what, ""));
        match (what, number) {
            ("quick", "connect") => config.access.quick_connect = true,
            ("general", "failure") => config.failures.group_2_only_failure = true,
            ("path destination", "unknown") => config.failures.path_destination_unknown = true,
            ("switches", "") => {
                config.access.mac_id_source = MacIdSource::Switches;
                config.bit_rate.from_switches = true;
            }
            ("heartbeat", seconds) => config.heartbeat_interval = Some(seconds.parse().expect("seconds")),
            ("mac", number) => {
                config.access.mac_id = MacId::new(number.parse().expect("a number")).expect("a MAC ID");
            }
            _ => panic!("{}: no such configuration", self.place),
        }
    }

    /// Something is done to the slave: everything before it must have been looked at.
    fn act(&mut self, what: String, act: impl FnOnce(&mut Bus)) {
        self.nothing_more();
        self.act_now(what, act);
    }

    /// Also in the middle of a frame.
    fn act_now(&mut self, what: String, act: impl FnOnce(&mut Bus)) {
        let bus = self.bus();
        bus.log.told.clear();
        bus.log.note(bus.now(), what);
        act(bus);
    }

    /// Time passes: `320 ms`, and what stands behind it.
    fn passes(&mut self, rest: &str) {
        let (span, how) = rest.split_once(" ms").unwrap_or_else(|| panic!("{}: no time", self.place));
        let span = self.millis(span);
        self.nothing_more();
        let (mark, last_sent, place) = (self.mark, self.last_sent, self.place.clone());
        let bus = self.bus();
        bus.log.told.clear();
        let last_heard = bus.log.last_heard;
        let end = match how.trim() {
            "" => mark + span,
            "since >" => last_heard + span,
            "since <" => last_sent + span,
            "late" => {
                bus.log.note(bus.now(), "nobody looks at the clock");
                bus.host(|host, _| host.late = true);
                bus.run_until(mark + span);
                bus.host(|host, _| host.late = false);
                mark + span
            }
            how => {
                let frame = how.strip_prefix('>').unwrap_or_else(|| panic!("{place}: no time"));
                let end = last_heard + span;
                bus.run_until(bus.begin_of(&spoken(frame).1, end));
                self.hears(frame, false);
                assert_eq!(self.mark, end, "{place}: it cannot end then");
                return;
            }
        };
        assert!(end >= bus.now(), "{place}: it is over");
        bus.run_until(end);
        self.mark = end;
    }

    fn hears(&mut self, text: &str, only_wants: bool) {
        let (peer, frame) = spoken(text);
        self.nothing_more();
        self.overlapping |= only_wants;
        let bus = self.bus();
        bus.log.told.clear();
        if only_wants {
            bus.says(&peer, frame);
        } else {
            self.mark = bus.sends(&peer, frame);
        }
    }

    fn sends(&mut self, text: &str) {
        let place = self.place.clone();
        let sent = self.bus().next_sent();
        let found = sent.map(|sent| sent.frame.to_string());
        assert_eq!(found, Some(frame(text).to_string()), "{place}");
        let end = sent.expect("it was compared").end;
        (self.last_sent, self.mark) = (end, end);
    }

    #[track_caller]
    fn nothing_more(&mut self) {
        let place = self.place.clone();
        let overlapping = self.overlapping;
        let bus = self.bus();
        let waits = bus.log.slave_waits().filter(|_| !overlapping);
        let more = bus.log.sent.front().map(|sent| &sent.frame).or(waits).map(ToString::to_string);
        assert_eq!(more, None, "before {place}");
    }

    fn end(mut self) -> String {
        let bus = self.bus();
        bus.finish_peers();
        self.overlapping = false;
        self.nothing_more();
        let place = self.place.clone();
        let bus = self.bus();
        assert_eq!(bus.device().lost(), (0, 0), "{place}: events or answers were lost");
        bus.log.text()
    }

    fn start(&mut self, how: &str) {
        let host = self.host();
        let mut bus = Bus::new(BitRate::K125, host, self.peers.clone());
        let mut words = how.split_whitespace();
        let stage = words.next();
        if stage != Some("dark") {
            bus.up();
            bus.run_until(Instant::from_millis(2005));
            bus.all_sent();
            bus.log.forget();
            self.mark = bus.now();
        }
        self.bus = Some(bus);
        let Some(choice) = words.next() else { return };
        let group = 0x400 | u16::from(self.config.access.mac_id.number()) << 3;
        self.asks(&format!("{:03X}: 04 4B 03 01 {choice} 04", group | 6));
        for instance in words {
            self.asks(&format!("{:03X}: 04 10 05 0{instance} 09 50 00", group | 4));
        }
        self.bus().log.told.clear();
    }

    /// A step of the beginning, whose answers are not the subject.
    fn asks(&mut self, text: &str) {
        self.hears(text, false);
        while let Some(sent) = self.bus().next_sent() {
            (self.last_sent, self.mark) = (sent.end, sent.end);
        }
    }

    fn host(&self) -> Host {
        let config = self.config.clone();
        let short = [0x34, 0x12];
        let long: Vec<u8> = (1..=16).collect();
        let valid = "the sizes are valid";
        match self.device.as_str() {
            "block" => {
                Host::new(Slave::<_, 64, 0>::new(config, Block::<2, 1>::new(device(), short)).expect(valid))
            }
            "full" => Host::new(Slave::<_, 64, 0>::new(config, Full::new(&short, 1)).expect(valid)),
            "odd" => {
                let odd = Odd(Block::<2, 1>::new(device(), short));
                Host::new(Slave::<_, 64, 0>::new(config, odd).expect(valid))
            }
            "longest" => Host::new(Slave::<_, 64, 0>::new(config, Full::new(&short, 448)).expect(valid)),
            "long" => Host::new(Slave::<_, 64, 0>::new(config, Full::new(&long, 10)).expect(valid)),
            "seven" => Host::new(Slave::<_, 64, 0>::new(config, Full::new(&long[..14], 14)).expect(valid)),
            "ucmm" => Host::new(Slave::<_, 64, 3>::new(config, Full::new(&short, 1)).expect(valid)),
            "crowd" => Host::new(Slave::<_, 64, 16>::new(config, Full::new(&short, 1)).expect(valid)),
            other => panic!("{}: no device {other}", self.place),
        }
    }
}
