//! Screens of a scenario in virtual time.

use core::time::Duration;

use link_core::machine::Deadline;
use link_core::{Instant, Port as _};
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

use super::Scene;
use super::draw;
use super::player::{Playback, Speed};
use super::style::Theme;
use super::view::{Command, View};
use crate::bus_rate::BusRate;
use crate::live::endpoint::Endpoint;
use crate::live::monitor::model::Model;
use crate::live::port::LivePort;

/// A bus as it was at a moment, and the view of a user.
struct Session {
    title: String,
    port: LivePort,
    model: Model,
    view: View,
    playback: Playback,
}

impl Session {
    fn open(scenario: &str) -> Self {
        Self::of(&format!("sim:{}/{scenario}", env!("CARGO_MANIFEST_DIR")))
    }

    fn of(endpoint: &str) -> Self {
        let endpoint: Endpoint = endpoint.parse().unwrap();
        let title = super::title(&endpoint);
        let port = LivePort::open_listen_only(&endpoint).unwrap();
        let bit_rate = port.bit_rate();
        let model = Model::new(bit_rate.map(BusRate::Known), crate::health::doctor(bit_rate, None, None));
        let playback = Playback::Playing(Speed::Times(1));
        Self { title, port, model, view: View::default(), playback }
    }

    fn of_log(log: &str) -> Self {
        use core::sync::atomic::{AtomicU32, Ordering};
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let unique = (std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(format!("devicenet-{}-{}.log", unique.0, unique.1));
        std::fs::write(&path, log).unwrap();
        let session = Self::of(&format!("log:{}", path.display()));
        std::fs::remove_file(&path).unwrap();
        Self { title: "log:some.log".to_owned(), ..session }
    }

    fn until(mut self, millis: u64) -> Self {
        let until = Instant::from_millis(millis);
        let mut look_at = self.port.now();
        while look_at < until {
            look_at = until.min(look_at + Duration::from_millis(100));
            loop {
                let (at, input) = self.port.wait(Some(Deadline { at: look_at, why: "a look" })).unwrap();
                self.model.see_port(&mut self.port, at, input, |_| {}).unwrap();
                if at >= look_at {
                    break;
                }
            }
        }
        self
    }

    fn press(&mut self, keys: &[KeyCode]) -> Option<Command> {
        let picture = self.model.picture();
        let mut command = None;
        for key in keys {
            command = self.view.key(&KeyEvent::new(*key, KeyModifiers::NONE), &picture);
        }
        command
    }

    fn screen(&self, width: u16, height: u16) -> String {
        let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
        let picture = self.model.picture();
        let scene = Scene {
            title: &self.title,
            picture: &picture,
            view: &self.view,
            playback: self.playback,
            theme: Theme { is_coloured: false },
        };
        terminal.draw(|frame| draw::draw(frame, &scene)).unwrap();
        terminal.backend().to_string()
    }
}

const PLANT: &str = "scenarios/plant.toml";
const DROP: &str = "tests/live/drop.toml";

macro_rules! assert_screen {
    ($name:literal, $description:literal, $screen:expr) => {
        insta::with_settings!({ description => $description, omit_expression => true, prepend_module_to_snapshot => false }, {
            insta::assert_snapshot!($name, $screen);
        });
    };
}

#[test]
fn a_plant_in_order() {
    let session = Session::open(PLANT).until(7_000);
    assert_screen!("screen__plant_80", "five slaves, every kind of I/O", session.screen(80, 24));
    assert_screen!("screen__plant_160", "details beside the list", session.screen(160, 40));
}

/// Words are shorter, and curves, bars and devices make room; none is cut without an ellipsis.
#[test]
fn a_small_terminal() {
    let mut session = Session::open(PLANT).until(7_000);
    assert_screen!("screen__plant_60", "the smallest that there is", session.screen(60, 16));
    assert_screen!("screen__plant_40", "too small", session.screen(40, 10));
    assert!(session.screen(59, 16).contains("This terminal is too small"));
    session.press(&[KeyCode::Char('?')]);
    assert_screen!("screen__help_60", "the keys, as far as there is room", session.screen(60, 16));
    session.press(&[KeyCode::End]);
    assert_screen!("screen__help_60_end", "and the rest of them", session.screen(60, 16));
    session.press(&[KeyCode::Up]);
    assert!(!session.screen(60, 16).contains("nor one that is over"), "one line back");
    session.press(&[KeyCode::Char('x')]);
    assert!(!session.screen(60, 16).contains("Help"), "any other key closes it");
}

/// The picture in the README.
#[test]
fn a_plant_in_trouble() {
    let screen = Session::open(PLANT).until(13_500).screen(80, 24);
    assert_screen!(
        "screen__trouble",
        "a node without power, another that comes back, a third repaired",
        screen
    );
    let readme = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../README.md")).unwrap();
    let lines = screen.lines().map(|line| line.trim_matches('"').trim_end());
    for line in lines {
        assert!(readme.lines().any(|other| other == line), "not drawn so in the README: {line}");
    }
}

#[test]
fn a_bus_before_anybody_speaks() {
    let session = Session::open("tests/live/late.toml").until(500);
    assert_screen!("screen__nobody", "words where there is nothing to show", session.screen(80, 24));
}

/// What is only worth knowing is counted and changes nothing: the pane, the header and the verdict say the same.
#[test]
fn a_restart_is_an_info_and_the_bus_is_healthy() {
    let scenario = "../tests/scenarios/health/restarted.toml";
    let session = Session::open(scenario).until(9_000);
    let screen = session.screen(80, 24);
    assert!(screen.contains("healthy, 1 info") && screen.contains(" Findings ●1 "), "{screen}");
    assert!(!session.model.verdict().is_bad());
}

/// A recording does not tell its bit rate, and this one has no frame.
#[test]
fn a_recording_without_a_frame() {
    let mut session = Session::of_log("");
    session.playback = Playback::Ended;
    assert_screen!("screen__empty", "no frame, and no bit rate", session.screen(80, 24));
}

#[test]
fn a_bus_of_which_lines_were_not_read_is_not_called_healthy() {
    for (lines, words) in [("", "healthy"), ("not a frame\n(1.1) can0 ZZZ#\n", "2 unread")] {
        let log = format!("(1.0) can0 40A#00\n{lines}(2.0) can0 40A#00\n");
        let screen = Session::of_log(&log).until(900).screen(80, 24);
        assert!(screen.contains(words) && (lines.is_empty() || !screen.contains("healthy")), "{screen}");
    }
}

#[test]
fn a_node_that_stopped_answering() {
    let mut session = Session::open(DROP).until(14_000);
    assert_screen!("screen__drop", "node 10, its fault, since when, what to do", session.screen(80, 24));
    session.press(&[KeyCode::Down, KeyCode::Enter]);
    assert_screen!("screen__drop_detail", "its poll connection has timed out", session.screen(80, 24));
    session.press(&[KeyCode::Tab]);
    assert_screen!("screen__drop_findings", "the findings in full width", session.screen(80, 24));
    session.press(&[KeyCode::Char('?')]);
    assert_screen!("screen__help", "the keys", session.screen(80, 24));
}

#[test]
fn what_is_over_can_be_cleared() {
    let mut session = Session::open(DROP).until(22_000);
    session.playback = Playback::Paused(Speed::Times(10));
    assert_screen!("screen__over", "a finding that is over, and a restart", session.screen(80, 24));
    assert!(session.screen(80, 24).contains("stopped answering"));
    session.press(&[KeyCode::Char('c')]);
    assert!(!session.screen(80, 24).contains("stopped answering"));
}

#[test]
fn nodes_are_sorted_by_load_response_and_fault() {
    let mut session = Session::open(DROP).until(14_000);
    let macs = |session: &Session| -> Vec<u8> {
        let picture = session.model.picture();
        session.view.nodes(&picture).iter().map(|node| node.mac().number()).collect()
    };
    assert_eq!(macs(&session), [1, 10, 11]);
    session.press(&[KeyCode::Char('s')]);
    assert_eq!(macs(&session), [11, 1, 10], "by load: node 10 is silent");
    session.press(&[KeyCode::Char('s')]);
    assert_eq!(macs(&session), [10, 11, 1], "by response time, of which a master has none");
    session.press(&[KeyCode::Char('s')]);
    assert_eq!(macs(&session), [10, 1, 11], "by fault");
    session.press(&[KeyCode::Char('s')]);
    assert_eq!(macs(&session), [1, 10, 11]);
}

/// The selection is a node and not a row.
#[test]
fn the_selected_node_stays_selected() {
    let mut session = Session::open(DROP).until(14_000);
    let selected = |session: &Session| {
        let picture = session.model.picture();
        let nodes = session.view.nodes(&picture);
        nodes[session.view.place(&nodes)].mac().number()
    };
    session.press(&[KeyCode::End]);
    assert_eq!(selected(&session), 11);
    session.press(&[KeyCode::Char('s')]);
    assert_eq!(selected(&session), 11);
    session.press(&[KeyCode::Down, KeyCode::PageDown, KeyCode::Up]);
    assert_eq!(selected(&session), 1, "the last but one in this order");
    session.press(&[KeyCode::Home]);
    assert_eq!(selected(&session), 11);
}

#[test]
fn keys_that_the_player_hears() {
    let mut session = Session::open(DROP);
    for (key, command) in [
        (KeyCode::Char('q'), Some(Command::Quit)),
        (KeyCode::Char('p'), Some(Command::Pause)),
        (KeyCode::Char(' '), Some(Command::Pause)),
        (KeyCode::Char('+'), Some(Command::Faster)),
        (KeyCode::Char('-'), Some(Command::Slower)),
        (KeyCode::Char('.'), Some(Command::Step)),
        (KeyCode::Char('x'), None),
        (KeyCode::Esc, None),
    ] {
        assert_eq!(session.press(&[key]), command, "{key:?}");
    }
    // With the help open it closes that.
    assert_eq!(session.press(&[KeyCode::Char('?'), KeyCode::Char('q')]), None);
    assert_eq!(session.press(&[KeyCode::Char('q')]), Some(Command::Quit));
    let picture = session.model.picture();
    let interrupt = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
    assert_eq!(session.view.key(&interrupt, &picture), Some(Command::Quit));
}
