//! The states of a planned device, and the transitions between them.

use core::fmt;

/// What is known of a planned device.
///
/// ```text
///        +---------+ nobody answers +---------+  Hello    +-------+  ROAM   +----------+
///  Idle->| Probing |--------------->| Missing |---------->| Found |-------->| Assigned |
///        +---------+                +---------+ without   +-------+         +----------+
///             |                          |      address      ^                   | Hello with
///             | it answers               | spares may        |                   v the address
///             |                          v come in           |              +---------+
///             |                       +------+               |              | Joining |
///             |                       | Lost |---------------+              +---------+
///             |                       +------+    Hello without                  | on line
///             |                          ^        address                        v
///             |                          |     no answer                  +------------+
///             +--------------------------|-------------------------------->| Connecting |
///                                        |                                 +------------+
///                                   +----------+    time-out     +---------+    |  all made
///                                   | Retrying |<----------------| Running |<---+
///                                   +----------+                 +---------+
/// ```
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum DeviceState {
    /// The manager is not on line, or leaves the work to another one.
    Idle,
    /// The manager has just begun: whoever has the address already is asked who it is.
    Probing,
    /// Nobody has the address. Spares are left alone: the device itself may come up yet.
    Missing,
    /// A device for the address has none yet; it gets it as soon as it stands by.
    Found,
    /// It was sent the address.
    Assigned,
    /// It says Hello with the address.
    Joining,
    /// It is on line, and its connections are being made or looked at.
    Connecting,
    /// Its connections are as planned, and watched.
    Running,
    /// It fell silent: its connection is asked for again.
    Retrying,
    /// It is gone. Whoever may have the address gets it.
    Lost,
    /// Somebody has the address for whom it is not planned.
    Conflict,
}

/// Why a state was left.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Cause {
    /// The manager is on line, or works again.
    Started,
    /// The manager is off line, or leaves the work to another one.
    Stopped,
    /// Nobody answers.
    NoResponse,
    /// Who has the address is whom it is planned for.
    Identified,
    /// Who has the address is somebody else.
    OtherIdentity,
    /// A Hello without an address.
    HelloWithoutAddress,
    /// A Hello request with the planned address.
    HelloRequest,
    /// A Hello response with the planned address: who sends it is on line.
    HelloResponse,
    /// The ROAM was on the bus.
    RoamSent,
    /// No Hello with the address came after the last ROAM, or it did not stay; or the device has none still.
    NotTaken,
    /// The time to wait is over.
    WaitOver,
    /// All connections are made.
    Connected,
    /// A connection is no longer as planned, or may not be.
    Disturbed,
    /// Nothing was heard for four packet rates, or a poll was not answered.
    TimedOut,
    /// It does answer.
    Answered,
}

/// A transition; its number is that of the row in [`EDGES`].
pub type Edge = link_core::NumberedEdge<DeviceState, Cause>;

impl DeviceState {
    /// The name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Idle => "Idle",
            Self::Probing => "Probing",
            Self::Missing => "Missing",
            Self::Found => "Found",
            Self::Assigned => "Assigned",
            Self::Joining => "Joining",
            Self::Connecting => "Connecting",
            Self::Running => "Running",
            Self::Retrying => "Retrying",
            Self::Lost => "Lost",
            Self::Conflict => "Conflict",
        }
    }

    /// Whether nobody has the address, as far as is known.
    #[must_use]
    pub const fn is_absent(self) -> bool {
        matches!(self, Self::Missing | Self::Lost)
    }

    /// Whether a device is on line with the address.
    #[must_use]
    pub const fn is_on_line(self) -> bool {
        matches!(self, Self::Connecting | Self::Running | Self::Retrying)
    }
}

