//! The time line as a picture: a row for each node, coloured by its state, and the bus load beneath.

use core::fmt::Write as _;

use link_core::Instant;

/// What a picture shows.
#[derive(Clone, Debug, Default)]
pub(super) struct Picture {
    pub(super) title: String,
    pub(super) end: Instant,
    pub(super) rows: Vec<Row>,
    /// Headings at their times.
    pub(super) notes: Vec<(Instant, String)>,
    /// What the bus was busy with.
    pub(super) busy: Vec<Busy>,
}

/// A node.
#[derive(Clone, Debug)]
pub(super) struct Row {
    pub(super) name: String,
    /// A few words under or beside the name, such as `MAC 10`.
    pub(super) detail: String,
    /// From when on it was what; each lasts until the next.
    pub(super) states: Vec<(Instant, Shade)>,
}

/// What a node is, as far as a colour tells it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Shade {
    Off,
    Sending,
    Waiting,
    OnLine,
    Fault,
    BusOff,
    /// It has no state of network access, and is there.
    Present,
}

/// A time in which the bus was not idle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Busy {
    pub(super) from: Instant,
    pub(super) to: Instant,
    /// It ended in an error frame.
    pub(super) error: bool,
}

impl Shade {
    const LEGEND: [(Self, &'static str); 7] = [
        (Self::Off, "no power"),
        (Self::Sending, "sending the check"),
        (Self::Waiting, "waiting 1 s"),
        (Self::OnLine, "on line"),
        (Self::Fault, "communication fault"),
        (Self::BusOff, "bus-off"),
        (Self::Present, "attached"),
    ];

    const fn colour(self) -> &'static str {
        match self {
            Self::Off => "#e9ecef",
            Self::Sending => "#f4a259",
            Self::Waiting => "#f6d55c",
            Self::OnLine => "#4caf7a",
            Self::Fault => "#d64545",
            Self::BusOff => "#5b1a2b",
            Self::Present => "#7b9acc",
        }
    }
}

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
    legend(&mut svg, picture);
    axis(&mut svg, &layout);
    for (index, row) in picture.rows.iter().enumerate() {
        node(&mut svg, &layout, index, row);
    }
    load(&mut svg, &layout, picture);
    notes(&mut svg, &layout, picture);
    svg.push_str("</svg>\n");
    svg
}

