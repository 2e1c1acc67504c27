//! The headings of a scenario, each with a line through everything.

use core::fmt::Write as _;

use link_core::Instant;

use super::{LOAD_HEIGHT, Layout, WIDTH, escape};
use crate::simulate::picture::Picture;

/// Draws them. Of a heading the picture has what stands before the colon.
pub(super) fn headings(svg: &mut String, layout: &Layout, picture: &Picture) {
    for ((at, text), lane) in picture.notes.iter().zip(&layout.lanes) {
        let (x, y) = (layout.x(*at), layout.notes_top + *lane as f64 * LANE);
        let heading = Heading::of(x, text);
        let _ = writeln!(
            svg,
            "<line x1=\"{x:.1}\" y1=\"{:.1}\" x2=\"{x:.1}\" y2=\"{:.1}\" stroke=\"#343a40\" \
             stroke-dasharray=\"3 3\" stroke-opacity=\"0.55\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" font-size=\"11\" fill=\"#343a40\"{}>{}</text>",
            y - 4.0,
            layout.load_top + LOAD_HEIGHT,
            heading.text_x,
            y + 5.0,
            heading.anchor,
            escape(short(text))
        );
    }
}

/// Where the words of a heading are.
pub(super) struct Heading {
    from: f64,
    to: f64,
    text_x: f64,
    anchor: &'static str,
}

impl Heading {
    /// Right of its line, or left of it where the picture would end.
    pub(super) fn of(x: f64, text: &str) -> Self {
        let width = short(text).chars().count() as f64 * NOTE_LETTER + 12.0;
        if x + width > WIDTH && x > width {
            return Self { from: x - width, to: x, text_x: x - 4.0, anchor: " text-anchor=\"end\"" };
        }
        Self { from: x, to: x + width, text_x: x + 4.0, anchor: "" }
    }
}

fn short(heading: &str) -> &str {
    heading.split_once(':').map_or(heading, |(short, _)| short)
}

/// For each heading the first lane that is free at its place.
pub(super) fn lanes(notes: &[(Instant, String)], heading: impl Fn(Instant, &str) -> Heading) -> Vec<usize> {
    let mut ends: Vec<f64> = Vec::new();
    let place = |(at, text): &(Instant, String)| {
        let Heading { from, to, .. } = heading(*at, text);
        let lane = ends.iter().position(|end| *end <= from).unwrap_or(ends.len());
        match ends.get_mut(lane) {
            Some(end) => *end = to,
            None => ends.push(to),
        }
        lane
    };
    notes.iter().map(place).collect()
}

pub(super) const LANE: f64 = 16.0;
const NOTE_LETTER: f64 = 6.2;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::svg::draw;

    #[test]
    fn a_heading_near_the_end_stays_in_the_picture() {
        let mut picture = Picture { end: Instant::from_millis(1_000), ..Picture::default() };
        picture.notes = vec![(Instant::from_millis(990), "the last act of the play: it ends".to_owned())];
        let heading = Heading::of(Layout::of(&picture).x(picture.notes[0].0), &picture.notes[0].1);
        assert!(heading.to <= WIDTH && heading.from > 0.0);
        assert!(draw(&picture).contains("text-anchor=\"end\">the last act of the play<"));
    }
}