impl fmt::Display for DeviceState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl Cause {
    /// In words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Started => "started",
            Self::Stopped => "stopped",
            Self::NoResponse => "no response",
            Self::Identified => "identified",
            Self::OtherIdentity => "other identity",
            Self::HelloWithoutAddress => "Hello without address",
            Self::HelloRequest => "Hello request",
            Self::HelloResponse => "Hello response",
            Self::RoamSent => "ROAM sent",
            Self::NotTaken => "not taken",
            Self::WaitOver => "wait over",
            Self::Connected => "connected",
            Self::Disturbed => "disturbed",
            Self::TimedOut => "timed out",
            Self::Answered => "answered",
        }
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Every transition. Debug builds check each step against it.
///
/// | Row | From | Cause | To |
/// |---|---|---|---|
/// | 1 | Idle | started | Probing |
/// | 2 | Probing | no response | Missing |
/// | 2 | Probing | identified | Connecting |
/// | 2 | Probing | other identity | Conflict |
/// | 2 | Probing | Hello request | Joining |
/// | 2 | Probing | Hello response | Connecting |
/// | 3 | Missing | Hello without address | Found |
/// | 3 | Missing | Hello request | Joining |
/// | 3 | Missing | Hello response | Connecting |
/// | 3 | Missing | other identity | Conflict |
/// | 3 | Missing | wait over | Lost |
/// | 3 | Missing | not taken | Lost |
/// | 4 | Found | ROAM sent | Assigned |
/// | 4 | Found | Hello request | Joining |
/// | 4 | Found | Hello response | Connecting |
/// | 4 | Found | other identity | Conflict |
/// | 5 | Assigned | Hello request | Joining |
/// | 5 | Assigned | Hello without address | Found |
/// | 5 | Assigned | wait over | Found |
/// | 5 | Assigned | not taken | Missing |
/// | 5 | Assigned | not taken | Lost |
/// | 5 | Assigned | Hello response | Connecting |
/// | 5 | Assigned | other identity | Conflict |
/// | 6 | Joining | wait over | Connecting |
/// | 6 | Joining | Hello without address | Found |
/// | 6 | Joining | not taken | Missing |
/// | 6 | Joining | not taken | Lost |
/// | 6 | Joining | Hello response | Connecting |
/// | 6 | Joining | other identity | Conflict |
/// | 7 | Connecting | connected | Running |
/// | 7 | Connecting | no response | Lost |
/// | 7 | Connecting | timed out | Retrying |
/// | 7 | Connecting | Hello request | Joining |
/// | 7 | Connecting | Hello response | Connecting |
/// | 7 | Connecting | Hello without address | Found |
/// | 7 | Connecting | other identity | Conflict |
/// | 8 | Running | disturbed | Connecting |
/// | 8 | Running | timed out | Retrying |
/// | 8 | Running | Hello request | Joining |
/// | 8 | Running | Hello response | Connecting |
/// | 8 | Running | Hello without address | Found |
/// | 8 | Running | other identity | Conflict |
/// | 9 | Retrying | answered | Connecting |
/// | 9 | Retrying | no response | Lost |
/// | 9 | Retrying | Hello request | Joining |
/// | 9 | Retrying | Hello response | Connecting |
/// | 9 | Retrying | Hello without address | Found |
/// | 9 | Retrying | other identity | Conflict |
/// | 10 | Lost | Hello without address | Found |
/// | 10 | Lost | Hello request | Joining |
/// | 10 | Lost | Hello response | Connecting |
/// | 10 | Lost | other identity | Conflict |
/// | 11 | Conflict | wait over | Probing |
/// | 11 | Conflict | Hello response | Connecting |
/// | 12 | Probing | stopped | Idle |
/// | 12 | Missing | stopped | Idle |
/// | 12 | Found | stopped | Idle |
/// | 12 | Assigned | stopped | Idle |
/// | 12 | Joining | stopped | Idle |
/// | 12 | Connecting | stopped | Idle |
/// | 12 | Running | stopped | Idle |
/// | 12 | Retrying | stopped | Idle |
/// | 12 | Lost | stopped | Idle |
/// | 12 | Conflict | stopped | Idle |
///
/// Rows 4 to 7: paper 1-4 to 1-7 **\[P\]**. Row 3: when spares may come in is a decision **\[D\]**. Rows 8 and 9: paper 1-8
/// **\[P\]**. A Hello without an address of the very device that had one tells that it was restarted **\[D\]**.
pub const EDGES: &[Edge] = {
    use Cause::*;
    use DeviceState::*;
    &[
        edge(1, Idle, Started, Probing),
        edge(2, Probing, NoResponse, Missing),
        edge(2, Probing, Identified, Connecting),
        edge(2, Probing, OtherIdentity, Conflict),
        edge(2, Probing, HelloRequest, Joining),
        edge(2, Probing, HelloResponse, Connecting),
        edge(3, Missing, HelloWithoutAddress, Found),
        edge(3, Missing, HelloRequest, Joining),
        edge(3, Missing, HelloResponse, Connecting),
        edge(3, Missing, OtherIdentity, Conflict),
        edge(3, Missing, WaitOver, Lost),
        edge(3, Missing, NotTaken, Lost),
        edge(4, Found, RoamSent, Assigned),
        edge(4, Found, HelloRequest, Joining),
        edge(4, Found, HelloResponse, Connecting),
        edge(4, Found, OtherIdentity, Conflict),
        edge(5, Assigned, HelloRequest, Joining),
        edge(5, Assigned, HelloWithoutAddress, Found),
        edge(5, Assigned, WaitOver, Found),
        edge(5, Assigned, NotTaken, Missing),
        edge(5, Assigned, NotTaken, Lost),
        edge(5, Assigned, HelloResponse, Connecting),
        edge(5, Assigned, OtherIdentity, Conflict),
        edge(6, Joining, WaitOver, Connecting),
        edge(6, Joining, HelloWithoutAddress, Found),
        edge(6, Joining, NotTaken, Missing),
        edge(6, Joining, NotTaken, Lost),
        edge(6, Joining, HelloResponse, Connecting),
        edge(6, Joining, OtherIdentity, Conflict),
        edge(7, Connecting, Connected, Running),
        edge(7, Connecting, NoResponse, Lost),
        edge(7, Connecting, TimedOut, Retrying),
        edge(7, Connecting, HelloRequest, Joining),
        edge(7, Connecting, HelloResponse, Connecting),
        edge(7, Connecting, HelloWithoutAddress, Found),
        edge(7, Connecting, OtherIdentity, Conflict),
        edge(8, Running, Disturbed, Connecting),
        edge(8, Running, TimedOut, Retrying),
        edge(8, Running, HelloRequest, Joining),
        edge(8, Running, HelloResponse, Connecting),
        edge(8, Running, HelloWithoutAddress, Found),
        edge(8, Running, OtherIdentity, Conflict),
        edge(9, Retrying, Answered, Connecting),
        edge(9, Retrying, NoResponse, Lost),
        edge(9, Retrying, HelloRequest, Joining),
        edge(9, Retrying, HelloResponse, Connecting),
        edge(9, Retrying, HelloWithoutAddress, Found),
        edge(9, Retrying, OtherIdentity, Conflict),
        edge(10, Lost, HelloWithoutAddress, Found),
        edge(10, Lost, HelloRequest, Joining),
        edge(10, Lost, HelloResponse, Connecting),
        edge(10, Lost, OtherIdentity, Conflict),
        edge(11, Conflict, WaitOver, Probing),
        edge(11, Conflict, HelloResponse, Connecting),
        edge(12, Probing, Stopped, Idle),
        edge(12, Missing, Stopped, Idle),
        edge(12, Found, Stopped, Idle),
        edge(12, Assigned, Stopped, Idle),
        edge(12, Joining, Stopped, Idle),
        edge(12, Connecting, Stopped, Idle),
        edge(12, Running, Stopped, Idle),
        edge(12, Retrying, Stopped, Idle),
        edge(12, Lost, Stopped, Idle),
        edge(12, Conflict, Stopped, Idle),
    ]
};

const fn edge(number: u8, from: DeviceState, cause: Cause, to: DeviceState) -> Edge {
    Edge { number, from, cause, to }
}
