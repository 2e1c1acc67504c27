//! All that is known of a node.

use core::time::Duration;

use devicenet_core::monitor::{ConnectionRecord, ConnectionState};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Cell, Paragraph, Row, Table};

use super::{indented, nothing, pane};
use crate::live::monitor::model::{NodePicture, Times, words};
use crate::live::monitor::screen::Scene;
use crate::live::monitor::words::{
    device, exact_time, or_dash, percent, short, state_words, time, watchdog_words,
};

pub(super) fn draw(frame: &mut Frame<'_>, scene: &Scene<'_>, area: Rect) {
    let Scene { theme, view, picture, .. } = scene;
    let nodes = view.nodes(picture);
    let node = nodes.get(view.place(&nodes));
    let title = node.map_or_else(
        || "Node".to_owned(),
        |node| match device(node, area.width.into()).as_str() {
            "-" => format!("Node {}", node.mac()),
            device => format!("Node {} · {device}", node.mac()),
        },
    );
    let block = pane(*theme, title, false);
    let inner = block.inner(area);
    frame.render_widget(block, area);
    let Some(node) = node else {
        return frame.render_widget(nothing(*theme, "no node to show"), inner);
    };
    let facts = facts(scene, node, inner.width);
    let [top, _, bottom] = inner.layout(&Layout::vertical([
        Constraint::Length(facts.len() as u16),
        Constraint::Length(u16::from(inner.height > 10)),
        Constraint::Fill(1),
    ]));
    frame.render_widget(Paragraph::new(facts), top);
    connections(frame, scene, node, bottom);
}

fn facts<'a>(scene: &Scene<'_>, node: &NodePicture, width: u16) -> Vec<Line<'a>> {
    let theme = scene.theme;
    let record = &node.record;
    let fact = |name: &str, value: Vec<String>| {
        indented(Span::styled(format!("{name:<10}"), theme.dim()), &value.join(", "), width, Style::new())
    };
    let roles = record.roles.to_string();
    let mut state = vec![words(record.access).to_owned()];
    state.extend((!roles.is_empty()).then_some(roles));
    state.extend(record.master.map(|master| format!("owner {master}")));
    state.extend(node.silent.map(|silent| format!("heard {} ago", span(silent))));
    let mut identity = Vec::new();
    identity.extend(record.vendor.map(|vendor| format!("vendor {}", vendor.0)));
    identity.extend(record.device_type.map(|device| format!("type {}", device.0)));
    identity.extend(record.product.map(|product| format!("product {product}")));
    identity.extend(record.revision.map(|(major, minor)| format!("rev {major}.{minor}")));
    identity.extend(record.serial.map(|serial| format!("serial 0x{serial:08X}")));
    if identity.is_empty() {
        identity.push("not told yet".to_owned());
    }
    let traffic = vec![
        format!("load {} now, {} in all", percent(node.load), percent(node.total)),
        format!("{} frames", record.traffic.frames),
        format!("{} error responses", record.traffic.error_responses),
    ];
    let mut facts = [fact("state", state), fact("identity", identity), fact("traffic", traffic)].concat();
    if let Some(times) = node.io {
        let limit = node.limit.map(|limit| format!("of {} ms", limit.as_millis()));
        facts.extend(fact("I/O", [responses(times), limit.into_iter().collect()].concat()));
    }
    if let Some(times) = node.explicit {
        facts.extend(fact("explicit", responses(times)));
    }
    facts
}

fn responses(times: Times) -> Vec<String> {
    let Times { count, p50, p99, max } = times;
    vec![
        format!("{count} answers"),
        format!("p50 {}", time(Some(p50))),
        format!("p99 {}", time(Some(p99))),
        format!("max {}", exact_time(Some(max))),
    ]
}

fn connections(frame: &mut Frame<'_>, scene: &Scene<'_>, node: &NodePicture, area: Rect) {
    let theme = scene.theme;
    // Of those that are gone, the ones that were there.
    let seen: Vec<&ConnectionRecord> = (node.connections.iter())
        .filter(|connection| connection.frames > 0 || connection.state != ConnectionState::NonExistent)
        .collect();
    if seen.is_empty() {
        return frame.render_widget(nothing(theme, "no connection was seen"), area);
    }
    let heading = ["connection", "state", "EPR", "in", "out", "path", "watchdog"];
    let rows = seen.into_iter().map(|connection| row(scene, connection));
    let widths = [10, 11, 8, 4, 4, 8, 8].map(Constraint::Length);
    let table = Table::new(rows, widths).header(Row::new(heading).style(theme.heading())).column_spacing(1);
    frame.render_widget(table, area);
}

fn row<'a>(scene: &Scene<'_>, connection: &ConnectionRecord) -> Row<'a> {
    let state = Span::styled(state_words(connection.state), scene.theme.connection(connection.state));
    let path = match (connection.consumed_path, connection.produced_path) {
        (None, None) => "-".to_owned(),
        (consumed, produced) => {
            format!("{}→{}", or_dash(consumed.map(|path| path.0)), or_dash(produced.map(|path| path.0)))
        }
    };
    Row::new([
        Cell::from(short(&connection.name)),
        Cell::from(state),
        Cell::from(connection.epr.map_or_else(|| "-".to_owned(), |epr| format!("{epr} ms"))),
        Cell::from(or_dash(connection.consumed_size)),
        Cell::from(or_dash(connection.produced_size)),
        Cell::from(path),
        Cell::from(connection.watchdog_action.map_or("-", watchdog_words)),
    ])
}

/// `0.6 s`, `3 min`
fn span(span: Duration) -> String {
    match span.as_secs() {
        0..60 => format!("{:.1} s", span.as_secs_f64()),
        seconds @ 60..7200 => format!("{} min", seconds / 60),
        seconds => format!("{} h", seconds / 3600),
    }
}
