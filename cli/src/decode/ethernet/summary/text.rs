//! The summary as tables for people.

use link_core::Instant;
use powerlink_core::NodeId;
use powerlink_core::dictionary::ObjectAddress;
use powerlink_core::monitor::{Monitor, NodeRecord, StateChange};

use super::{Abort, Count, Network, Summary};
use crate::histogram::{Histogram, exact_milliseconds, milliseconds};
use crate::table::{Cell, Table};
use crate::text::{count, printable, seconds_since};

impl Summary {
    /// As tables for people, with times since the begin of the capture.
    pub(in crate::decode::ethernet) fn text(
        &self,
        monitors: &[Box<Monitor>],
        channel: impl Fn(usize) -> String,
        origin: Instant,
    ) -> String {
        let mut out = String::new();
        for (index, network) in self.networks.iter().enumerate() {
            if index > 0 {
                out.push('\n');
            }
            let monitor = monitors.get(index).map(AsRef::as_ref);
            out += &network.heading(&channel(index), monitor);
            if network.total.frames > 0 {
                out += &format!("\n{}", network.node_table(monitor));
            }
            let histories = network.histories(monitor, origin);
            if !histories.is_empty() {
                out += &format!("\n{histories}");
            }
            if !network.transfers.is_empty() {
                out += &format!("\n{}", network.transfer_table());
            }
            if !network.aborts.is_empty() {
                out += &format!("\n{}", network.abort_table());
            }
            if network.reports.count() > 0 {
                out += &format!("\n{}", network.reports.table(origin));
            }
            if !network.problems.is_empty() {
                out += &format!("\n{}", network.problems.table(Some(origin)));
            }
        }
        out
    }
}

impl Network {
    fn heading(&self, channel: &str, monitor: Option<&Monitor>) -> String {
        let mut out = format!(
            "{}: {} in {:.3} s, {} with a problem\n",
            printable(channel),
            count(self.total.frames, "frame"),
            self.seconds(),
            self.total.problems,
        );
        let kinds: Vec<_> = self.kinds().map(|(kind, frames)| format!("{frames} {kind}")).collect();
        if !kinds.is_empty() {
            out += &format!("{}\n", kinds.join(", "));
        }
        if let Some(cycle) = monitor.map(Monitor::cycle)
            && let (Some(mean), Some(jitter)) = (cycle.mean(), cycle.jitter())
        {
            out += &format!(
                "cycle {} mean, {} to {}, p99 {}, jitter {}, {} missing\n",
                exact_milliseconds(mean),
                exact_milliseconds(cycle.min),
                exact_milliseconds(cycle.max),
                percentile(&self.cycle, 99),
                exact_milliseconds(jitter),
                count(cycle.missing, "SoC"),
            );
        }
        if self.clock_back > 0 {
            let times = count(self.clock_back, "time");
            out += &format!(
                "the clock of the capture goes back {times}: what is measured across that means nothing\n"
            );
        }
        let lost = monitor.map(Monitor::lost).unwrap_or_default();
        for (number, of, what) in [
            (lost.connections, "SDO connection", "given up for others: there were too many at a time"),
            (lost.transfers, "SDO transfer", "not put together: too long"),
        ] {
            if number > 0 {
                out += &format!("{} {what}\n", count(number, of));
            }
        }
        if let Some(verdict) = &self.verdict {
            out += &format!("verdict: {verdict}\n");
        }
        out
    }

