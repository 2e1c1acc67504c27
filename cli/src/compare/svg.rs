//! The comparison as a picture: two bars for each figure, as long as the figure is great.

use core::fmt::Write as _;

use super::{Comparison, Value};

/// Draws it.
pub(super) fn draw(comparison: &Comparison) -> String {
    let rows: usize = comparison.claims.iter().map(|claim| claim.measures.len()).sum();
    let height = TOP + rows as f64 * ROW + comparison.claims.len() as f64 * HEADING + MARGIN;
    let mut svg = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" viewBox=\"0 0 {WIDTH} {height}\" \
         font-family=\"system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif\" font-size=\"12\" fill=\"#212529\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n\
         <text x=\"{MARGIN}\" y=\"30\" font-size=\"18\" font-weight=\"600\">DeviceNet and DeviceNeX, {}, {} devices</text>",
        comparison.plan.bit_rate, comparison.plan.devices
    );
    for (x, colour, name) in [(MARGIN, DEVICENET, "DeviceNet"), (MARGIN + 110.0, DEVICENEX, "DeviceNeX")] {
        let _ = writeln!(
            svg,
            "<rect x=\"{x}\" y=\"46\" width=\"14\" height=\"14\" rx=\"2.8\" fill=\"{colour}\"/>\
             <text x=\"{}\" y=\"57.5\">{name}</text>",
            x + 20.0
        );
    }
    let mut y = TOP;
    for claim in &comparison.claims {
        y += HEADING;
        let verdict = if claim.holds { "holds" } else { "does not hold" };
        let _ = writeln!(
            svg,
            "<text x=\"{MARGIN}\" y=\"{:.1}\" font-weight=\"600\">{} \
             <tspan font-weight=\"400\" fill=\"#495057\">{verdict}</tspan></text>",
            y - 8.0,
            claim.claim
        );
        for measure in &claim.measures {
            let _ = writeln!(
                svg,
                "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                LEFT - 10.0,
                y + ROW / 2.0,
                measure.measure
            );
            let values = [(measure.devicenet, DEVICENET), (measure.devicenex, DEVICENEX)];
            let longest = values.iter().filter_map(|(value, _)| value.size()).fold(0.0, f64::max);
            for (place, (value, colour)) in values.into_iter().enumerate() {
                bar(&mut svg, y + place as f64 * BAR + 3.0, value, longest, colour);
            }
            y += ROW;
        }
    }
    svg.push_str("</svg>\n");
    svg
}

fn bar(svg: &mut String, y: f64, value: Value, longest: f64, colour: &str) {
    let share = value.size().filter(|_| longest > 0.0).map_or(0.0, |size| size / longest);
    let length = share * (WIDTH - LEFT - VALUE);
    let _ = writeln!(
        svg,
        "<rect x=\"{LEFT}\" y=\"{y:.1}\" width=\"{length:.1}\" height=\"{:.1}\" fill=\"{colour}\"/>\
         <text x=\"{:.1}\" y=\"{:.1}\" font-size=\"10.5\" fill=\"#495057\">{value}</text>",
        BAR - 2.0,
        LEFT + length + 6.0,
        y + BAR - 4.0
    );
}

const WIDTH: f64 = 1000.0;
const MARGIN: f64 = 20.0;
const TOP: f64 = 76.0;
const HEADING: f64 = 34.0;
/// A figure.
const ROW: f64 = 34.0;
const BAR: f64 = 14.0;
/// Where bars begin.
const LEFT: f64 = 320.0;
/// Room for the value of the longest bar.
const VALUE: f64 = 90.0;
const DEVICENET: &str = "#7b9acc";
const DEVICENEX: &str = "#4caf7a";
