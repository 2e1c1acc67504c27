//! Bars and curves of characters.

/// A bar of so many characters, full at 1, in eighths of a character.
pub(super) fn bar(share: f64, width: usize) -> String {
    let eighths = (share.clamp(0.0, 1.0) * width as f64 * 8.0).round() as usize;
    let mut bar = "█".repeat(eighths / 8);
    if !eighths.is_multiple_of(8) {
        bar.push(PARTS[eighths % 8 - 1]);
    }
    let length = bar.chars().count();
    bar + &" ".repeat(width.saturating_sub(length))
}

/// The latest values that there is room for, of which `most` is the height of a character. What is not zero is seen.
pub(super) fn curve(values: impl DoubleEndedIterator<Item = f64>, most: f64, width: usize) -> String {
    let mut characters: Vec<char> = values
        .rev()
        .take(width)
        .map(|value| match value {
            value if value <= 0.0 || most <= 0.0 => ' ',
            value => {
                let height = (value / most * HEIGHTS.len() as f64).ceil() as usize;
                HEIGHTS[height.clamp(1, HEIGHTS.len()) - 1]
            }
        })
        .collect();
    characters.resize(width, ' ');
    characters.iter().rev().collect()
}

/// Where a response time is on its way to the limit: logarithmic, a third of the bar for each factor of ten, full at the limit.
pub(super) fn position(share: f64) -> f64 {
    if share <= 0.0 { 0.0 } else { (1.0 + share.log10() / DECADES).clamp(0.0, 1.0) }
}

const PARTS: [char; 7] = ['▏', '▎', '▍', '▌', '▋', '▊', '▉'];
const HEIGHTS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
const DECADES: f64 = 3.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_are_as_long_as_their_share() {
        for (share, expected) in
            [(0.0, "    "), (0.125, "▌   "), (0.5, "██  "), (0.99, "████"), (1.0, "████"), (7.0, "████")]
        {
            assert_eq!(bar(share, 4), expected, "{share}");
        }
    }

    #[test]
    fn curves_end_at_the_right() {
        let text = |values: &[f64]| curve(values.iter().copied(), 1.0, 4);
        assert_eq!(text(&[0.5, 0.001, 1.0]), " ▄▁█");
        assert_eq!(text(&[0.9, 0.0, 0.125, 0.25, 1.0]), " ▁▂█");
        assert_eq!(curve([0.0].into_iter(), 0.0, 2), "  ");
    }

    #[test]
    fn a_response_time_that_is_a_thousandth_of_the_limit_is_at_the_beginning() {
        let tenths = |share| (position(share) * 9.0).round();
        assert_eq!([0.0, 0.001, 0.01, 0.1, 1.0, 3.0].map(tenths), [0.0, 0.0, 3.0, 6.0, 9.0, 9.0]);
    }
}
