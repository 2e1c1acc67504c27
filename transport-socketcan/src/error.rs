//! What can go wrong, in words that say what to do.

use std::io;

use link_core::Mode;

/// Why a port could not be opened, or has failed for good. What happens on the bus, and an interface that goes down, is no
/// error but an [`Input`](link_core::Input).
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// There is no interface of that name.
    #[error("there is no interface {name}; {}", known(.present))]
    NoInterface {
        /// The name asked for.
        name: String,
        /// The CAN interfaces that there are.
        present: Vec<String>,
    },
    /// It is not a CAN interface.
    #[error("{name} is not a CAN interface; {}", known(.present))]
    NotCan {
        /// The name asked for.
        name: String,
        /// The CAN interfaces that there are.
        present: Vec<String>,
    },
    /// The kernel has no CAN sockets.
    #[error("this kernel has no CAN sockets: load the module can_raw (modprobe can_raw)")]
    NoSocketCan,
    /// An operation on the socket failed.
    #[error("{name}: {what}: {source}")]
    Socket {
        /// The interface.
        name: String,
        /// What was tried.
        what: &'static str,
        /// What the kernel says.
        source: io::Error,
    },
}

fn known(present: &[String]) -> String {
    if present.is_empty() {
        "this machine has no CAN interface: plug in the adapter, or make a virtual one with \
         `ip link add vcan0 type vcan && ip link set vcan0 up`"
            .into()
    } else {
        format!("there is {}", present.join(", "))
    }
}

/// Why a [`LinkCommand`](link_core::LinkCommand) was refused, and the command that does what was asked.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Refusal {
    /// The bit rate or the mode could not be set.
    #[error("{name}: cannot set {} ({reason}); as root: {}", words(.mode), set_mode(.name, .mode))]
    Mode {
        /// The interface.
        name: String,
        /// What was asked for.
        mode: Mode,
        /// What the kernel says.
        reason: String,
    },
    /// The controller could not be taken out of bus-off.
    #[error("{name}: cannot restart the controller ({reason}); as root: ip link set {name} type can restart")]
    Restart {
        /// The interface.
        name: String,
        /// What the kernel says.
        reason: String,
    },
    /// The filters could not be set: the machine gets every frame.
    #[error("{name}: cannot set the acceptance filter ({reason}); every frame is delivered")]
    Filter {
        /// The interface.
        name: String,
        /// What the kernel says.
        reason: String,
    },
}

fn words(mode: &Mode) -> String {
    format!("{}{}", mode.bit_rate, if mode.listen_only { ", listen-only" } else { "" })
}

fn set_mode(name: &str, mode: &Mode) -> String {
    let listen_only = if mode.listen_only { "on" } else { "off" };
    format!(
        "ip link set {name} down && ip link set {name} type can bitrate {} listen-only {listen_only} && ip link set {name} up",
        mode.bit_rate.0
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use link_core::BitRate;

    #[test]
    fn a_refusal_names_the_command() {
        let mode = Mode { bit_rate: BitRate::K250, listen_only: true };
        let refusal = Refusal::Mode { name: "can0".into(), mode, reason: "Operation not permitted".into() };
        assert_eq!(
            refusal.to_string(),
            "can0: cannot set 250 kbit/s, listen-only (Operation not permitted); as root: ip link set can0 down && \
             ip link set can0 type can bitrate 250000 listen-only on && ip link set can0 up"
        );
    }

    #[test]
    fn a_wrong_name_is_answered_with_the_right_ones() {
        let present = vec!["can0".into(), "vcan0".into()];
        assert_eq!(
            Error::NoInterface { name: "kan0".into(), present }.to_string(),
            "there is no interface kan0; there is can0, vcan0"
        );
        let nothing = Error::NoInterface { name: "can0".into(), present: vec![] }.to_string();
        assert!(nothing.contains("ip link add vcan0 type vcan"), "{nothing}");
    }
}
