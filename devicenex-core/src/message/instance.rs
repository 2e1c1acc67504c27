//! The numbers of connections: what each stands for.

use core::fmt;

use cip_core::code::InstanceId;

/// What the number of a connection says (paper figure 9) **\[P\]**.
///
/// | Instance | Connection |
/// |---|---|
/// | 1 | explicit messages |
/// | 2 / 3 | polled implicit, 11 / 29 bits |
/// | 4 / 5 | broadcast implicit, 11 / 29 bits |
/// | 6 / 7 | multicast implicit, 11 / 29 bits: the producing end **\[D\]** |
/// | 8 / 9 | change of state implicit, 11 / 29 bits |
/// | 10 / 11 | cyclic implicit, 11 / 29 bits |
/// | 12 / 13 | multicast implicit, 11 / 29 bits: the consuming end **\[D\]** |
/// | 14-127 | reserved |
/// | 128-255 | dynamic connections |
/// | 256-65535 | reserved; and 0, which the figure leaves out **\[D\]** |
///
/// The text of the paper reserves 14 to 65535, the figure leaves 128 to 255 to dynamic connections: we follow the figure
/// **\[R\]**. The figure lists multicast twice.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum ConnectionInstance {
    /// 1 to 13.
    Predefined(Predefined),
    /// 128 to 255.
    Dynamic(u8),
    /// All others.
    Reserved(InstanceId),
}

/// A connection of the predefined set.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Predefined {
    /// 1
    Explicit,
    /// 2 to 13
    Implicit(Production, IdentifierLength),
}

/// What makes a node produce on an implicit connection of the predefined set.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Production {
    /// A request of the other end.
    Polled,
    /// To everybody.
    Broadcast,
    /// To several, the producing end.
    MulticastProducer,
    /// New data.
    ChangeOfState,
    /// The passing of time.
    Cyclic,
    /// From one to several, the consuming end.
    MulticastConsumer,
}

/// The identifier format of a connection.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum IdentifierLength {
    /// 11 bits.
    Standard,
    /// 29 bits.
    Extended,
}

impl ConnectionInstance {
    /// What the number stands for.
    #[must_use]
    pub fn of(instance: InstanceId) -> Self {
        let Ok(number) = u8::try_from(instance.0) else { return Self::Reserved(instance) };
        if number >= FIRST_DYNAMIC {
            return Self::Dynamic(number);
        }
        Predefined::of(number).map_or(Self::Reserved(instance), Self::Predefined)
    }

    /// The number.
    #[must_use]
    pub fn number(self) -> InstanceId {
        match self {
            Self::Predefined(predefined) => InstanceId(predefined.number().into()),
            Self::Dynamic(number) => InstanceId(number.into()),
            Self::Reserved(instance) => instance,
        }
    }
}

impl Predefined {
    fn of(number: u8) -> Option<Self> {
        if number == 1 {
            return Some(Self::Explicit);
        }
        let production = *Production::ALL.get(usize::from(number.checked_sub(2)? >> 1))?;
        let length = if number & 1 == 0 { IdentifierLength::Standard } else { IdentifierLength::Extended };
        Some(Self::Implicit(production, length))
    }

    /// 1 to 13.
    #[must_use]
    pub const fn number(self) -> u8 {
        match self {
            Self::Explicit => 1,
            Self::Implicit(production, IdentifierLength::Standard) => production.standard_instance(),
            Self::Implicit(production, IdentifierLength::Extended) => production.standard_instance() | 1,
        }
    }
}

impl Production {
    /// In the order of their instances.
    pub const ALL: [Self; 6] = [
        Self::Polled,
        Self::Broadcast,
        Self::MulticastProducer,
        Self::ChangeOfState,
        Self::Cyclic,
        Self::MulticastConsumer,
    ];

    /// The instance with 11 bits; that with 29 is the next one.
    const fn standard_instance(self) -> u8 {
        match self {
            Self::Polled => 2,
            Self::Broadcast => 4,
            Self::MulticastProducer => 6,
            Self::ChangeOfState => 8,
            Self::Cyclic => 10,
            Self::MulticastConsumer => 12,
        }
    }

    /// In words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Polled => "polled",
            Self::Broadcast => "broadcast",
            Self::MulticastProducer => "multicast, producing",
            Self::ChangeOfState => "change of state",
            Self::Cyclic => "cyclic",
            Self::MulticastConsumer => "multicast, consuming",
        }
    }
}

/// `polled, 29 bits`; `dynamic 128`; `reserved 14`.
impl fmt::Display for ConnectionInstance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Predefined(Predefined::Explicit) => f.write_str("explicit"),
            Self::Predefined(Predefined::Implicit(production, length)) => {
                let bits = match length {
                    IdentifierLength::Standard => 11,
                    IdentifierLength::Extended => 29,
                };
                write!(f, "{}, {bits} bits", production.name())
            }
            Self::Dynamic(number) => write!(f, "dynamic {number}"),
            Self::Reserved(instance) => write!(f, "reserved {}", instance.0),
        }
    }
}

const FIRST_DYNAMIC: u8 = 128;

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    /// Paper figure 9, row by row.
    #[test]
    fn all_65536_instances_are_those_of_figure_9() {
        for number in 0..=u16::MAX {
            let instance = ConnectionInstance::of(InstanceId(number));
            assert_eq!(instance.number(), InstanceId(number));
            let expected = match number {
                1 => "explicit",
                2 => "polled, 11 bits",
                3 => "polled, 29 bits",
                4 => "broadcast, 11 bits",
                5 => "broadcast, 29 bits",
                6 => "multicast, producing, 11 bits",
                7 => "multicast, producing, 29 bits",
                8 => "change of state, 11 bits",
                9 => "change of state, 29 bits",
                10 => "cyclic, 11 bits",
                11 => "cyclic, 29 bits",
                12 => "multicast, consuming, 11 bits",
                13 => "multicast, consuming, 29 bits",
                128..=255 => {
                    assert!(matches!(instance, ConnectionInstance::Dynamic(_)), "{number}");
                    continue;
                }
                _ => {
                    assert!(matches!(instance, ConnectionInstance::Reserved(_)), "{number}");
                    continue;
                }
            };
            assert_eq!(instance.to_string(), expected);
        }
    }
}
