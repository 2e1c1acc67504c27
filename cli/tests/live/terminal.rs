//! `monitor` on a terminal: in tmux, with keys pressed and the screen read.

use std::process::{Command, Output};
use std::time::{Duration, Instant};

/// Without tmux there is nothing to test; where the tests must be complete, that is a failure.
macro_rules! needs_tmux {
    () => {
        if let Err(why) = Command::new("tmux").arg("-V").output() {
            assert!(std::env::var_os("DEVICENET_REQUIRE_TMUX").is_none(), "no tmux: {why}");
            eprintln!("SKIPPED: the screen on a terminal: tmux: {why}");
            return;
        }
    };
}

macro_rules! assert_screen {
    ($name:literal, $description:literal, $screen:expr) => {
        insta::with_settings!({ description => $description, omit_expression => true, prepend_module_to_snapshot => false }, {
            insta::assert_snapshot!($name, $screen);
        });
    };
}

/// A terminal in which the monitor runs.
struct Terminal {
    /// The socket of a tmux of its own.
    socket: String,
}

impl Terminal {
    /// The monitor with these arguments on 80 columns and 24 lines, called by a shell that says how it ended.
    fn open(name: &str, environment: &[&str], arguments: &[&str]) -> Self {
        let terminal = Self { socket: format!("devicenet-{}-{name}", std::process::id()) };
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/live");
        let shell = "\"$@\"; echo exit code $?; exec cat";
        let mut command = vec!["new-session", "-d", "-x", "80", "-y", "24", "-c", folder];
        command.extend(["sh", "-c", shell, "sh", "env"]);
        command.extend(environment);
        command.extend([env!("CARGO_BIN_EXE_devicenet"), "monitor"]);
        command.extend(arguments);
        terminal.tmux(&command);
        terminal
    }

    fn command(&self) -> Command {
        let mut command = Command::new("tmux");
        command.args(["-u", "-L", &self.socket, "-f", "/dev/null"]).env("LC_ALL", "C.UTF-8");
        command
    }

    fn tmux(&self, arguments: &[&str]) -> Output {
        let output = self.command().args(arguments).output().unwrap();
        assert!(output.status.success(), "{arguments:?}: {output:?}");
        output
    }

    fn press(&self, keys: &[&str]) {
        self.tmux(&[&["send-keys"], keys].concat());
    }

    /// The screen as it is.
    fn screen(&self) -> String {
        String::from_utf8(self.tmux(&["capture-pane", "-p"]).stdout).unwrap()
    }

    fn asked(&self, what: &str) -> String {
        String::from_utf8(self.tmux(&["display-message", "-p", what]).stdout).unwrap().trim().to_owned()
    }

    /// The screen, as soon as it is as it should be.
    #[track_caller]
    fn until(&self, what: &str, is_there: impl Fn(&str) -> bool) -> String {
        let begin = Instant::now();
        loop {
            let screen = self.screen();
            if is_there(&screen) {
                return screen;
            }
            assert!(begin.elapsed() < PATIENCE, "{what} is missing on\n{screen}");
        }
    }

    /// The same, when nothing is drawn any more: a picture does not come in one piece.
    #[track_caller]
    fn settled(&self, what: &str, is_there: impl Fn(&str) -> bool) -> String {
        let mut screen = self.until(what, &is_there);
        let mut same = 0;
        while same < OFTEN {
            let next = self.until(what, &is_there);
            same = if next == screen { u32::saturating_add(same, 1) } else { 0 };
            screen = next;
        }
        screen
    }

    /// The exit code, when the program has ended; then the terminal is as it was.
    #[track_caller]
    fn ended(&self) -> String {
        let screen = self.until("the end of the program", |screen| screen.contains("exit code"));
        assert_eq!(self.asked("#{alternate_on} #{cursor_flag}"), "0 1", "another screen, a hidden cursor");
        let code = screen.lines().find_map(|line| line.strip_prefix("exit code "));
        code.unwrap_or_default().to_owned()
    }

    /// The process of the monitor: the only child of the shell.
    fn process(&self) -> String {
        let shell = self.asked("#{pane_pid}");
        let children = std::fs::read_to_string(format!("/proc/{shell}/task/{shell}/children")).unwrap();
        children.trim().to_owned()
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        let _ = self.command().arg("kill-server").output();
    }
}

/// Looks at the screen, of which each takes some milliseconds.
const OFTEN: u32 = 30;
/// It takes a fraction of it, even on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);
const RECORDING: &str = "log:../../../tests/captures/slave-01-startup-poll.log";

#[test]
fn a_recording_is_watched_to_its_end_and_looked_at() {
    needs_tmux!();
    let terminal = Terminal::open("recording", &[], &[RECORDING]);
    terminal.until("the beginning", |screen| screen.contains("playing 1x"));
    terminal.press(&["+", "+", "+"]);
    let end = terminal
        .settled("the end", |screen| screen.contains("END") && screen.contains("net access    0.0 %"));
    assert_screen!("terminal__end", "a recording that has come to its end", end);
    terminal.press(&["Down", "Enter"]);
    let detail = terminal.settled("the details", |screen| screen.contains("watchdog"));
    assert_screen!("terminal__detail", "the node that was polled", detail);
    terminal.press(&["?"]);
    terminal.until("the help", |screen| screen.contains("from the nodes to the findings and back"));
    terminal.press(&["Escape"]);
    terminal.until("no help", |screen| !screen.contains("from the nodes to the findings and back"));
    terminal.tmux(&["resize-window", "-x", "150", "-y", "30"]);
    let wide =
        |screen: &str| screen.lines().any(|line| line.contains("╭ Node 10") && line.contains("Nodes 2"));
    terminal.until("the details beside the list", wide);
    terminal.tmux(&["resize-window", "-x", "50", "-y", "12"]);
    terminal.until("that there is no room", |screen| screen.contains("This terminal is too small"));
    terminal.tmux(&["resize-window", "-x", "80", "-y", "24"]);
    terminal.until("the first screen again", |screen| screen.contains("watchdog"));
    terminal.press(&["q"]);
    assert_eq!(terminal.ended(), "0");
    let words = terminal.screen();
    assert!(words.contains("4.210 s, in the end: up, error-active") && !words.contains("END"), "{words}");
}

