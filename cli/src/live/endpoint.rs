//! Where a command works: `can0`, `sim:FILE`, `log:FILE`.

use core::fmt;
use core::str::FromStr;
use std::path::PathBuf;

use link_core::Instant;

use crate::exit::Failure;
use crate::scenario::Time;
use crate::standard::is_standard;

/// An interface, a scenario or a recording.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Endpoint {
    /// A CAN interface, by its name.
    Interface(String),
    /// A scenario on the simulated bus, in virtual time.
    Scenario(PathBuf),
    /// A recording, which can only be listened to.
    Recording(PathBuf),
}

impl Endpoint {
    /// Whether it is read from standard input.
    pub(super) fn is_standard_input(&self) -> bool {
        matches!(self, Self::Recording(path) if is_standard(path))
    }

    /// `sim:line.toml: the scenario ended at 5s`
    pub(super) fn ended(&self, at: Instant) -> String {
        let what = match self {
            Self::Interface(_) => "the interface",
            Self::Scenario(_) => "the scenario",
            Self::Recording(_) => "the recording",
        };
        format!("{self}: {what} ended at {}", Time(at.saturating_since(Instant::ZERO)))
    }

    /// A command that has not come to its end because the scenario has.
    pub(super) fn ended_before(&self, at: Instant, what: &str) -> Failure {
        let ended = self.ended(at);
        Failure::Usage(format!("{ended}, before {what}: make its duration longer, or --listen shorter"))
    }
}

impl FromStr for Endpoint {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // The kernel takes no interface with a colon or a slash in its name.
        match text.split_once(':') {
            Some(("sim", file)) if !file.is_empty() => Ok(Self::Scenario(file.into())),
            Some(("log", file)) if !file.is_empty() => Ok(Self::Recording(file.into())),
            None if text == "-" => Err("standard input is a recording: write log:-".into()),
            None if text.contains('/') => Err(format!(
                "no interface has a / in its name: write log:{text} for a recording, sim:{text} for a scenario"
            )),
            None if !text.is_empty() => Ok(Self::Interface(text.to_owned())),
            _ => Err("an interface such as can0, sim:FILE or log:FILE expected".into()),
        }
    }
}

impl fmt::Display for Endpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Interface(name) => f.write_str(name),
            Self::Scenario(path) => write!(f, "sim:{}", path.display()),
            Self::Recording(path) => write!(f, "log:{}", path.display()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endpoints_as_they_are_written() {
        for (text, endpoint) in [
            ("can0", Endpoint::Interface("can0".into())),
            ("sim:plant.toml", Endpoint::Scenario("plant.toml".into())),
            ("log:a:b.log", Endpoint::Recording("a:b.log".into())),
        ] {
            assert_eq!(text.parse(), Ok(endpoint.clone()));
            assert_eq!(endpoint.to_string(), text);
        }
        for text in ["", "-", ":", "sim:", "log:", "LOG:a.log", "can0:1", "captures/a.log"] {
            assert!(text.parse::<Endpoint>().is_err(), "{text}");
        }
    }
}