/// Where things are, in pixels.
struct Layout {
    left: f64,
    end: Instant,
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
        let longest = picture.rows.iter().map(|row| row.name.len() + row.detail.len() + 2).max().unwrap_or(0);
        let left = (longest as f64 * 6.9 + 2.0 * MARGIN).max(110.0);
        let x = |at: Instant| place(at, left, picture.end);
        let lanes = lanes(&picture.notes, x);
        let count = lanes.iter().max().map_or(0, |last| last + 1);
        let rows_top = NOTES_TOP + count as f64 * LANE;
        let load_top = rows_top + picture.rows.len() as f64 * row + 34.0;
        Self { left, end: picture.end, rows_top, row, load_top, height: load_top + LOAD_HEIGHT + 52.0, lanes }
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

fn legend(svg: &mut String, picture: &Picture) {
    let shown = |shade: Shade| picture.rows.iter().any(|row| row.states.iter().any(|(_, own)| *own == shade));
    let mut x = MARGIN;
    for (shade, words) in Shade::LEGEND.iter().filter(|(shade, _)| shown(*shade)) {
        let _ = writeln!(
            svg,
            "<rect x=\"{x:.1}\" y=\"46\" width=\"14\" height=\"14\" rx=\"3\" fill=\"{}\"/>\
             <text x=\"{:.1}\" y=\"57.5\">{words}</text>",
            shade.colour(),
            x + 20.0
        );
        x += 20.0 + words.len() as f64 * 6.6 + 22.0;
    }
    for (colour, words) in [(LOAD_COLOUR, "bus load"), (ERROR_COLOUR, "of it destroyed by errors")] {
        let _ = writeln!(
            svg,
            "<rect x=\"{x:.1}\" y=\"50\" width=\"14\" height=\"6\" fill=\"{colour}\"/>\
             <text x=\"{:.1}\" y=\"57.5\">{words}</text>",
            x + 20.0
        );
        x += 20.0 + words.len() as f64 * 6.6 + 22.0;
    }
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
        escape(&row.name),
        escape(&row.detail)
    );
    for (place, (from, shade)) in row.states.iter().enumerate() {
        let to = row.states.get(place + 1).map_or(layout.end, |(at, _)| *at);
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
    let (all, errors) = (shares(picture, false), shares(picture, true));
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
    let _ = writeln!(
        svg,
        "<text x=\"{:.1}\" y=\"{:.1}\" font-weight=\"600\">bus load, by slices of {}</text>",
        layout.left,
        layout.load_top - 8.0,
        crate::scenario::Time(core::time::Duration::from_nanos(slice(picture.end)))
    );
    for (shares, colour) in [(all, LOAD_COLOUR), (errors, ERROR_COLOUR)] {
        let mut path = format!("M{:.1} {bottom:.1}", layout.left);
        for (index, share) in shares.iter().enumerate() {
            let from = Instant::from_nanos(index as u64 * slice(picture.end));
            let to = Instant::from_nanos((index as u64 + 1) * slice(picture.end));
            let y = bottom - LOAD_HEIGHT * share.min(1.0);
            let _ = write!(path, "L{:.1} {y:.1}L{:.1} {y:.1}", layout.x(from), layout.x(to));
        }
        let _ = write!(path, "L{:.1} {bottom:.1}Z", layout.x(picture.end));
        let _ = writeln!(svg, "<path d=\"{path}\" fill=\"{colour}\" fill-opacity=\"0.85\"/>");
    }
}

/// The length of a slice of the load, in nanoseconds.
fn slice(end: Instant) -> u64 {
    end.as_nanos().div_ceil(SLICES).max(1)
}

fn shares(picture: &Picture, errors_only: bool) -> Vec<f64> {
    let slice = slice(picture.end);
    let mut busy = vec![0_u64; SLICES as usize];
    for span in picture.busy.iter().filter(|span| span.error || !errors_only) {
        let (mut from, to) = (span.from.as_nanos(), span.to.as_nanos().min(picture.end.as_nanos()));
        while from < to {
            let index = from / slice;
            let until = to.min((index + 1) * slice);
            if let Some(sum) = busy.get_mut(index as usize) {
                *sum += until - from;
            }
            from = until;
        }
    }
    busy.into_iter().map(|busy| busy as f64 / slice as f64).collect()
}

/// The headings, each with a line through everything. Of a heading the picture has what stands before the colon.
fn notes(svg: &mut String, layout: &Layout, picture: &Picture) {
    for ((at, text), lane) in picture.notes.iter().zip(&layout.lanes) {
        let (x, y) = (layout.x(*at), NOTES_TOP + *lane as f64 * LANE);
        let _ = writeln!(
            svg,
            "<line x1=\"{x:.1}\" y1=\"{:.1}\" x2=\"{x:.1}\" y2=\"{:.1}\" stroke=\"#343a40\" \
             stroke-dasharray=\"3 3\" stroke-opacity=\"0.55\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" font-size=\"11\" fill=\"#343a40\">{}</text>",
            y - 4.0,
            layout.load_top + LOAD_HEIGHT,
            x + 4.0,
            y + 5.0,
            escape(short(text))
        );
    }
}

fn short(heading: &str) -> &str {
    heading.split_once(':').map_or(heading, |(short, _)| short)
}

/// For each heading the first lane that is free at its place.
fn lanes(notes: &[(Instant, String)], x: impl Fn(Instant) -> f64) -> Vec<usize> {
    let mut ends: Vec<f64> = Vec::new();
    let place = |(at, text): &(Instant, String)| {
        let from = x(*at);
        let to = from + short(text).chars().count() as f64 * NOTE_LETTER + 12.0;
        let lane = ends.iter().position(|end| *end <= from).unwrap_or(ends.len());
        match ends.get_mut(lane) {
            Some(end) => *end = to,
            None => ends.push(to),
        }
        lane
    };
    notes.iter().map(place).collect()
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

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

const WIDTH: f64 = 1200.0;
const MARGIN: f64 = 20.0;
const LANE: f64 = 16.0;
const NOTES_TOP: f64 = 78.0;
const NOTE_LETTER: f64 = 6.2;
const LOAD_HEIGHT: f64 = 110.0;
const LOAD_COLOUR: &str = "#4a6fa5";
const ERROR_COLOUR: &str = "#d64545";
const SLICES: u64 = 400;
/// More rows than this are drawn thinner.
const CROWD: usize = 24;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_load_of_a_slice_is_exact() {
        let ms = Instant::from_millis;
        let picture = Picture {
            end: ms(400),
            busy: vec![
                Busy { from: ms(0), to: Instant::from_micros(500), error: false },
                Busy { from: Instant::from_micros(1_500), to: Instant::from_micros(2_250), error: true },
            ],
            ..Picture::default()
        };
        assert_eq!(shares(&picture, false)[..4], [0.5, 0.5, 0.25, 0.0]);
        assert_eq!(shares(&picture, true)[..4], [0.0, 0.5, 0.25, 0.0]);
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
    fn names_cannot_break_the_picture() {
        let row = Row { name: "a<b".to_owned(), detail: String::new(), states: Vec::new() };
        let svg = draw(&Picture { end: Instant::from_millis(1), rows: vec![row], ..Picture::default() });
        assert!(svg.contains("a&lt;b") && !svg.contains("a<b"));
    }
}