    fn node_table(&self, monitor: Option<&Monitor>) -> Table {
        let mut table = Table::new(&[
            "node",
            "frames",
            "bytes",
            "problems",
            "polls",
            "PRes lost",
            "late",
            "p50",
            "p99",
            "max",
            "unanswered",
            "MAC",
            "device",
        ]);
        for (node, count) in self.senders() {
            let Count { frames, bytes, problems, pres } = count;
            let known = node.and_then(|node| monitor?.node(NodeId(node)));
            let number = |value: fn(&NodeRecord) -> u64| {
                Cell::right(known.map_or_else(|| "-".to_owned(), |known| value(known).to_string()))
            };
            let max = if pres.count() == 0 { "-".to_owned() } else { exact_milliseconds(pres.max()) };
            table.row(vec![
                Cell::right(node.map_or_else(|| "-".to_owned(), |node| node.to_string())),
                Cell::right(frames.to_string()),
                Cell::right(bytes.to_string()),
                Cell::right(problems.to_string()),
                number(|known| known.polls),
                number(|known| known.pres_missing),
                number(|known| known.pres_late),
                Cell::right(percentile(pres, 50)),
                Cell::right(percentile(pres, 99)),
                Cell::right(max),
                number(|known| known.answers_missing),
                Cell::left(known.and_then(|known| known.mac).map_or_else(String::new, |mac| mac.to_string())),
                Cell::left(known.map_or_else(String::new, device)),
            ]);
        }
        table
    }

    /// One line a node: `states of node 1: NMT_PRE_OPERATIONAL_1 (0.562752 s, frame 113), ...`.
    fn histories(&self, monitor: Option<&Monitor>, origin: Instant) -> String {
        let mut out = String::new();
        for known in monitor.into_iter().flat_map(Monitor::nodes).filter(|known| !known.history.is_empty()) {
            let changes = known.history.iter().map(|StateChange { at, n, state }| {
                format!("{state} ({}, frame {n})", seconds_since(origin, *at, self.digits))
            });
            let before = (known.forgotten > 0).then(|| format!("{} before", count(known.forgotten, "state")));
            let states: Vec<_> = before.into_iter().chain(changes).collect();
            out += &format!("states of {}: {}\n", known.node, states.join(", "));
        }
        out
    }

    fn transfer_table(&self) -> Table {
        let mut table = Table::new(&[
            "SDO client",
            "server",
            "reads",
            "writes",
            "others",
            "aborts",
            "response p50",
            "p99",
            "max",
        ]);
        for (pair, transfers) in self.transfers() {
            let (client, server) = pair.map_or(("others".into(), "-".into()), |(client, server)| {
                (client.to_string(), server.to_string())
            });
            let numbers = [transfers.reads, transfers.writes, transfers.others, transfers.aborts];
            let responses = &transfers.responses;
            let times =
                [percentile(responses, 50), percentile(responses, 99), exact_milliseconds(responses.max())];
            let numbers = numbers.map(|number| number.to_string());
            table.row([client, server].into_iter().chain(numbers).chain(times).map(Cell::right).collect());
        }
        table
    }

    fn abort_table(&self) -> Table {
        let mut table = Table::new(&["SDO client", "server", "object", "abort", "times", "why"]);
        for (abort, times) in self.aborts() {
            let Some(Abort { client, server, object, code }) = abort else {
                let [others, none] = ["others", "-"];
                let times = Cell::right(times.to_string());
                table.row(vec![
                    Cell::right(others),
                    Cell::right(none),
                    Cell::left(none),
                    Cell::left(none),
                    times,
                    Cell::left(""),
                ]);
                continue;
            };
            let object = object
                .map_or_else(|| "-".to_owned(), |(index, sub)| ObjectAddress::new(index, sub).to_string());
            table.row(vec![
                Cell::right(client.to_string()),
                Cell::right(server.to_string()),
                Cell::left(object),
                Cell::left(format!("0x{:08X}", code.0)),
                Cell::right(times.to_string()),
                Cell::left(code.name().unwrap_or_default()),
            ]);
        }
        table
    }
}

/// `vendor 0x00000123, product 0x00000007, revision 1.0, serial 0x0000002A`
fn device(known: &NodeRecord) -> String {
    let Some(ident) = known.ident else { return String::new() };
    let identity = ident.identity;
    format!(
        "vendor 0x{:08X}, product 0x{:08X}, revision {}, serial 0x{:08X}",
        identity.vendor_id,
        identity.product_code,
        identity.revision(),
        identity.serial_number,
    )
}

fn percentile(times: &Histogram, percent: u64) -> String {
    if times.count() == 0 { "-".to_owned() } else { milliseconds(times.percentile(percent)) }
}
