//! Colours, which only decorate: all that they say is also said in words or shapes.

use devicenet_core::doctor::Severity;
use devicenet_core::monitor::{AccessState, ConnectionState};
use ratatui::style::{Color, Modifier, Style};

use crate::live::monitor::model::LinkState;

/// How things look.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::live::monitor) struct Theme {
    /// Without, bold, dim and reversed have to do.
    pub(in crate::live::monitor) is_coloured: bool,
}

impl Theme {
    fn colour(self, colour: Color) -> Style {
        if self.is_coloured { Style::new().fg(colour) } else { Style::new() }
    }

    pub(super) fn title(self) -> Style {
        self.colour(Color::Cyan).add_modifier(Modifier::BOLD)
    }

    /// The frame of a pane.
    pub(super) fn border(self, is_focused: bool) -> Style {
        match is_focused {
            true => self.colour(Color::Cyan),
            false => self.dim(),
        }
    }

    /// Headings, units, what is not news.
    pub(super) fn dim(self) -> Style {
        self.colour(Color::DarkGray)
    }

    pub(super) fn heading(self) -> Style {
        Style::new().add_modifier(Modifier::BOLD)
    }

    pub(super) fn selected(self, is_focused: bool) -> Style {
        match is_focused {
            true => Style::new().add_modifier(Modifier::REVERSED),
            false => Style::new().add_modifier(Modifier::BOLD),
        }
    }

    pub(super) fn key(self) -> Style {
        self.colour(Color::Cyan).add_modifier(Modifier::BOLD)
    }

    pub(super) fn good(self) -> Style {
        self.colour(Color::Green)
    }

    pub(super) fn severity(self, severity: Severity) -> Style {
        match severity {
            Severity::Info => self.colour(Color::Blue),
            Severity::Warning => self.colour(Color::Yellow),
            Severity::Error => self.colour(Color::Red).add_modifier(Modifier::BOLD),
        }
    }

    pub(super) fn link(self, link: LinkState) -> Style {
        match link {
            LinkState::ErrorActive => self.good(),
            LinkState::ErrorWarning | LinkState::ErrorPassive => self.severity(Severity::Warning),
            LinkState::Down | LinkState::BusOff => self.severity(Severity::Error),
        }
    }

    pub(super) fn access(self, access: AccessState) -> Style {
        match access {
            AccessState::OnLine => self.good(),
            AccessState::FirstCheck | AccessState::SecondCheck => self.colour(Color::Blue),
            AccessState::Unknown | AccessState::OffLine => self.dim(),
            AccessState::SuspectedDuplicate | AccessState::Faulted => self.severity(Severity::Error),
        }
    }

    pub(super) fn connection(self, state: ConnectionState) -> Style {
        match state {
            ConnectionState::Established | ConnectionState::DeferredDelete => self.good(),
            ConnectionState::Configuring | ConnectionState::WaitingForConnectionId => {
                self.colour(Color::Blue)
            }
            ConnectionState::TimedOut => self.severity(Severity::Error),
            ConnectionState::Unknown | ConnectionState::NonExistent => self.dim(),
        }
    }

    /// A bar that is full at 1.
    pub(super) fn bar(self, share: f64) -> Style {
        match share {
            share if share >= 0.9 => self.severity(Severity::Error),
            share if share >= 0.7 => self.severity(Severity::Warning),
            _ => self.good(),
        }
    }
}
