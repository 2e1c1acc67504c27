//! What the user presses.

use core::time::Duration;
use std::sync::mpsc::{self, Receiver};
use std::{io, thread};

use ratatui::crossterm::event::{self, Event};

/// The keyboard, read by a thread of its own: crossterm does not come back from a terminal that is closed meanwhile.
#[derive(Debug)]
pub(super) struct Keys {
    events: Receiver<io::Result<Event>>,
    /// What a wait has ended with.
    first: Option<io::Result<Event>>,
}

impl Keys {
    pub(super) fn open() -> Self {
        let (sender, events) = mpsc::channel();
        thread::spawn(move || while sender.send(event::read()).is_ok() {});
        Self { events, first: None }
    }

    /// Waits for so long, or until a key is pressed.
    pub(super) fn wait(&mut self, span: Duration) {
        if self.first.is_none() {
            self.first = self.events.recv_timeout(span).ok();
        }
    }

    /// What was pressed and not taken yet.
    pub(super) fn next(&mut self) -> io::Result<Option<Event>> {
        self.first.take().or_else(|| self.events.try_recv().ok()).transpose()
    }
}
