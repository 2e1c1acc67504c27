//! The exchanges of `tests/exchanges`: what their lines mean, and that they come true.
//!
//! | Line | Meaning |
//! |---|---|
//! | `# Name` | an exchange begins |
//! | `fault: words` | it is a row of the fault matrix; the words say what must hold |
//! | `device: block`, `full`, `long`, `seven`, `ucmm` | two bytes in and one out by poll; by all connections; 16 in and 10 out; 14 each way; with three connections of the UCMM |
//! | `option: NAME` | an option is turned over |
//! | `start: dark`, `online`, `allocated 03`, `established 03 2 3` | without power; on line; this choice allocated to master 4; and the EPR of these instances 80 ms |
//! | `> 5FC: 04 0E 01 01 01` | the slave hears a frame |
//! | `< 5FB: 04 8E E7 03` | it sends this frame next; no other |
//! | `! words` | it has told this since the last line that did something |
//! | `+ 320 ms`, `+ 60000 ms late`, `+ 1 ms unnoticed` | time passes; in one step; and nobody calls the slave |
//! | `- 10 ms` | the clock steps back |
//! | `hold`, `sent`, `dropped`, `go on` | frames stay in flight; the first one is sent, or given back; every frame is sent at once |
//! | `link: up`, `down`, `bus-off` | below the frame |
//! | `in: 01 02`, `out: 01` | the inputs become, the outputs of poll are |
//! | `lamp: flashing red` | the network status indicator shows |
//! | `repeat 3: > 5FD: 01` | the same line several times |
//!
//! Everything else is a comment.

use devicenet_core::MacId;
use devicenet_core::monitor::{Monitor, MonitorConfig};
use devicenet_core::slave::{Config, Options};
use link_core::{LinkEvent, TxOutcome};

use crate::bench::{Bench, Tester, bytes, frame};
use crate::device::{Block, Full, device};

pub(crate) struct Exchange {
    pub(crate) file: String,
    pub(crate) name: String,
    /// What must hold.
    pub(crate) fault: Option<String>,
    lines: Vec<String>,
}

/// Every file of exchanges, in the order of their names.
pub(crate) fn files() -> Vec<(String, Vec<Exchange>)> {
    let folder = devicenet_tests::workspace_root().join("tests/exchanges");
    let mut files: Vec<String> = std::fs::read_dir(folder)
        .expect("the folder is there")
        .map(|entry| entry.expect("an entry").file_name().into_string().expect("a name"))
        .collect();
    files.sort();
    files.into_iter().map(|file| (file.trim_end_matches(".txt").to_owned(), read(&file))).collect()
}

pub(crate) fn all() -> impl Iterator<Item = Exchange> {
    files().into_iter().flat_map(|(_, exchanges)| exchanges)
}

fn read(file: &str) -> Vec<Exchange> {
    let text = devicenet_tests::read(&format!("tests/exchanges/{file}"));
    let mut exchanges: Vec<Exchange> = Vec::new();
    for line in text.lines().map(str::trim) {
        if let Some(name) = line.strip_prefix("# ") {
            let (file, name) = (file.to_owned(), name.to_owned());
            exchanges.push(Exchange { file, name, fault: None, lines: Vec::new() });
            continue;
        }
        let Some(exchange) = exchanges.last_mut() else { continue };
        match line.strip_prefix("fault:") {
            Some(words) => exchange.fault = Some(words.trim().to_owned()),
            None => exchange.lines.push(line.to_owned()),
        }
    }
    exchanges
}

impl Exchange {
    /// Plays it; panics with the line that does not come true.
    pub(crate) fn play(&self) -> Vec<(u64, String)> {
        let mut player = Player::new(self);
        for (number, line) in (1..).zip(&self.lines) {
            player.place = format!("{}, \"{}\", line {number}: {line}", self.file, self.name);
            player.line(line);
        }
        player.end();
        player.trace
    }

    /// The frames of both sides, in the words of the passive decoder.
    pub(crate) fn words(&self) -> String {
        let mut monitor = Box::new(Monitor::new(MonitorConfig::default()));
        let mut words = format!("{}\n", self.name);
        for (n, (millis, text)) in (1..).zip(self.play()) {
            let frame = frame(&text);
            let reading = monitor.observe(link_core::Instant::from_millis(millis), n, &frame);
            words.push_str(format!("{millis:>8} ms  {:<30}| {reading}", frame.to_string()).trim_end());
            words.push('\n');
        }
        words
    }
}

struct Player {
    tester: Option<Box<dyn Tester>>,
    device: String,
    config: Config,
    told: Vec<String>,
    place: String,
    trace: Vec<(u64, String)>,
}

impl Player {
    fn new(exchange: &Exchange) -> Self {
        Self {
            tester: None,
            device: "block".to_owned(),
            config: Config::new(&device(), MacId::DEFAULT),
            told: Vec::new(),
            place: exchange.name.clone(),
            trace: Vec::new(),
        }
    }

