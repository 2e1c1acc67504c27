//! The screen: a terminal that shows the bus as it is.

mod draw;
mod keys;
mod player;
mod style;
#[cfg(test)]
mod tests;
mod view;

use core::sync::atomic::{AtomicBool, Ordering};
use std::io::{self, IsTerminal as _};
use std::path::Path;

use ratatui::DefaultTerminal;
use ratatui::crossterm::event::Event;

use super::model::{Model, Picture};
use crate::exit::Failure;
use crate::live::args::MonitorArgs;
use crate::live::endpoint::Endpoint;
use crate::live::port::LivePort;
use crate::output;
use keys::Keys;
use player::{Playback, Player};
use view::{Command, View};

pub(super) use style::Theme;

/// Shows the bus until the user has seen enough.
pub(super) fn run(
    args: &MonitorArgs,
    port: &mut LivePort,
    model: &mut Model,
    interrupted: &'static AtomicBool,
    theme: Theme,
) -> Result<(), Failure> {
    // What is said meanwhile would be in the picture.
    let held = output::hold();
    let mut terminal = Terminal::open()?;
    let player = match args.endpoint {
        Endpoint::Interface(_) => Player::live(),
        Endpoint::Scenario(_) | Endpoint::Recording(_) => Player::recorded(args.span.is_none()),
    };
    let screen = Screen { title: title(&args.endpoint), player, view: View::default(), theme };
    let ended = screen.run(&mut terminal.0, port, model, interrupted);
    drop(terminal);
    drop(held);
    ended
}

/// Of a file its name is enough.
fn title(endpoint: &Endpoint) -> String {
    let name = |path: &Path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    match endpoint {
        Endpoint::Interface(interface) => interface.clone(),
        Endpoint::Scenario(path) => format!("sim:{}", name(path)),
        Endpoint::Recording(path) => format!("log:{}", name(path)),
    }
}

/// What a frame of the screen is drawn from.
pub(super) struct Scene<'a> {
    pub(super) title: &'a str,
    pub(super) picture: &'a Picture,
    pub(super) view: &'a View,
    pub(super) playback: Playback,
    pub(super) theme: Theme,
}

struct Screen {
    title: String,
    player: Player,
    view: View,
    theme: Theme,
}

impl Screen {
    fn run(
        mut self,
        terminal: &mut DefaultTerminal,
        port: &mut LivePort,
        model: &mut Model,
        interrupted: &AtomicBool,
    ) -> Result<(), Failure> {
        let mut keys = Keys::open();
        let mut picture = model.picture();
        loop {
            if !self.player.is_frozen() {
                picture = model.picture();
            }
            terminal.draw(|frame| draw::draw(frame, &self.scene(&picture)))?;
            self.player.play(port, model, &mut keys)?;
            let is_closed = !io::stdout().is_terminal();
            if self.player.is_over() || interrupted.load(Ordering::Relaxed) || is_closed {
                return Ok(());
            }
            while let Some(event) = keys.next()? {
                if self.key(&event, &picture) {
                    return Ok(());
                }
            }
        }
    }

    fn scene<'a>(&'a self, picture: &'a Picture) -> Scene<'a> {
        let Self { title, player, view, theme } = self;
        Scene { title, picture, view, playback: player.playback(), theme: *theme }
    }

    /// True if the user has seen enough.
    fn key(&mut self, event: &Event, picture: &Picture) -> bool {
        let Event::Key(key) = event else { return false };
        match self.view.key(key, picture) {
            Some(Command::Quit) => return true,
            Some(Command::Pause) => self.player.pause(),
            Some(Command::Faster) => self.player.faster(),
            Some(Command::Slower) => self.player.slower(),
            Some(Command::Step) => self.player.step(),
            None => {}
        }
        false
    }
}

/// A terminal that is as it was when this is gone, also after a panic.
struct Terminal(DefaultTerminal);

impl Terminal {
    fn open() -> io::Result<Self> {
        Ok(Self(ratatui::try_init()?))
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        ratatui::restore();
    }
}
