//! What a time line shows.

use link_core::Instant;

use super::load::Load;

/// The states of the nodes and the load of the bus, over time.
#[derive(Clone, Debug, Default)]
pub(super) struct Picture {
    pub(super) title: String,
    pub(super) end: Instant,
    pub(super) rows: Vec<Row>,
    /// Headings at their times.
    pub(super) notes: Vec<(Instant, String)>,
    pub(super) load: Load,
}

/// A node.
#[derive(Clone, Debug)]
pub(super) struct Row {
    pub(super) name: String,
    /// A few words under or beside the name, such as `MAC 10`.
    pub(super) detail: String,
    /// From when on it was what; each lasts until the next.
    states: Vec<(Instant, Shade)>,
}

/// What a node is, as far as a colour tells it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Shade {
    /// It has no power.
    Off,
    /// It has power, and its cable is unplugged.
    Cut,
    Sending,
    Waiting,
    /// It listens for the bit rate.
    Detecting,
    /// It says Hello, and waits for objections.
    Hello,
    /// It waits for an address.
    Standby,
    OnLine,
    /// On line, and I/O runs.
    Exchanging,
    /// On line, and I/O has timed out.
    TimedOut,
    Fault,
    BusOff,
    /// It has no state of network access, and is there.
    Present,
}

impl Row {
    /// A node without power.
    pub(super) fn new(name: String, detail: String) -> Self {
        Self { name, detail, states: vec![(Instant::ZERO, Shade::Off)] }
    }

    /// From when on it was what; each lasts until the next.
    pub(super) fn states(&self) -> &[(Instant, Shade)] {
        &self.states
    }

    /// The node is something else from now on.
    pub(super) fn enter(&mut self, at: Instant, shade: Shade) {
        match self.states.last_mut() {
            Some((_, last)) if *last == shade => {}
            // What lasted no time was not there.
            Some((since, last)) if *since == at => *last = shade,
            _ => self.states.push((at, shade)),
        }
        if self.states.len() > MOST_STATES {
            self.thin(at);
        }
    }

    /// Of what changed within a time that is too short to be seen, the last remains, because it lasts on, the first that is
    /// wrong, and the first that is not. So a node that fails and restarts for days costs no more memory than one that is
    /// well, and still looks like one that fails and restarts.
    fn thin(&mut self, now: Instant) {
        let cell = now.as_nanos() / VISIBLE + 1;
        let mut thinned: Vec<(Instant, Shade)> = Vec::new();
        for states in self.states.chunk_by(|one, next| one.0.as_nanos() / cell == next.0.as_nanos() / cell) {
            let first = |wrong: bool| states.iter().position(|(_, shade)| shade.is_wrong() == wrong);
            let remain = [first(true), first(false), Some(states.len() - 1)];
            for (place, state) in states.iter().enumerate() {
                let is_new = thinned.last().is_none_or(|(_, last)| *last != state.1);
                if is_new && remain.contains(&Some(place)) {
                    thinned.push(*state);
                }
            }
        }
        self.states = thinned;
    }
}

impl Shade {
    const fn is_wrong(self) -> bool {
        match self {
            Self::Fault | Self::BusOff | Self::TimedOut => true,
            Self::Off
            | Self::Cut
            | Self::Sending
            | Self::Waiting
            | Self::Detecting
            | Self::Hello
            | Self::Standby
            | Self::OnLine
            | Self::Exchanging
            | Self::Present => false,
        }
    }
}

/// Parts of the time line that can be told apart, at the most.
const VISIBLE: u64 = 2_000;
const MOST_STATES: usize = 10_000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_that_restarts_for_ever_costs_no_memory() {
        let mut row = Row::new("a".to_owned(), String::new());
        for second in 0..1_000_000 {
            row.enter(Instant::from_millis(second * 1_000), Shade::BusOff);
            row.enter(Instant::from_millis(second * 1_000 + 100), Shade::Present);
        }
        assert!(row.states.capacity() <= 2 * MOST_STATES);
        assert!(row.states.windows(2).all(|pair| pair[0].0 < pair[1].0 && pair[0].1 != pair[1].1));
        assert_eq!(row.states.last().map(|(_, shade)| *shade), Some(Shade::Present));
        // All the time, and not only lately.
        let early = row.states.iter().filter(|(at, _)| *at < Instant::from_millis(500_000_000));
        let wrong = early.filter(|(_, shade)| *shade == Shade::BusOff).count();
        assert!(wrong > 500, "{wrong}");
    }

    #[test]
    fn what_is_long_enough_to_be_seen_stays_where_it_is() {
        let mut row = Row::new("a".to_owned(), String::new());
        let fault = Instant::from_millis(5_000_000);
        row.enter(fault, Shade::Fault);
        for micros in 0..10_000 {
            let at = Instant::from_millis(6_000_000) + core::time::Duration::from_micros(micros);
            row.enter(at, if micros % 2 == 0 { Shade::Sending } else { Shade::Waiting });
        }
        assert!(row.states.len() < 10, "{}", row.states.len());
        assert_eq!(row.states[..2], [(Instant::ZERO, Shade::Off), (fault, Shade::Fault)]);
        assert_eq!(row.states.last().map(|(_, shade)| *shade), Some(Shade::Waiting));
    }
}
