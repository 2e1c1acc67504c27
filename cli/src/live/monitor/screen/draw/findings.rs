//! What is wrong, since when, why, and what to check.

use devicenet_core::doctor::Severity;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::{indented, nothing, pane};
use crate::live::monitor::model::FindingPicture;
use crate::live::monitor::screen::Scene;
use crate::live::monitor::screen::view::Focus;
use crate::live::monitor::words::{clock, fit};

pub(super) fn draw(frame: &mut Frame<'_>, scene: &Scene<'_>, area: Rect) {
    let Scene { theme, view, picture, .. } = scene;
    let findings = view.findings(picture);
    let is_focused = view.focus == Focus::Findings;
    let open = findings.iter().filter(|finding| !finding.is_over()).count();
    let title = match findings.len() - open {
        0 => format!("Findings {open}"),
        over => format!("Findings {open} · {over} over"),
    };
    let block = pane(*theme, title, is_focused);
    let inner = block.inner(area);
    frame.render_widget(block, area);
    if findings.is_empty() {
        return frame.render_widget(nothing(*theme, "nothing is wrong"), inner);
    }
    let place = view.finding_place(&findings);
    let mut lines = Vec::new();
    for (index, finding) in findings.iter().enumerate().skip(first(place, inner.height)) {
        let is_selected = index == place;
        let style = if is_selected && is_focused { theme.selected(true) } else { Style::new() };
        lines.push(headline(scene, finding, inner.width).style(style));
        if is_selected {
            lines.extend(explanation(scene, finding, inner.width));
        }
    }
    frame.render_widget(Paragraph::new(lines), inner);
}

/// The selected finding is in sight, with what explains it.
fn first(place: usize, height: u16) -> usize {
    place.saturating_sub(usize::from(height.saturating_sub(6) / 2))
}

fn headline<'a>(scene: &Scene<'_>, finding: &FindingPicture, width: u16) -> Line<'a> {
    let theme = scene.theme;
    let mark = match finding.finding.severity {
        Severity::Error => "✖",
        Severity::Warning => "▲",
        Severity::Info => "●",
    };
    let style = if finding.is_over() { theme.dim() } else { theme.severity(finding.finding.severity) };
    let who = finding.finding.node.map_or_else(|| "bus".to_owned(), |node| format!("node {node}"));
    let when = match finding.until {
        None => format!("since {}", clock(finding.since)),
        Some(until) => format!("over {}", clock(until)),
    };
    let room = usize::from(width).saturating_sub(when.chars().count() + 3);
    let words = fit(&format!("{who}: {}", finding.finding.rule.words()), room);
    let gap = room.saturating_sub(words.chars().count());
    Line::from(vec![
        Span::styled(format!("{mark} "), style),
        Span::styled(words, style),
        Span::styled(format!("{}{when}", " ".repeat(gap + 1)), theme.dim()),
    ])
}

fn explanation<'a>(scene: &Scene<'_>, finding: &FindingPicture, width: u16) -> Vec<Line<'a>> {
    let theme = scene.theme;
    let finding = &finding.finding;
    let mut lines = indented(Span::raw("  "), &finding.to_string(), width, Style::new());
    lines.extend(indented(
        Span::styled("  → ", theme.good()),
        &finding.advice().to_string(),
        width,
        theme.good(),
    ));
    let mut facts = vec![finding.severity.name().to_owned(), format!("seen {} x", finding.count)];
    facts.extend(finding.scanner_status().map(|status| format!("scanner code {}", status.0)));
    let frames: Vec<String> = finding.evidence.frames().iter().map(|n| format!("#{n}")).collect();
    if !frames.is_empty() {
        facts.push(format!("frames {}", frames.join(" ")));
    }
    lines.extend(indented(Span::raw("  "), &facts.join(", "), width, theme.dim()));
    lines
}
