//! Fault confinement: the error counters and the states they stand for (Bosch CAN 2.0 part B section 8, ISO 11898-1).

/// How a controller may take part, by its error counters.
///
/// ```text
///            TEC > 127 or REC > 127            TEC > 255
///  Active ---------------------------> Passive ---------> BusOff
///         <---------------------------          (Reset and 128 x 11 recessive bits lead back to Active)
///            both below 128
/// ```
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum ErrorState {
    /// Sends active error flags: six dominant bits.
    Active,
    /// Sends passive error flags, which nobody sees, and waits 8 bits more after it has sent.
    Passive,
    /// Has left the bus.
    BusOff,
}

/// Transmit and receive error counter.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub struct Counters {
    /// Transmit error counter, 0 to 263; more than 255 is bus-off.
    pub tec: u16,
    /// Receive error counter, 0 to 255.
    pub rec: u16,
}

impl Counters {
    /// Where these counters lead.
    #[must_use]
    pub const fn state(self) -> ErrorState {
        if self.tec > BUS_OFF_ABOVE {
            ErrorState::BusOff
        } else if self.tec > PASSIVE_ABOVE || self.rec > PASSIVE_ABOVE {
            ErrorState::Passive
        } else {
            ErrorState::Active
        }
    }

    /// One of the counters has reached 96.
    #[must_use]
    pub const fn warning(self) -> bool {
        self.tec >= WARNING_FROM || self.rec >= WARNING_FROM
    }

    /// Rules 2 and 3: a transmitter sends an error flag, or sees a bit error in it.
    pub(crate) const fn transmit_error(&mut self) {
        self.tec += 8;
    }

    /// Rule 1: a receiver detects an error.
    pub(crate) fn receive_error(&mut self) {
        self.rec = (self.rec + 1).min(REC_MAX);
    }

    /// Rules 1 and 3: a receiver sees a dominant bit after its error flag, or a bit error in it.
    pub(crate) fn severe_receive_error(&mut self) {
        self.rec = (self.rec + 8).min(REC_MAX);
    }

    /// Rule 4: a frame was sent.
    pub(crate) const fn sent(&mut self) {
        self.tec = self.tec.saturating_sub(1);
    }

    /// Rule 4: a frame was received.
    pub(crate) const fn received(&mut self) {
        self.rec = if self.rec > PASSIVE_ABOVE { REC_AFTER_PASSIVE } else { self.rec.saturating_sub(1) };
    }
}

const WARNING_FROM: u16 = 96;
const PASSIVE_ABOVE: u16 = 127;
const BUS_OFF_ABOVE: u16 = 255;
/// Common controllers have eight bits for it.
const REC_MAX: u16 = 255;
/// ISO 11898-1 allows 119 to 127.
const REC_AFTER_PASSIVE: u16 = 127;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_by_counters() {
        for (tec, rec, state) in [
            (127, 127, ErrorState::Active),
            (128, 0, ErrorState::Passive),
            (0, 128, ErrorState::Passive),
            (255, 255, ErrorState::Passive),
            (256, 0, ErrorState::BusOff),
        ] {
            assert_eq!(Counters { tec, rec }.state(), state, "TEC {tec} REC {rec}");
        }
    }

    #[test]
    fn a_received_frame_brings_a_passive_receiver_back() {
        let mut counters = Counters { tec: 0, rec: 200 };
        counters.received();
        assert_eq!((counters.rec, counters.state()), (127, ErrorState::Active));
        counters.received();
        assert_eq!(counters.rec, 126);
    }
}