#[test]
fn a_scenario_is_paused_and_goes_step_by_step() {
    needs_tmux!();
    let terminal = Terminal::open("steps", &[], &["sim:drop.toml"]);
    terminal.until("the beginning", |screen| screen.contains("playing 1x"));
    terminal.press(&["p"]);
    terminal.until("a pause", |screen| screen.contains("PAUSED 1x"));
    let clock =
        || terminal.until("a pause", |screen| screen.contains("PAUSED")).lines().next().unwrap().to_owned();
    let before = clock();
    terminal.press(&["."]);
    terminal.until("a step", |screen| screen.lines().next() != Some(&before));
    // At full speed to the end; what was wrong on the way is there.
    terminal.press(&["+", "+", "+", "p"]);
    let end = terminal.settled("the end", |screen| screen.contains("END"));
    assert!(end.contains("node 10: stopped answering") && end.contains("0:00:40.0"), "{end}");
    terminal.press(&["C-c"]);
    assert_eq!(terminal.ended(), "1");
}

#[test]
fn a_signal_leaves_the_terminal_as_it_was() {
    needs_tmux!();
    for signal in ["INT", "TERM", "HUP"] {
        let terminal = Terminal::open(signal, &[], &["sim:long.toml"]);
        terminal.until("the beginning", |screen| screen.contains("playing 1x"));
        let killed = Command::new("kill").args(["-s", signal, &terminal.process()]).status().unwrap();
        assert!(killed.success());
        assert_eq!(terminal.ended(), "0", "{signal}");
        assert!(terminal.screen().contains("in the end"), "{}", terminal.screen());
    }
}

#[test]
fn a_terminal_that_is_closed_ends_the_monitor() {
    needs_tmux!();
    let terminal = Terminal::open("closed", &[], &["sim:long.toml"]);
    terminal.until("the beginning", |screen| screen.contains("playing"));
    let process = terminal.process();
    drop(terminal);
    let begin = Instant::now();
    // Of a process that nobody has asked for its end, the command line is empty.
    while std::fs::read(format!("/proc/{process}/cmdline")).is_ok_and(|line| !line.is_empty()) {
        assert!(begin.elapsed() < PATIENCE, "the process {process} is still there");
    }
}

#[test]
fn colours_are_left_out_where_they_are_not_wanted() {
    needs_tmux!();
    for (name, environment, is_coloured) in [("colours", "NO_COLOR=", true), ("plain", "NO_COLOR=1", false)] {
        let terminal = Terminal::open(name, &["-u", "CLICOLOR", environment], &["sim:long.toml"]);
        terminal.until("the beginning", |screen| screen.contains("playing 1x"));
        let screen = String::from_utf8(terminal.tmux(&["capture-pane", "-p", "-e"]).stdout).unwrap();
        // Foreground and background colours, 30 to 49 and 90 to 107.
        let colours = screen.split("\x1b[").skip(1).filter(|code| {
            let codes = code.split('m').next().unwrap_or_default();
            codes.split(';').any(|code| {
                code.len() >= 2
                    && ["3", "4", "9"].iter().any(|tens| code.starts_with(tens))
                    && code != "39"
                    && code != "49"
            })
        });
        assert_eq!(colours.count() > 0, is_coloured, "{screen:?}");
    }
}

/// What was seen until then is told, and then why there is no more.
#[test]
fn a_recording_that_is_cut_off_ends_with_a_summary_and_the_error() {
    needs_tmux!();
    let whole = crate::record::file("cut-off-whole.pcapng");
    let run =
        crate::devicenet(&["record", "sim:drop.toml", "--trigger", "timeout", "-o", whole.to_str().unwrap()]);
    assert_eq!(run.code(), 1, "{}", run.err());
    let bytes = std::fs::read(&whole).unwrap();
    let cut = crate::record::file("cut-off.pcapng");
    std::fs::write(&cut, &bytes[..bytes.len() - 7]).unwrap();
    let terminal = Terminal::open("cut-off", &[], &[&format!("log:{}", cut.display())]);
    terminal.until("the beginning", |screen| screen.contains("playing 1x"));
    terminal.press(&["+", "+", "+"]);
    assert_eq!(terminal.ended(), "2");
    let words = terminal.screen();
    let place = |what: &str| words.find(what);
    assert!(place("in the end").is_some() && place("in the end") < place("error: "), "{words}");
}

/// At full speed a silence of decades takes no longer than one of a minute.
#[test]
fn a_recording_whose_clock_was_set_comes_to_its_end() {
    needs_tmux!();
    let path = crate::record::file("clock-set-screen.log");
    std::fs::write(&path, "(1.000000) can0 40A#00\n(1700000000.000000) can0 40A#00\n").unwrap();
    let terminal = Terminal::open("clock", &[], &[&format!("log:{}", path.display())]);
    terminal.until("the beginning", |screen| screen.contains("playing 1x"));
    terminal.press(&["+", "+", "+"]);
    terminal.until("the end", |screen| screen.contains("END") && screen.contains("472222:"));
    terminal.press(&["q"]);
    assert_eq!(terminal.ended(), "0");
    let words = terminal.screen();
    assert!(words.contains("nothing was heard for"), "{words}");
}