    fn line(&mut self, line: &str) {
        if let Some((times, line)) = line.strip_prefix("repeat ").and_then(|rest| rest.split_once(": ")) {
            for _ in 0..self.number(times) {
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
            "start" => self.start(rest),
            ">" => self.hears(rest),
            "<" => self.sends(rest),
            "!" => assert!(
                self.told.iter().any(|told| told.contains(rest)),
                "{}: told was {:#?}",
                self.place,
                self.told
            ),
            "+" => {
                let (span, how) = rest.split_once(" ms").unwrap_or_else(|| panic!("{}: no time", self.place));
                let millis = self.number(span);
                self.act(|tester| match how.trim() {
                    "late" => tester.sleep(millis),
                    "unnoticed" => tester.step(millis),
                    _ => tester.wait(millis),
                });
            }
            "-" => {
                let millis = self.number(rest.trim_end_matches(" ms"));
                self.act(|tester| tester.step_back(millis));
            }
            "hold" | "go" => self.act(|tester| tester.acknowledge(word == "go")),
            "sent" => self.act(|tester| tester.done(TxOutcome::Sent)),
            "dropped" => self.act(|tester| tester.done(TxOutcome::Dropped)),
            "link" => {
                let event = match rest {
                    "up" => LinkEvent::Up,
                    "down" => LinkEvent::Down,
                    "bus-off" => LinkEvent::BusOff,
                    _ => panic!("{}: no event", self.place),
                };
                self.act(|tester| tester.link(event));
            }
            "in" => self.act(|tester| tester.set_inputs(&bytes(rest))),
            "out" => {
                let place = self.place.clone();
                assert_eq!(self.tester().outputs(), bytes(rest), "{place}");
            }
            "lamp" => {
                let place = self.place.clone();
                assert_eq!(self.tester().indicator(), rest, "{place}");
            }
            _ => {}
        }
    }

    fn number(&self, text: &str) -> u64 {
        text.trim().parse().unwrap_or_else(|_| panic!("{}: no number", self.place))
    }

    fn tester(&mut self) -> &mut dyn Tester {
        if self.tester.is_none() {
            self.start("online");
        }
        self.tester.as_deref_mut().expect("it was started")
    }

    /// Something happens: everything before it must have been looked at.
    fn act(&mut self, act: impl FnOnce(&mut dyn Tester)) {
        self.nothing_more();
        let tester = self.tester();
        act(tester);
        self.told = tester.take_told();
    }

    fn hears(&mut self, text: &str) {
        let heard = frame(text);
        self.act(|tester| tester.hears(heard));
        let millis = self.tester().now().as_nanos() / 1_000_000;
        self.trace.push((millis, text.to_owned()));
    }

    fn sends(&mut self, text: &str) {
        let place = self.place.clone();
        let tester = self.tester();
        let found = tester.take_sent().map(|frame| frame.to_string());
        assert_eq!(found, Some(frame(text).to_string()), "{place}");
        let millis = tester.now().as_nanos() / 1_000_000;
        self.trace.push((millis, text.to_owned()));
    }

    fn nothing_more(&mut self) {
        let place = self.place.clone();
        let more = self.tester().take_sent().map(|frame| frame.to_string());
        assert_eq!(more, None, "before {place}");
    }

    fn end(&mut self) {
        self.nothing_more();
        let place = self.place.clone();
        assert_eq!(self.tester().lost(), (0, 0), "{place}: events or answers were lost");
    }

    fn start(&mut self, how: &str) {
        let config = self.config.clone();
        let short = [0x34, 0x12];
        let long: Vec<u8> = (1..=16).collect();
        self.tester = Some(match self.device.as_str() {
            "block" => Box::new(Bench::<_, 0>::new(config, Block::new(device(), &short, 1))),
            "full" => Box::new(Bench::<_, 0>::new(config, Full::new(&short, 1))),
            "long" => Box::new(Bench::<_, 0>::new(config, Full::new(&long, 10))),
            "seven" => Box::new(Bench::<_, 0>::new(config, Full::new(&long[..14], 14))),
            "ucmm" => Box::new(Bench::<_, 3>::new(config, Full::new(&short, 1))),
            other => panic!("{}: no device {other}", self.place),
        });
        let mut words = how.split_whitespace();
        let stage = words.next();
        if stage == Some("dark") {
            return;
        }
        let tester = self.tester();
        tester.link(LinkEvent::Up);
        tester.wait(2000);
        while tester.take_sent().is_some() {}
        let Some(choice) = words.next() else { return };
        self.asks(&format!("> 5FE: 04 4B 03 01 {choice} 04"));
        for instance in words {
            self.asks(&format!("> 5FC: 04 10 05 0{instance} 09 50 00"));
        }
        self.told.clear();
    }

    /// A step of the beginning, whose answers are not the subject.
    fn asks(&mut self, line: &str) {
        self.line(line);
        while let Some(frame) = self.tester().take_sent() {
            let millis = self.tester().now().as_nanos() / 1_000_000;
            let data: Vec<String> = frame.data().iter().map(|byte| format!("{byte:02X}")).collect();
            self.trace.push((millis, format!("{:03X}: {}", frame.raw_id(), data.join(" "))));
        }
    }
}
