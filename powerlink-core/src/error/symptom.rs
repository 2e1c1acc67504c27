//! What can go wrong in a cycle.

use core::fmt;

use crate::wire::ErrorCode;

/// What is counted, each in an object of its own.
///
/// | Symptom | Object | Error code |
/// |---|---|---|
/// | collision | 0x1C0A | 0x8163 |
/// | loss of SoC | 0x1C0B | 0x8245 |
/// | loss of SoA | 0x1C0C | 0x8244 |
/// | loss of PReq | 0x1C0D | 0x8242 |
/// | SoC jitter | 0x1C0E | 0x8235 |
/// | CRC error | 0x1C0F | 0x8164 |
/// | loss of link | 0x1C10 | 0x8165 |
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Symptom {
    /// Two stations sent at once; full-duplex links have none.
    Collision,
    /// A SoC did not come.
    LossOfSoc,
    /// A SoA did not come.
    LossOfSoa,
    /// The node's own PReq did not come.
    LossOfPreq,
    /// A SoC came too early or too late.
    SocJitter,
    /// A frame with a wrong checksum, as far as the adapter tells.
    Crc,
    /// The link went down. It has no threshold.
    LossOfLink,
}

impl Symptom {
    /// In the order of their objects.
    pub const ALL: [Self; 7] = [
        Self::Collision,
        Self::LossOfSoc,
        Self::LossOfSoa,
        Self::LossOfPreq,
        Self::SocJitter,
        Self::Crc,
        Self::LossOfLink,
    ];

    /// The object that counts it.
    #[must_use]
    pub const fn object(self) -> u16 {
        match self {
            Self::Collision => 0x1C0A,
            Self::LossOfSoc => 0x1C0B,
            Self::LossOfSoa => 0x1C0C,
            Self::LossOfPreq => 0x1C0D,
            Self::SocJitter => 0x1C0E,
            Self::Crc => 0x1C0F,
            Self::LossOfLink => 0x1C10,
        }
    }

    /// The symptom that an object counts.
    #[must_use]
    pub fn of_object(index: u16) -> Option<Self> {
        Self::ALL.into_iter().find(|symptom| symptom.object() == index)
    }

    /// The error when it was once too often.
    #[must_use]
    pub const fn code(self) -> ErrorCode {
        match self {
            Self::Collision => ErrorCode::COLLISION_THRESHOLD,
            Self::LossOfSoc => ErrorCode::LOSS_OF_SOC_THRESHOLD,
            Self::LossOfSoa => ErrorCode::LOSS_OF_SOA_THRESHOLD,
            Self::LossOfPreq => ErrorCode::LOSS_OF_PREQ_THRESHOLD,
            Self::SocJitter => ErrorCode::JITTER_THRESHOLD,
            Self::Crc => ErrorCode::CRC_THRESHOLD,
            Self::LossOfLink => ErrorCode::LOSS_OF_LINK,
        }
    }

    pub(super) const fn index(self) -> usize {
        match self {
            Self::Collision => 0,
            Self::LossOfSoc => 1,
            Self::LossOfSoa => 2,
            Self::LossOfPreq => 3,
            Self::SocJitter => 4,
            Self::Crc => 5,
            Self::LossOfLink => 6,
        }
    }

    pub(super) const fn bit(self) -> u8 {
        match self {
            Self::Collision => 0x01,
            Self::LossOfSoc => 0x02,
            Self::LossOfSoa => 0x04,
            Self::LossOfPreq => 0x08,
            Self::SocJitter => 0x10,
            Self::Crc => 0x20,
            Self::LossOfLink => 0x40,
        }
    }
}

impl fmt::Display for Symptom {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Collision => "collision",
            Self::LossOfSoc => "loss of SoC",
            Self::LossOfSoa => "loss of SoA",
            Self::LossOfPreq => "loss of PReq",
            Self::SocJitter => "SoC jitter",
            Self::Crc => "CRC error",
            Self::LossOfLink => "loss of link",
        })
    }
}
