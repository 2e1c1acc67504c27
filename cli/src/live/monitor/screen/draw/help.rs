//! The keys.

use ratatui::Frame;
use ratatui::layout::{Constraint, Rect};
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Clear, Paragraph};

use super::{indented, pane};
use crate::live::monitor::screen::Scene;
use crate::live::monitor::screen::player::Playback;

/// The bottom line.
pub(super) fn line(frame: &mut Frame<'_>, scene: &Scene<'_>, area: Rect) {
    let theme = scene.theme;
    let is_played = !matches!(scene.playback, Playback::Live | Playback::Frozen);
    let enter = if scene.view.is_large { "smaller" } else { "details" };
    let keys = [
        Some(("q", "quit")),
        Some(("?", "help")),
        Some(("↑↓", "select")),
        Some(("tab", "pane")),
        Some(("enter", enter)),
        Some(("s", "sort")),
        Some(("p", "pause")),
        is_played.then_some(("+ -", "speed")),
        Some(("c", "clear")),
    ];
    let keys = keys.into_iter().flatten();
    let spans = keys.map(|(key, words)| {
        [Span::styled(format!(" {key}"), theme.key()), Span::styled(format!(" {words} "), theme.dim())]
    });
    let mut taken = 0;
    // As many as there is room for; none is cut.
    let shown = spans.into_iter().take_while(|spans| {
        taken += spans.iter().map(Span::width).sum::<usize>();
        taken <= usize::from(area.width)
    });
    frame.render_widget(Paragraph::new(Line::from_iter(shown.flatten())), area);
}

/// The page of keys, scrolled if there is no room for all of it.
pub(super) fn draw(frame: &mut Frame<'_>, scene: &Scene<'_>, area: Rect) {
    let theme = scene.theme;
    let width = WIDTH.min(area.width);
    let lines: Vec<Line<'_>> = KEYS
        .iter()
        .flat_map(|(key, words)| {
            let mark = Span::styled(format!(" {key:<9}"), theme.key());
            match words.is_empty() {
                true => vec![Line::default()],
                false => indented(mark, words, width - BORDERS, Style::new()),
            }
        })
        .collect();
    let page = area.centered(
        Constraint::Length(width),
        Constraint::Length((lines.len() as u16).saturating_add(BORDERS)),
    );
    let hidden = lines.len().saturating_sub(usize::from(page.height - BORDERS.min(page.height)));
    let first = scene.view.help_line.get().min(hidden);
    scene.view.help_line.set(first);
    let title = if hidden > 0 { "Help · ↑↓ scroll" } else { "Help" };
    frame.render_widget(Clear, page);
    let shown: Vec<Line<'_>> = lines.into_iter().skip(first).collect();
    frame.render_widget(Paragraph::new(shown).block(pane(theme, title.to_owned(), true)), page);
}

/// Left and right, or above and below.
const BORDERS: u16 = 2;
const WIDTH: u16 = 70;

/// What stands on the page.
const KEYS: [(&str, &str); 15] = [
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
    (
        "slowest",
        "the longest I/O response of the node; the bar is full at 4 x EPR, when its peer gives up, and each third of it is a \
         factor of ten",
    ),
    (
        "in, out",
        "bytes that the node consumes and produces; path: the instances (as a rule assemblies) that these come from",
    ),
    ("problems", "frames that are wrong or suspicious; the last words when the monitor ends say which"),
    (
        "✖ ▲ ●",
        "findings that last: errors, warnings, infos. Healthy is a bus with no error or warning, nor one that is over",
    ),
];
