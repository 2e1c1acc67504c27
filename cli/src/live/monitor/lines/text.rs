//! Lines for people.

use core::time::Duration;

use crate::live::monitor::model::{FindingPicture, Happening, NodePicture, Picture, Purpose, words};
use crate::live::monitor::words as say;
use crate::table::{Cell, Table};
use crate::text::count;

pub(super) fn event(at: Duration, what: &Happening) -> String {
    let who = what.mac().map_or_else(|| "bus".to_owned(), |mac| format!("node {mac}"));
    format!("{:12.6}  {who:<7}  {what}", at.as_secs_f64())
}

pub(super) fn summary(picture: &Picture, is_last: bool) -> String {
    let counters = &picture.counters;
    let title = if is_last { "in the end" } else { "summary" };
    let load = if is_last { &picture.total } else { &picture.load };
    let purposes: Vec<String> = Purpose::ALL
        .into_iter()
        .zip(load.by_purpose)
        .filter(|(_, share)| *share > 0.0)
        .map(|(purpose, share)| format!("{} {}", purpose.words(), say::percent(share)))
        .collect();
    let mut text = format!(
        "\n{:.3} s, {title}: {}, load {}{} of {}{}{}\n{}, {}, {} lost, {} with a problem{}{}\nverdict: {}\n",
        picture.at.as_secs_f64(),
        picture.link,
        picture.bit_rate.bound(counters.error_frames > 0).words(),
        say::percent(load.all),
        picture.bit_rate,
        if purposes.is_empty() { "" } else { ": " },
        purposes.join(", "),
        count(counters.frames, "frame"),
        count(counters.error_frames, "error frame"),
        counters.lost,
        counters.problems,
        if counters.problems > 0 { ": " } else { "" },
        picture.problems,
        picture.verdict,
    );
    if !picture.nodes.is_empty() {
        text += &nodes(picture, is_last).to_string();
    }
    for found in &picture.findings {
        text += &finding(found);
    }
    text.push('\n');
    text
}

fn finding(found: &FindingPicture) -> String {
    let finding = &found.finding;
    let until = found.until.map_or_else(String::new, |until| format!(" until {:.3} s", until.as_secs_f64()));
    let since = found.since.as_secs_f64();
    format!("{} since {since:.3} s{until}: {finding}\n    {}\n", finding.severity, finding.advice())
}

fn nodes(picture: &Picture, is_last: bool) -> Table {
    let mut table = Table::new(&[
        "MAC",
        "state",
        "device",
        "owner",
        "connections",
        "load",
        "p50",
        "p99",
        "max",
        "EPR x 4",
    ]);
    for node in &picture.nodes {
        let times =
            |which: fn(&NodePicture) -> String| if node.io.is_some() { which(node) } else { "-".into() };
        table.row(vec![
            Cell::right(node.mac().to_string()),
            Cell::left(words(node.record.access)),
            Cell::left(say::device(node, usize::MAX)),
            Cell::right(say::or_dash(node.record.master)),
            Cell::left(say::connections(node)),
            Cell::right(say::percent(if is_last { node.total } else { node.load })),
            Cell::right(times(|node| say::time(node.io.map(|times| times.p50)))),
            Cell::right(times(|node| say::time(node.io.map(|times| times.p99)))),
            Cell::right(times(|node| say::exact_time(node.io.map(|times| times.max)))),
            Cell::right(node.limit.map_or_else(|| "-".into(), |limit| format!("{} ms", limit.as_millis()))),
        ]);
    }
    table
}
