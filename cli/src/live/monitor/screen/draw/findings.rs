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
use crate::verdict::State;

pub(super) fn draw(frame: &mut Frame<'_>, scene: &Scene<'_>, area: Rect) {
    let Scene { theme, view, picture, .. } = scene;
    let findings = view.findings(picture);
    let is_focused = view.focus == Focus::Findings;
    let block = pane(*theme, title(&findings), is_focused);
    let inner = block.inner(area);
    frame.render_widget(block, area);
    if findings.is_empty() {
        let words = match picture.verdict.state() {
            State::Silent => "nothing was heard",
            State::Unread => "nothing in what could be read",
            State::WasWrong => "nothing more",
            State::Healthy | State::Wrong => "nothing is wrong",
        };
        return frame.render_widget(nothing(*theme, words), inner);
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

/// How many last, by severity, and how many are over: `Findings ✖1 ▲2 · 3 over`.
fn title(findings: &[&FindingPicture]) -> String {
    let mut title = "Findings".to_owned();
    for severity in [Severity::Error, Severity::Warning, Severity::Info] {
        let last = |finding: &&&FindingPicture| !finding.is_over() && finding.finding.severity == severity;
        match findings.iter().filter(last).count() {
            0 => {}
            number => title += &format!(" {}{number}", mark(severity)),
        }
    }
    match findings.iter().filter(|finding| finding.is_over()).count() {
        0 => title,
        over => format!("{title} · {over} over"),
    }
}

const fn mark(severity: Severity) -> char {
    match severity {
        Severity::Error => '✖',
        Severity::Warning => '▲',
        Severity::Info => '●',
    }
}

/// The selected finding is in sight, with what explains it.
fn first(place: usize, height: u16) -> usize {
    place.saturating_sub(usize::from(height.saturating_sub(6) / 2))
}

fn headline<'a>(scene: &Scene<'_>, finding: &FindingPicture, width: u16) -> Line<'a> {
    let theme = scene.theme;
    let mark = mark(finding.finding.severity);
    let style = if finding.is_over() { theme.dim() } else { theme.severity(finding.finding.severity) };
    let who = finding.finding.node.map_or_else(|| "bus".to_owned(), |node| format!("node {node}"));
    let words = format!("{who}: {}", finding.finding.rule.words());
    let [long, short] = match finding.until {
        None => [format!("since {}", clock(finding.since)), clock(finding.since)],
        Some(until) => [format!("over {}", clock(until)), "over".to_owned()],
    };
    let room = |when: &str| usize::from(width).saturating_sub(when.chars().count() + 3);
    let when = if words.chars().count() <= room(&long) { long } else { short };
    let room = room(&when);
    let words = fit(&words, room);
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
