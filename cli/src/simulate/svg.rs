//! The time line as a picture: a row for each node, coloured by its state, and the bus load beneath.

mod headings;
mod legend;

use core::fmt::Write as _;

use link_core::Instant;

use super::load::Busy;
use super::picture::{Picture, Row};
use headings::{Heading, LANE, headings, lanes};
use legend::{LEGEND_TOP, LegendItem, legend, legend_items};

/// Draws it.
pub(super) fn draw(picture: &Picture) -> String {
    let layout = Layout::of(picture);
    let mut svg = String::new();
    let _ = writeln!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{}\" viewBox=\"0 0 {WIDTH} {}\" \
         font-family=\"system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif\" font-size=\"12\" fill=\"#212529\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n\
         <text x=\"{MARGIN}\" y=\"30\" font-size=\"18\" font-weight=\"600\">{}</text>",
        layout.height,
        layout.height,
        escape(&picture.title)
    );
    legend(&mut svg, &layout.legend);
    axis(&mut svg, &layout);
    for (index, row) in picture.rows.iter().enumerate() {
        node(&mut svg, &layout, index, row);
    }
    load(&mut svg, &layout, picture);
    headings(&mut svg, &layout, picture);
    svg.push_str("</svg>\n");
    svg
}

/// Where things are, in pixels.
struct Layout {
    left: f64,
    end: Instant,
    legend: Vec<LegendItem>,
    notes_top: f64,
    rows_top: f64,
    row: f64,
    load_top: f64,
    height: f64,
    /// Of each heading.
    lanes: Vec<usize>,
}

impl Layout {
    fn of(picture: &Picture) -> Self {
        let row = if picture.rows.len() > CROWD { 13.0 } else { 26.0 };
        let longest = picture.rows.iter().map(label_length).max().unwrap_or(0);
        let left = (longest as f64 * LABEL_LETTER + 2.0 * MARGIN).max(110.0);
        let end = picture.end;
        let legend = legend_items(picture);
        let notes_top = legend.last().map_or(LEGEND_TOP, |item| item.y) + 32.0;
        let lanes = lanes(&picture.notes, |at, text| Heading::of(place(at, left, end), text));
        let count = lanes.iter().max().map_or(0, |last| last + 1);
        let rows_top = notes_top + count as f64 * LANE;
        let load_top = rows_top + picture.rows.len() as f64 * row + 34.0;
        let height = load_top + LOAD_HEIGHT + 52.0;
        Self { left, end, legend, notes_top, rows_top, row, load_top, height, lanes }
    }

    /// Where a moment is.
    fn x(&self, at: Instant) -> f64 {
        place(at, self.left, self.end)
    }
}

fn place(at: Instant, left: f64, end: Instant) -> f64 {
    let share = at.min(end).as_nanos() as f64 / end.as_nanos().max(1) as f64;
    left + share * (WIDTH - MARGIN - left)
}

/// Time below, with a grid through everything.
fn axis(svg: &mut String, layout: &Layout) {
    let bottom = layout.load_top + LOAD_HEIGHT;
    let step = tick_step(layout.end);
    let mut at = Instant::ZERO;
    while at <= layout.end {
        let x = layout.x(at);
        let seconds = at.as_nanos() as f64 / 1e9;
        let _ = writeln!(
            svg,
            "<line x1=\"{x:.1}\" y1=\"{:.1}\" x2=\"{x:.1}\" y2=\"{bottom:.1}\" stroke=\"#dee2e6\"/>\
             <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"#495057\">{seconds}</text>",
            layout.rows_top,
            bottom + 16.0
        );
        at = Instant::from_nanos(at.as_nanos() + step);
    }
    let _ = writeln!(
        svg,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"#495057\">time in seconds</text>",
        (layout.left + WIDTH - MARGIN) / 2.0,
        bottom + 36.0
    );
}

/// Letters of the label of a row.
fn label_length(row: &Row) -> usize {
    name(row).chars().count() + row.detail.chars().count() + 2
}

/// The name of a node, cut where it would leave no room for the time line.
fn name(row: &Row) -> String {
    if row.name.chars().count() <= LONGEST_NAME {
        return row.name.clone();
    }
    row.name.chars().take(LONGEST_NAME - 1).chain(['…']).collect()
}

fn node(svg: &mut String, layout: &Layout, index: usize, row: &Row) {
    let y = layout.rows_top + index as f64 * layout.row;
    let height = layout.row * 0.72;
    let size = if layout.row < 20.0 { 9.5 } else { 12.0 };
    let _ = writeln!(
        svg,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\" font-size=\"{size}\">{} \
         <tspan fill=\"#868e96\">{}</tspan></text>",
        layout.left - 10.0,
        y + layout.row / 2.0 + size * 0.36,
        escape(&name(row)),
        escape(&row.detail)
    );
    for (place, (from, shade)) in row.states().iter().enumerate() {
        let to = row.states().get(place + 1).map_or(layout.end, |(at, _)| *at);
        let (x, end) = (layout.x(*from), layout.x(to));
        if to <= *from {
            continue;
        }
        let _ = writeln!(
            svg,
            "<rect x=\"{x:.2}\" y=\"{:.1}\" width=\"{:.2}\" height=\"{height:.1}\" fill=\"{}\"/>",
            y + (layout.row - height) / 2.0,
            (end - x).max(0.6),
            shade.colour()
        );
    }
}

