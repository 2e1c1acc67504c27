//! The table of the nodes.

use ratatui::Frame;
use ratatui::layout::{Constraint, Rect};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Cell, Row, Table, TableState};

use super::bar::{bar, position};
use super::{NARROW, nothing, pane};
use crate::live::monitor::model::{NodePicture, words};
use crate::live::monitor::screen::Scene;
use crate::live::monitor::screen::player::Playback;
use crate::live::monitor::screen::view::Focus;
use crate::live::monitor::words::{connections, device, fit, or_dash, percent, time};

pub(super) fn draw(frame: &mut Frame<'_>, scene: &Scene<'_>, area: Rect) {
    let Scene { theme, view, picture, .. } = scene;
    let nodes = view.nodes(picture);
    let is_focused = view.focus == Focus::Nodes;
    let block = pane(*theme, format!("Nodes {} · {}", nodes.len(), view.sort.words()), is_focused);
    if nodes.is_empty() {
        let inner = block.inner(area);
        frame.render_widget(block, area);
        let words = match scene.playback {
            Playback::Ended if picture.counters.frames == 0 => "there was no frame",
            Playback::Ended => "nobody was heard",
            _ => "nobody was heard yet",
        };
        return frame.render_widget(nothing(*theme, words), inner);
    }
    let widths = Widths::of(area.width);
    let place = view.place(&nodes);
    let mut heading = vec!["MAC", "state"];
    heading.extend((widths.device > 0).then_some("device"));
    heading.extend(widths.owner.then_some("owner"));
    heading.extend(["connections", "  load", widths.response, "fault"]);
    let rows = nodes.iter().map(|node| row(scene, node, &widths));
    let table = Table::new(rows, widths.constraints())
        .header(Row::new(heading.into_iter().map(Cell::from)).style(theme.heading()))
        .column_spacing(1)
        .row_highlight_style(theme.selected(is_focused))
        .block(block);
    let mut state = TableState::new().with_selected(place);
    frame.render_stateful_widget(table, area, &mut state);
}

fn row<'a>(scene: &Scene<'_>, node: &NodePicture, widths: &Widths) -> Row<'a> {
    let Scene { theme, view, picture, .. } = scene;
    let access = node.record.access;
    let mut cells = vec![
        Cell::from(format!("{:>3}", node.mac().number())),
        Cell::from(Span::styled(words(access), theme.access(access))),
    ];
    cells.extend((widths.device > 0).then(|| Cell::from(device(node, widths.device.into()))));
    if widths.owner {
        cells.push(Cell::from(format!("{:>5}", or_dash(node.record.master))));
    }
    let fault = view.fault(picture, node.mac()).map_or_else(Span::default, |fault| {
        let title = fault.finding.rule.words();
        let words = if fault.is_over() { format!("over: {title}") } else { title.to_owned() };
        let style = if fault.is_over() { theme.dim() } else { theme.severity(fault.finding.severity) };
        Span::styled(fit(&words, widths.fault.into()), style)
    });
    cells.extend([
        Cell::from(fit(&connections(node), widths.connections.into())),
        Cell::from(format!("{:>6}", percent(node.load).replace(' ', ""))),
        Cell::from(response(scene, node, widths)),
        Cell::from(fault),
    ]);
    Row::new(cells)
}

/// The longest response time, as a bar and in words.
fn response<'a>(scene: &Scene<'_>, node: &NodePicture, widths: &Widths) -> Line<'a> {
    let theme = scene.theme;
    let Some(times) = node.io else { return Line::styled("-", theme.dim()) };
    let text = time(Some(times.max));
    match node.worst() {
        Some(worst) => {
            let share = position(worst);
            Line::from(vec![
                Span::styled(bar(share, widths.bar.into()), theme.bar(worst)),
                Span::raw(format!("{text:>9}")),
            ])
        }
        None => Line::from(format!("{:>width$}", text, width = usize::from(widths.bar) + 9)),
    }
}

/// What there is room for.
struct Widths {
    device: u16,
    owner: bool,
    connections: u16,
    bar: u16,
    /// What the others leave.
    fault: u16,
    /// The heading of the bar.
    response: &'static str,
}

impl Widths {
    fn of(width: u16) -> Self {
        let wide = "slowest of 4 x EPR";
        let (device, owner, connections, bar, response) = match width {
            0..NARROW => (0, false, 12 + width.saturating_sub(60) / 2, 0, "  slowest"),
            NARROW..=99 => (12 + width.saturating_sub(80) / 2, false, 14, 4, "slowest"),
            100..=129 => (20, true, 18, 9, wide),
            _ => (24, true, 24, 9, wide),
        };
        let widths = Self { device, owner, connections, bar, fault: 0, response };
        let taken: u16 = widths.columns().iter().map(|column| column + 1).sum();
        Self { fault: width.saturating_sub(taken + BORDERS), ..widths }
    }

    /// All but the last.
    fn columns(&self) -> Vec<u16> {
        let mut columns = vec![3, 10];
        columns.extend((self.device > 0).then_some(self.device));
        columns.extend(self.owner.then_some(5));
        columns.extend([self.connections, 6, self.bar + 9]);
        columns
    }

    fn constraints(&self) -> impl Iterator<Item = Constraint> {
        self.columns().into_iter().chain([self.fault]).map(Constraint::Length)
    }
}

/// At the left and the right of the table.
const BORDERS: u16 = 2;
