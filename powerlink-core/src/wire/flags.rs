//! Flags, and the request for the asynchronous slot.

use core::fmt;

bitflags::bitflags! {
    /// The first flag byte of SoC, PReq, PRes, SoA, IdentResponse and StatusResponse.
    ///
    /// | Bit | Name | Used in | Meaning |
    /// |---|---|---|---|
    /// | 0 | RD | PReq, PRes | process data are valid |
    /// | 1 | ER | SoA | exception reset, MN to CN |
    /// | 2 | EA | PReq, SoA | exception acknowledge, MN to CN |
    /// | 3 | EC | StatusResponse | exception clear, CN to MN |
    /// | 4 | EN | PRes, StatusResponse | exception new, CN to MN |
    /// | 5 | MS | PReq, PRes | the node is served in a multiplexed slot |
    /// | 6 | PS | SoC | prescaled slot, toggled every n-th cycle |
    /// | 7 | MC | SoC | multiplexed cycle completed, toggled |
    ///
    /// A bit that a message does not use is kept as it was read, and means nothing.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    pub struct Flags: u8 {
        /// RD
        const DATA_VALID = 0x01;
        /// ER
        const EXCEPTION_RESET = 0x02;
        /// EA
        const EXCEPTION_ACKNOWLEDGE = 0x04;
        /// EC
        const EXCEPTION_CLEAR = 0x08;
        /// EN
        const EXCEPTION_NEW = 0x10;
        /// MS
        const MULTIPLEXED = 0x20;
        /// PS
        const PRESCALED = 0x40;
        /// MC
        const MULTIPLEXED_CYCLE = 0x80;
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Flags {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "Flags({=u8:#x})", self.bits());
    }
}

/// The second flag byte of PRes, IdentResponse and StatusResponse: what waits for the asynchronous slot.
///
/// | Bits | Name | Meaning |
/// |---|---|---|
/// | 2-0 | RS | how many frames wait; 7 means 7 or more |
/// | 5-3 | PR | the priority of the most urgent: 7 NMT request, 3 generic |
/// | 7-6 | SLS, FLS | link status of two ports (extensions): sent as 0, ignored |
///
/// ```
/// use powerlink_core::wire::AsyncRequest;
///
/// assert_eq!(AsyncRequest::new(AsyncRequest::GENERIC, 1), AsyncRequest(0x19));
/// assert_eq!(AsyncRequest::new(AsyncRequest::NMT, 12).count(), 7);
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
pub struct AsyncRequest(pub u8);

impl AsyncRequest {
    /// Nothing waits.
    pub const NONE: Self = Self(0);
    /// The priority of NMT requests.
    pub const NMT: u8 = 7;
    /// The priority of everything else.
    pub const GENERIC: u8 = 3;

    /// `count` frames wait, the most urgent with `priority`; nothing waits if there are none.
    #[must_use]
    pub fn new(priority: u8, count: usize) -> Self {
        let count = u8::try_from(count).unwrap_or(u8::MAX).min(COUNT);
        if count == 0 { Self::NONE } else { Self((priority.min(COUNT) << PRIORITY_SHIFT) | count) }
    }

    /// PR
    #[must_use]
    pub const fn priority(self) -> u8 {
        (self.0 >> PRIORITY_SHIFT) & COUNT
    }

    /// RS
    #[must_use]
    pub const fn count(self) -> u8 {
        self.0 & COUNT
    }
}

/// `PR=3 RS=1`
impl fmt::Display for AsyncRequest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "PR={} RS={}", self.priority(), self.count())
    }
}

const COUNT: u8 = 0x07;
const PRIORITY_SHIFT: u8 = 3;
