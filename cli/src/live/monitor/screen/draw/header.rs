//! Interface, bit rate, state; load, counters, verdict.

use devicenet_core::doctor::Severity;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Modifier;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::bar::bar;
use crate::live::monitor::screen::Scene;
use crate::live::monitor::screen::player::{Playback, Speed};
use crate::live::monitor::words::{clock, fit, percent};
use crate::text::{count, printable};

pub(super) fn draw(frame: &mut Frame<'_>, scene: &Scene<'_>, area: Rect) {
    let [first, second] = area.layout(&Layout::vertical([Constraint::Length(1); 2]));
    let width = usize::from(first.width);
    let room = |right: &Line<'_>| width.saturating_sub(right.width());
    let long = state(scene, true);
    let right = if title(scene, room(&long)).width() < room(&long) { long } else { state(scene, false) };
    let [left, end] =
        first.layout(&Layout::horizontal([Constraint::Fill(1), Constraint::Length(right.width() as u16)]));
    frame.render_widget(Paragraph::new(title(scene, left.width.into())), left);
    frame.render_widget(Paragraph::new(right), end);
    frame.render_widget(Paragraph::new(figures(scene, second.width.into())), second);
}

/// As much of it as there is room for; all of it is shorter than the room.
fn title<'a>(scene: &Scene<'_>, room: usize) -> Line<'a> {
    let Scene { theme, picture, .. } = scene;
    let name = " DeviceNet ";
    let bit_rate = format!(" {}", picture.bit_rate);
    let room = room.saturating_sub(name.len() + 2);
    let endpoint = printable(scene.title);
    let has_room = endpoint.chars().count() + bit_rate.len() <= room;
    let mut spans = vec![
        Span::styled(name, theme.title().add_modifier(Modifier::REVERSED)),
        Span::styled(format!(" {}", fit(&endpoint, room)), theme.heading()),
    ];
    if has_room {
        spans.push(Span::styled(bit_rate, theme.dim()));
    } else {
        // It fills the room: whoever asks for a shorter state sees that.
        spans.push(Span::raw("  "));
    }
    Line::from(spans)
}

fn state<'a>(scene: &Scene<'_>, is_long: bool) -> Line<'a> {
    let Scene { theme, picture, .. } = scene;
    let playback = match (scene.playback, is_long) {
        (Playback::Live, _) => "live".to_owned(),
        (Playback::Frozen, true) => "PAUSED, the bus goes on".to_owned(),
        (Playback::Frozen, false) => "PAUSED".to_owned(),
        (Playback::Playing(speed), true) => format!("playing {}", speed_words(speed)),
        (Playback::Playing(speed), false) => speed_words(speed),
        (Playback::Paused(speed), _) => format!("PAUSED {}", speed_words(speed)),
        (Playback::Ended, _) => "END".to_owned(),
    };
    let is_moving = matches!(scene.playback, Playback::Live | Playback::Playing(_));
    let counters = match (picture.counters.tec, picture.counters.rec) {
        (Some(tec), Some(rec)) if is_long => format!(" TEC {tec} REC {rec}"),
        _ => String::new(),
    };
    let link = picture.link.to_string();
    let link = if is_long { link } else { link.trim_start_matches("up, ").to_owned() };
    Line::from(vec![
        Span::styled(link, theme.link(picture.link)),
        Span::styled(counters, theme.dim()),
        Span::raw(if is_long { "   " } else { "  " }),
        Span::styled(clock(picture.at), theme.heading()),
        Span::raw("  "),
        Span::styled(playback, if is_moving { theme.dim() } else { theme.severity(Severity::Warning) }),
        Span::raw(" "),
    ])
}

/// Load, counters, verdict: with all of it, or shorter words and without what is zero, or the verdict alone.
fn figures<'a>(scene: &Scene<'_>, width: usize) -> Line<'a> {
    let forms = [(width / 5, Form::Long), (10, Form::Short), (6, Form::Shortest)];
    let lines = forms.map(|(bar, form)| figures_as(scene, bar, form, usize::MAX));
    let found = lines.into_iter().find(|line| line.width() <= width);
    found.unwrap_or_else(|| figures_as(scene, 4, Form::None, width))
}

/// How many words the counters take.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Form {
    Long,
    Short,
    Shortest,
    None,
}

fn figures_as<'a>(scene: &Scene<'_>, bar_width: usize, form: Form, width: usize) -> Line<'a> {
    let Scene { theme, picture, .. } = scene;
    let counters = picture.counters;
    let load = picture.load.all;
    let bound = picture.bit_rate.bound(counters.error_frames > 0).sign();
    let warning = theme.severity(Severity::Warning);
    let mut spans = vec![
        Span::styled(" load ", theme.dim()),
        Span::styled("▕", theme.dim()),
        Span::styled(bar(load, bar_width), theme.bar(load)),
        Span::styled("▏", theme.dim()),
        Span::styled(
            format!("{:>7}", format!("{bound}{}", percent(load))),
            theme.bar(load).add_modifier(Modifier::BOLD),
        ),
    ];
    let counted = [
        (counters.frames, "frame", "frame", theme.dim()),
        (counters.error_frames, "error frame", "err.", warning),
        (counters.problems, "problem", "prob.", warning),
        (counters.lost, "lost frame", "lost", warning),
    ];
    for (index, (number, long, shortest, style)) in counted.into_iter().enumerate() {
        let style = if number == 0 { theme.dim() } else { style };
        let words = match form {
            Form::None => continue,
            Form::Short | Form::Shortest if number == 0 && index > 0 => continue,
            Form::Shortest if index > 0 => format!("{number} {shortest}"),
            Form::Long | Form::Short | Form::Shortest => count(number, long),
        };
        spans.push(Span::styled(format!("  {words}"), style));
    }
    let verdict = picture.verdict;
    let style = verdict.severity().map_or(theme.good(), |severity| theme.severity(severity));
    let taken: usize = spans.iter().map(Span::width).sum();
    let words = verdict.fit(width.saturating_sub(taken + 2));
    spans.push(Span::styled(format!("  {words}"), style.add_modifier(Modifier::BOLD)));
    Line::from(spans)
}

fn speed_words(speed: Speed) -> String {
    match speed {
        Speed::Times(times) => format!("{times}x"),
        Speed::Full => "at full speed".to_owned(),
    }
}