/// The share of each slice of time in which the bus was busy, exact.
fn load(svg: &mut String, layout: &Layout, picture: &Picture) {
    let bottom = layout.load_top + LOAD_HEIGHT;
    for (percent, words) in [(0, "0 %"), (50, "50 %"), (100, "100 %")] {
        let y = bottom - LOAD_HEIGHT * f64::from(percent) / 100.0;
        let _ = writeln!(
            svg,
            "<line x1=\"{:.1}\" y1=\"{y:.1}\" x2=\"{:.1}\" y2=\"{y:.1}\" stroke=\"#dee2e6\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\" fill=\"#495057\">{words}</text>",
            layout.left,
            WIDTH - MARGIN,
            layout.left - 10.0,
            y + 4.0
        );
    }
    let (length, slices) = picture.load.slices(layout.end, SLICES);
    let _ = writeln!(
        svg,
        "<text x=\"{:.1}\" y=\"{:.1}\" font-weight=\"600\">bus load, by slices of {}</text>",
        layout.left,
        layout.load_top - 8.0,
        crate::scenario::Time(core::time::Duration::from_nanos(length))
    );
    let (all, errors) = (|busy: &Busy| busy.all, |busy: &Busy| busy.errors);
    for (part, colour) in [(all as fn(&Busy) -> u64, LOAD_COLOUR), (errors, ERROR_COLOUR)] {
        let mut path = format!("M{:.1} {bottom:.1}", layout.left);
        for (index, busy) in slices.iter().enumerate() {
            let from = Instant::from_nanos(index as u64 * length);
            let to = Instant::from_nanos((index as u64 + 1) * length).min(layout.end);
            // The last slice may be shorter, and both parts of a bus that is cut may be busy.
            let share = part(busy) as f64 / to.saturating_since(from).as_nanos().max(1) as f64;
            let y = bottom - LOAD_HEIGHT * share.min(1.0);
            let _ = write!(path, "L{:.1} {y:.1}L{:.1} {y:.1}", layout.x(from), layout.x(to));
        }
        let _ = write!(path, "L{:.1} {bottom:.1}Z", layout.x(layout.end));
        let _ = writeln!(svg, "<path d=\"{path}\" fill=\"{colour}\" fill-opacity=\"0.85\"/>");
    }
}

/// 1, 2 or 5 times a power of ten, in nanoseconds, so that there are at most twelve.
fn tick_step(end: Instant) -> u64 {
    let mut power = 1_u64;
    loop {
        for step in [power, 2 * power, 5 * power] {
            if end.as_nanos() / step <= 12 {
                return step;
            }
        }
        power *= 10;
    }
}

/// XML has no characters for most of the control codes, whichever way they are written.
fn escape(text: &str) -> String {
    let text = text.replace(|c: char| c.is_control(), "\u{fffd}");
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

const WIDTH: f64 = 1200.0;
const MARGIN: f64 = 20.0;
const LABEL_LETTER: f64 = 6.9;
const LONGEST_NAME: usize = 60;
const LOAD_HEIGHT: f64 = 110.0;
const LOAD_COLOUR: &str = "#4a6fa5";
const ERROR_COLOUR: &str = "#d64545";
const SLICES: u64 = 400;
/// More rows than this are drawn thinner.
const CROWD: usize = 24;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::picture::Shade;

    fn picture(rows: Vec<Row>) -> Picture {
        Picture { end: Instant::from_millis(1_000), rows, ..Picture::default() }
    }

    fn row(name: &str) -> Row {
        Row::new(name.to_owned(), "MAC 1".to_owned())
    }

    #[test]
    fn ticks_are_round_and_few() {
        for (millis, step) in
            [(10_000, 1_000_000_000), (13_000, 2_000_000_000), (120_000, 10_000_000_000), (7, 1_000_000)]
        {
            assert_eq!(tick_step(Instant::from_millis(millis)), step, "{millis}");
        }
    }

    #[test]
    fn words_cannot_break_the_picture() {
        let mut picture = picture(vec![row("a<b")]);
        picture.title = "bell \u{7} & escape \u{1b}".to_owned();
        let svg = draw(&picture);
        assert!(svg.contains("a&lt;b") && !svg.contains("a<b"));
        assert!(svg.contains("bell \u{fffd} &amp; escape \u{fffd}"));
    }

    #[test]
    fn a_cable_that_is_unplugged_is_not_a_lack_of_power() {
        let mut cut = row("a");
        cut.enter(Instant::from_millis(10), Shade::OnLine);
        cut.enter(Instant::from_millis(500), Shade::Cut);
        let svg = draw(&picture(vec![cut]));
        assert!(svg.contains(">no power<") && svg.contains(">cable unplugged<"));
        let bars = svg.matches(Shade::Cut.colour()).count();
        assert_eq!(bars, 2, "one in the legend, one in the row");
    }

    #[test]
    fn a_long_name_leaves_room_for_the_time_line() {
        let layout = Layout::of(&picture(vec![row(&"n".repeat(500))]));
        assert!(layout.left < WIDTH / 2.0, "{}", layout.left);
    }

    #[test]
    fn the_last_slice_is_measured_by_its_own_length() {
        let mut picture = picture(vec![row("a")]);
        // 400 slices of 3 ms would be 1.2 s.
        picture.end = Instant::from_millis(1_001);
        picture.load.add(Instant::ZERO, picture.end, false);
        let svg = draw(&picture);
        let top = svg.lines().find(|line| line.contains(LOAD_COLOUR) && line.contains("<path")).unwrap();
        let heights: std::collections::BTreeSet<&str> =
            top.split('L').skip(1).filter_map(|point| point.split(' ').nth(1)).collect();
        // And the bottom, where the path ends.
        assert_eq!(heights.len(), 2, "100 % from the beginning to the end: {heights:?}");
    }
}
