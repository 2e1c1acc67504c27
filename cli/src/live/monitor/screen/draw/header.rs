//! Interface, bit rate, state; load and counters.

use devicenet_core::doctor::Severity;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Modifier;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::bar::bar;
use crate::live::monitor::model::FindingPicture;
use crate::live::monitor::screen::Scene;
use crate::live::monitor::screen::player::{Playback, Speed};
use crate::live::monitor::words::{clock, fit, percent};
use crate::text::{count, printable};

pub(super) fn draw(frame: &mut Frame<'_>, scene: &Scene<'_>, area: Rect) {
    let [first, second] = area.layout(&Layout::vertical([Constraint::Length(1); 2]));
    let right = state(scene);
    let [left, end] =
        first.layout(&Layout::horizontal([Constraint::Fill(1), Constraint::Length(right.width() as u16)]));
    frame.render_widget(Paragraph::new(title(scene, left.width)), left);
    frame.render_widget(Paragraph::new(right), end);
    frame.render_widget(Paragraph::new(figures(scene, second.width)), second);
}

fn title<'a>(scene: &Scene<'_>, width: u16) -> Line<'a> {
    let Scene { theme, picture, .. } = scene;
    let (name, bit_rate) = (" DeviceNet ", format!(" {}", picture.bit_rate));
    let room = usize::from(width).saturating_sub(name.len() + 2);
    let endpoint = printable(scene.title);
    let has_room = endpoint.chars().count() + bit_rate.len() <= room;
    let mut spans = vec![
        Span::styled(name, theme.title().add_modifier(Modifier::REVERSED)),
        Span::styled(format!(" {}", fit(&endpoint, room)), theme.heading()),
    ];
    spans.extend(has_room.then(|| Span::styled(bit_rate, theme.dim())));
    Line::from(spans)
}

fn state<'a>(scene: &Scene<'_>) -> Line<'a> {
    let Scene { theme, picture, .. } = scene;
    let playback = match scene.playback {
        Playback::Live => "live".to_owned(),
        Playback::Frozen => "PAUSED, the bus goes on".to_owned(),
        Playback::Playing(speed) => format!("playing {}", speed_words(speed)),
        Playback::Paused(speed) => format!("PAUSED {}", speed_words(speed)),
        Playback::Ended => "END".to_owned(),
    };
    let is_moving = matches!(scene.playback, Playback::Live | Playback::Playing(_));
    let counters = match (picture.counters.tec, picture.counters.rec) {
        (Some(tec), Some(rec)) => format!(" TEC {tec} REC {rec}"),
        _ => String::new(),
    };
    Line::from(vec![
        Span::styled(picture.link.to_string(), theme.link(picture.link)),
        Span::styled(counters, theme.dim()),
        Span::raw("   "),
        Span::styled(clock(picture.at), theme.heading()),
        Span::raw("  "),
        Span::styled(playback, if is_moving { theme.dim() } else { theme.severity(Severity::Warning) }),
        Span::raw(" "),
    ])
}

fn figures<'a>(scene: &Scene<'_>, width: u16) -> Line<'a> {
    let Scene { theme, picture, view, .. } = scene;
    let counters = picture.counters;
    let load = picture.load.all;
    let at_most = if picture.bit_rate.known().is_some() { "" } else { "≤" };
    let is_wrong =
        |finding: &&FindingPicture| !finding.is_over() && finding.finding.severity > Severity::Info;
    let findings = picture.findings.iter().filter(is_wrong).count();
    let worst = view.findings(picture).into_iter().find(is_wrong);
    let good = if scene.bad_entries == 0 { theme.good() } else { theme.severity(Severity::Warning) };
    let findings_style = worst.map_or(good, |finding| theme.severity(finding.finding.severity));
    let counted = |number: u64, what: &str| {
        let style = if number == 0 { theme.dim() } else { theme.severity(Severity::Warning) };
        Span::styled(format!("  {number} {what}"), style)
    };
    let health = match findings {
        // Nobody knows what they were.
        0 if scene.bad_entries > 0 => format!("  {} unread", scene.bad_entries),
        0 if counters.frames == 0 => "  silent".to_owned(),
        0 => "  healthy".to_owned(),
        number => format!("  {}", count(number as u64, "finding")),
    };
    let mut spans = vec![
        Span::styled(" load ", theme.dim()),
        Span::styled("▕", theme.dim()),
        Span::styled(bar(load, usize::from(width / 5)), theme.bar(load)),
        Span::styled("▏", theme.dim()),
        Span::styled(
            format!("{:>7}", format!("{at_most}{}", percent(load))),
            theme.bar(load).add_modifier(Modifier::BOLD),
        ),
        Span::styled(format!("  {}", count(counters.frames, "frame")), theme.dim()),
        counted(counters.error_frames, "errors"),
        counted(counters.lost, "lost"),
        Span::styled(health, findings_style.add_modifier(Modifier::BOLD)),
    ];
    if width >= 110 {
        spans.push(counted(counters.problems, "frames with a problem"));
    }
    Line::from(spans)
}

fn speed_words(speed: Speed) -> String {
    match speed {
        Speed::Times(times) => format!("{times}x"),
        Speed::Full => "at full speed".to_owned(),
    }
}
