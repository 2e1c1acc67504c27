//! The screen, drawn from a picture and nothing else.
//!
//! ```text
//! header        interface, bit rate, state, load, counters
//! nodes         a row each          │ on a wide screen: details of the node,
//! load, findings, or details        │ the load beside the findings
//! help line
//! ```

mod bar;
mod detail;
mod findings;
mod header;
mod help;
mod load;
mod nodes;

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, BorderType, Paragraph, Wrap};

use super::Scene;
use super::style::Theme;
use super::view::Focus;

/// Draws the whole screen.
pub(super) fn draw(frame: &mut Frame<'_>, scene: &Scene<'_>) {
    let area = frame.area();
    if area.width < SMALLEST.0 || area.height < SMALLEST.1 {
        let words = format!("This terminal is too small: {} x {} at least.", SMALLEST.0, SMALLEST.1);
        return frame.render_widget(Paragraph::new(words).wrap(Wrap { trim: true }), area);
    }
    let [top, body, bottom] =
        area.layout(&Layout::vertical([Constraint::Length(2), Constraint::Fill(1), Constraint::Length(1)]));
    header::draw(frame, scene, top);
    if area.width >= WIDE {
        wide(frame, scene, body);
    } else {
        narrow(frame, scene, body);
    }
    help::line(frame, scene, bottom);
    if scene.view.has_help {
        help::draw(frame, scene, area);
    }
}

fn narrow(frame: &mut Frame<'_>, scene: &Scene<'_>, body: Rect) {
    let view = scene.view;
    let lower = if view.is_large { (body.height * 4 / 7).max(6) } else { (body.height * 3 / 7).max(6) };
    let [upper, lower] = body.layout(&Layout::vertical([Constraint::Fill(1), Constraint::Length(lower)]));
    nodes::draw(frame, scene, upper);
    match (view.is_large, view.focus) {
        (true, Focus::Nodes) => detail::draw(frame, scene, lower),
        (true, Focus::Findings) => findings::draw(frame, scene, lower),
        (false, _) => {
            let load = if body.width < NARROW { load::WITHOUT_CURVE } else { 30 };
            let [left, right] =
                lower.layout(&Layout::horizontal([Constraint::Length(load), Constraint::Fill(1)]));
            load::draw(frame, scene, left);
            findings::draw(frame, scene, right);
        }
    }
}

fn wide(frame: &mut Frame<'_>, scene: &Scene<'_>, body: Rect) {
    let lower = if scene.view.is_large { body.height / 2 } else { (body.height * 3 / 7).max(6) };
    let [upper, lower] = body.layout(&Layout::vertical([Constraint::Fill(1), Constraint::Length(lower)]));
    let [list, detail] = upper.layout(&Layout::horizontal([Constraint::Fill(1), Constraint::Length(61)]));
    nodes::draw(frame, scene, list);
    detail::draw(frame, scene, detail);
    let [left, right] = lower.layout(&Layout::horizontal([Constraint::Percentage(42), Constraint::Fill(1)]));
    load::draw(frame, scene, left);
    findings::draw(frame, scene, right);
}

/// A frame with a title; that of the pane in focus is thick.
fn pane<'a>(theme: Theme, title: String, is_focused: bool) -> Block<'a> {
    Block::bordered()
        .border_type(if is_focused { BorderType::Thick } else { BorderType::Rounded })
        .border_style(theme.border(is_focused))
        .title(Line::styled(format!(" {title} "), theme.title()))
}

/// Words in lines of a width, behind a mark; those after the first stand under the first.
fn indented<'a>(mark: Span<'a>, text: &str, width: u16, style: Style) -> Vec<Line<'a>> {
    let indent = mark.width();
    let room = usize::from(width).saturating_sub(indent).max(1);
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_inclusive(' ') {
        match lines.last_mut() {
            Some(line) if line.chars().count() + word.trim_end().chars().count() <= room => {
                line.push_str(word)
            }
            _ => lines.push(word.to_owned()),
        }
    }
    let marks = core::iter::once(mark).chain(core::iter::repeat(Span::raw(" ".repeat(indent))));
    marks.zip(lines).map(|(mark, line)| Line::from(vec![mark, Span::styled(line, style)])).collect()
}

/// What is to be said when there is nothing to show.
fn nothing(theme: Theme, words: &str) -> Paragraph<'_> {
    let style: Style = theme.dim();
    Paragraph::new(words).style(style).centered()
}

/// Columns and lines.
const SMALLEST: (u16, u16) = (60, 16);
/// Below, curves, bars and devices make room for words.
const NARROW: u16 = 80;
/// From here on details stand beside the list.
const WIDE: u16 = 140;
