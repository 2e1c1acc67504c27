//! The summary as tables for people.

use super::{Bus, Connection, Count, Known, Node, Summary};
use crate::histogram;
use crate::table::{Cell, Table};
use crate::text::{count, printable};

impl Summary {
    /// As tables for people.
    pub(in crate::decode) fn text(&self, channel: impl Fn(usize) -> String) -> String {
        let mut out = String::new();
        for (index, bus) in self.buses.iter().enumerate() {
            if index > 0 {
                out.push('\n');
            }
            let rate = self.rate(bus);
            out += &format!(
                "{}: {} in {:.3} s, {} with a problem\n\
                 bus load {}{} at {}{}, stuff bits and intermission included\n",
                printable(&channel(index)),
                count(bus.total.frames, "frame"),
                bus.seconds(),
                bus.total.problems,
                rate.bound(bus.errors.frames > 0).words(),
                percent(bus.load(&bus.total, rate)),
                rate,
                if rate.known().or(self.bit_rate).is_some() { "" } else { " (--bit-rate says which)" },
            );
            if bus.errors.frames > 0 {
                let one = bus.errors.frames == 1;
                let share = percent(bus.load(&bus.errors, rate));
                let share = match rate.known() {
                    Some(_) => format!("{share} of the time at least"),
                    // Longer errors at a higher rate.
                    None => format!("about {share} of the time"),
                };
                out += &format!(
                    "{} {} {share}: how much of a frame {} ended is not recorded\n",
                    count(bus.errors.frames, "error frame"),
                    if one { "takes" } else { "take" },
                    if one { "it has" } else { "each has" },
                );
            }
            if let Some(verdict) = &bus.verdict {
                out += &format!("verdict: {verdict}\n");
            }
            if bus.total.frames > 0 {
                out += &format!("\n{}\n{}", self.node_table(bus), self.connection_table(bus));
            }
            if !bus.findings.is_empty() {
                out += &format!("\n{}", bus.findings);
            }
            if !bus.problems.is_empty() {
                out += &format!("\n{}", bus.problems.table(None));
            }
        }
        out
    }

    fn node_table(&self, bus: &Bus) -> Table {
        let mut table = Table::new(&[&["node"][..], &COUNT_COLUMNS, &["access", "device"]].concat());
        for (mac, Node { count, known }) in bus.senders() {
            let node = vec![Cell::right(mac.map_or_else(|| "-".to_owned(), |mac| mac.to_string()))];
            let known = match known {
                Some(known) => vec![Cell::left(known.access), Cell::left(device(known))],
                None => vec![Cell::left(""), Cell::left("")],
            };
            table.row([node, count.cells(bus.load(count, self.rate(bus))), known].concat());
        }
        table
    }

    fn connection_table(&self, bus: &Bus) -> Table {
        let mut table = Table::new(&[&["node", "connection"][..], &COUNT_COLUMNS, &["states seen"]].concat());
        for (key, Connection { count, states }) in &bus.connections {
            let name = match key.name.client() {
                Some(client) => format!("{}, client {client}", key.name),
                None => key.name.to_string(),
            };
            let names = vec![Cell::right(key.node.to_string()), Cell::left(name)];
            let states = states.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
            table.row(
                [names, count.cells(bus.load(count, self.rate(bus))), vec![Cell::left(states)]].concat(),
            );
        }
        table
    }
}

impl Count {
    /// The cells below [`COUNT_COLUMNS`].
    fn cells(&self, load: Option<f64>) -> Vec<Cell> {
        let responses = &self.responses;
        let time = |words: &dyn Fn() -> String| if responses.count() == 0 { "-".to_owned() } else { words() };
        let percentile = |percent| time(&|| histogram::milliseconds(responses.percentile(percent)));
        vec![
            Cell::right(self.frames.to_string()),
            Cell::right(self.bytes.to_string()),
            Cell::right(self.problems.to_string()),
            Cell::right(percent(load)),
            Cell::right(percentile(50)),
            Cell::right(percentile(99)),
            Cell::right(time(&|| histogram::exact_milliseconds(responses.max()))),
        ]
    }
}

/// `Pressure gauge, vendor 4660, serial 0x00002345`, as far as it is known.
fn device(known: &Known) -> String {
    let vendor = known.vendor.map(|vendor| format!("vendor {vendor}"));
    let serial = known.serial.map(|serial| format!("serial 0x{serial:08X}"));
    [known.product_name.clone(), vendor, serial].into_iter().flatten().collect::<Vec<_>>().join(", ")
}

fn percent(load: Option<f64>) -> String {
    load.map_or_else(|| "-".to_owned(), |load| format!("{:.2} %", load * 100.0))
}

const COUNT_COLUMNS: [&str; 7] = ["frames", "bytes", "problems", "load", "response p50", "p99", "max"];
