//! The keys.

use ratatui::Frame;
use ratatui::layout::{Constraint, Rect};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Clear, Paragraph};

use super::pane;
use crate::live::monitor::screen::Scene;
use crate::live::monitor::screen::player::Playback;

/// The bottom line.
pub(super) fn line(frame: &mut Frame<'_>, scene: &Scene<'_>, area: Rect) {
    let theme = scene.theme;
    let is_played = !matches!(scene.playback, Playback::Live | Playback::Frozen);
    let enter = if scene.view.is_large { "smaller" } else { "details" };
    let mut keys = vec![
        ("q", "quit"),
        ("?", "help"),
        ("↑↓", "select"),
        ("tab", "pane"),
        ("enter", enter),
        ("s", "sort"),
    ];
    keys.push(("p", "pause"));
    keys.extend(is_played.then_some(("+ -", "speed")));
    keys.push(("c", "clear"));
    let spans = keys.into_iter().flat_map(|(key, words)| {
        [Span::styled(format!(" {key}"), theme.key()), Span::styled(format!(" {words} "), theme.dim())]
    });
    frame.render_widget(Paragraph::new(Line::from_iter(spans)), area);
}

/// The page of keys.
pub(super) fn draw(frame: &mut Frame<'_>, scene: &Scene<'_>, area: Rect) {
    let theme = scene.theme;
    let lines: Vec<Line<'_>> = KEYS
        .iter()
        .map(|(key, words)| {
            Line::from(vec![Span::styled(format!(" {key:<9}"), theme.key()), Span::raw(*words)])
        })
        .collect();
    let page = area.centered(Constraint::Length(70), Constraint::Length(lines.len() as u16 + 2));
    frame.render_widget(Clear, page);
    frame.render_widget(Paragraph::new(lines).block(pane(theme, "Help".to_owned(), true)), page);
}

const KEYS: [(&str, &str); 17] = [
    ("↑ ↓", "select a node or a finding; also j k, page keys, home, end"),
    ("tab", "from the nodes to the findings and back"),
    ("enter", "details of the node; the findings in full width"),
    ("s", "order of the nodes: MAC ID, load, response time, fault"),
    ("c", "clear findings and faults that are over"),
    ("p, space", "pause: a live bus goes on behind the picture"),
    ("+ -", "speed of a scenario or a recording: 1x, 10x, 100x, full"),
    (".", "of these one step of 100 ms"),
    ("esc", "close; q, ctrl-c: quit"),
    ("", ""),
    ("load", "of the last second, to the bit, stuff bits included"),
    ("slowest", "the longest I/O response of the node; the bar is full at"),
    ("", "4 x EPR, when its peer gives up, and each third of it is"),
    ("", "a factor of ten"),
    ("in, out", "bytes that the node consumes and produces; path: the"),
    ("", "instances (as a rule assemblies) that these come from"),
    ("✖ ▲ ●", "a finding that is an error, a warning, worth knowing"),
];
