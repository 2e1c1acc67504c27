//! Which colour is what.

use core::fmt::Write as _;

use super::{ERROR_COLOUR, LOAD_COLOUR, MARGIN, WIDTH};
use crate::simulate::picture::{Picture, Shade};

impl Shade {
    pub(super) const LEGEND: [(Self, &'static str); 13] = [
        (Self::Off, "no power"),
        (Self::Cut, "cable unplugged"),
        (Self::Sending, "sending the check"),
        (Self::Waiting, "waiting 1 s"),
        (Self::Detecting, "detecting the bit rate"),
        (Self::Hello, "saying Hello"),
        (Self::Standby, "Standby"),
        (Self::OnLine, "on line"),
        (Self::Exchanging, "exchanging I/O"),
        (Self::TimedOut, "I/O timed out"),
        (Self::Fault, "communication fault"),
        (Self::BusOff, "bus-off"),
        (Self::Present, "attached"),
    ];

    pub(super) const fn colour(self) -> &'static str {
        match self {
            Self::Off => "#e9ecef",
            Self::Cut => "#adb5bd",
            Self::Sending => "#f4a259",
            Self::Waiting => "#f6d55c",
            Self::Detecting => "#cfb8e0",
            Self::Hello => "#f6d55c",
            Self::Standby => "#8fc1d4",
            Self::OnLine => "#a3d9b1",
            Self::Exchanging => "#4caf7a",
            Self::TimedOut => "#c77dbb",
            Self::Fault => "#d64545",
            Self::BusOff => "#5b1a2b",
            Self::Present => "#7b9acc",
        }
    }
}

/// A colour and what it means.
pub(super) struct LegendItem {
    x: f64,
    pub(super) y: f64,
    /// Of the patch of colour.
    height: f64,
    colour: &'static str,
    words: &'static str,
}

/// The colours that are in the picture, in as many lines as they need.
pub(super) fn legend_items(picture: &Picture) -> Vec<LegendItem> {
    let shown =
        |shade: Shade| picture.rows.iter().any(|row| row.states().iter().any(|(_, own)| *own == shade));
    let shades = Shade::LEGEND.iter().filter(|(shade, _)| shown(*shade));
    let shades = shades.map(|(shade, words)| (14.0, shade.colour(), *words));
    let loads = [(6.0, LOAD_COLOUR, "bus load"), (6.0, ERROR_COLOUR, "of it destroyed by errors")];
    let (mut x, mut y) = (MARGIN, LEGEND_TOP);
    let place = |(height, colour, words): (f64, _, &'static str)| {
        let width = 20.0 + words.len() as f64 * LEGEND_LETTER;
        if x + width > WIDTH - MARGIN {
            (x, y) = (MARGIN, y + LEGEND_LINE);
        }
        let item = LegendItem { x, y, height, colour, words };
        x += width + 22.0;
        item
    };
    shades.chain(loads).map(place).collect()
}

/// Draws them.
pub(super) fn legend(svg: &mut String, items: &[LegendItem]) {
    for LegendItem { x, y, height, colour, words } in items {
        let _ = writeln!(
            svg,
            "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"14\" height=\"{height}\" rx=\"{}\" fill=\"{colour}\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\">{words}</text>",
            y + (14.0 - height) / 2.0,
            height / 5.0,
            x + 20.0,
            y + 11.5
        );
    }
}

pub(super) const LEGEND_TOP: f64 = 46.0;
const LEGEND_LINE: f64 = 20.0;
const LEGEND_LETTER: f64 = 6.6;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::picture::Row;
    use link_core::Instant;

    #[test]
    fn a_legend_that_is_too_long_for_a_line_takes_two() {
        let mut all = Row::new("a".to_owned(), String::new());
        for (index, (shade, _)) in Shade::LEGEND.iter().enumerate() {
            all.enter(Instant::from_millis(index as u64 * 10 + 1), *shade);
        }
        let picture = Picture { end: Instant::from_millis(1_000), rows: vec![all], ..Picture::default() };
        let items = legend_items(&picture);
        assert_eq!(items.len(), 15);
        assert!(items.iter().any(|item| item.y > LEGEND_TOP));
        let end = |item: &LegendItem| item.x + 20.0 + item.words.len() as f64 * LEGEND_LETTER;
        assert!(items.iter().all(|item| end(item) <= WIDTH - MARGIN));
    }
}
