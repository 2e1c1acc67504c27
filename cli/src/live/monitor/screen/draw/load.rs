//! What the bus is used for.

use devicenet_core::doctor::Severity;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::bar::curve;
use super::pane;
use crate::live::monitor::model::Purpose;
use crate::live::monitor::screen::Scene;
use crate::live::monitor::words::percent;

pub(super) fn draw(frame: &mut Frame<'_>, scene: &Scene<'_>, area: Rect) {
    let Scene { theme, picture, .. } = scene;
    let title = if area.width > WITHOUT_CURVE { "Bus load by purpose" } else { "Bus load" };
    let block = pane(*theme, title.to_owned(), false);
    let inner = block.inner(area);
    frame.render_widget(block, area);
    let width = usize::from(inner.width).saturating_sub(NAME + FIGURE + 1);
    let all = |second: &[f64; Purpose::COUNT]| second.iter().sum::<f64>();
    let recent = &picture.history[picture.history.len().saturating_sub(width)..];
    let most = recent.iter().map(all).fold(0.0, f64::max);
    let line = |name: &str, share: f64, style: Style, values: Vec<f64>| {
        Line::from(vec![
            Span::raw(format!("{name:<NAME$}")),
            Span::raw(format!("{:>FIGURE$} ", percent(share))),
            Span::styled(curve(values.into_iter(), most, width), style),
        ])
    };
    let mut lines =
        vec![line("all", picture.load.all, theme.bar(picture.load.all), recent.iter().map(all).collect())];
    let share = |purpose: &Purpose| picture.total.by_purpose[purpose.index()];
    let mut used: Vec<Purpose> = Purpose::ALL.into_iter().filter(|purpose| share(purpose) > 0.0).collect();
    // Without room for all, the smallest are left out.
    while used.len() + 1 > usize::from(inner.height) {
        let smallest = used.iter().enumerate().min_by(|(_, a), (_, b)| share(a).total_cmp(&share(b)));
        match smallest.map(|(place, _)| place) {
            Some(place) => _ = used.remove(place),
            None => break,
        }
    }
    for purpose in used {
        let style = match purpose {
            Purpose::Errors | Purpose::Foreign => theme.severity(Severity::Warning),
            _ => theme.border(true),
        };
        let values = recent.iter().map(|second| second[purpose.index()]).collect();
        lines.push(line(purpose.words(), picture.load.by_purpose[purpose.index()], style, values));
    }
    frame.render_widget(Paragraph::new(lines), inner);
}

/// Columns of the pane with borders, names and percentages only.
pub(super) const WITHOUT_CURVE: u16 = 21;
/// Columns of the names and of the percentages.
const NAME: usize = 12;
const FIGURE: usize = 7;
