//! What the data of a connection mean.

use core::fmt;

/// One direction of a connection.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum End {
    /// From the device.
    Produced,
    /// To the device.
    Consumed,
}

/// What the data that a connection consumes mean at present.
///
/// | Received | Mode | Outputs |
/// |---|---|---|
/// | nothing yet | `Inactive` | as they were |
/// | a full message | `Run` | the data |
/// | an empty message, where data are expected | `Idle` | those of idle or fault |
/// | nothing in time, or the connection was taken away | `Fault` | those of idle or fault |
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum IoMode {
    /// No message was consumed since the connection was established.
    #[default]
    Inactive,
    /// The producer runs.
    Run,
    /// The producer is there but does not run.
    Idle,
    /// The producer is lost.
    Fault,
}

impl fmt::Display for IoMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Inactive => "inactive",
            Self::Run => "run",
            Self::Idle => "idle",
            Self::Fault => "fault",
        })
    }
}
