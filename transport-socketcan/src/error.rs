//! What can go wrong, in words that say what to do.

use std::io;

use link_core::{BitRate, Mode};

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
    /// It is no bit rate of classic CAN.
    #[error("{name}: cannot set {bit_rate}: classic CAN goes up to 1 Mbit/s")]
    BitRate {
        /// The interface.
        name: String,
        /// What was asked for.
        bit_rate: BitRate,
    },
    /// The driver knows no listen-only mode. The bit rate is set.
    #[error(
        "{name}: its driver has no listen-only mode: nothing is sent, but the controller acknowledges the frames of others"
    )]
    NoListenOnly {
        /// The interface.
        name: String,
    },
    /// The driver does not tell the bit rate, so whether it is the right one is not known.
    #[error(
        "{name}: its driver neither tells nor sets the bit rate; an slcan adapter gets {} when it is attached, as root: \
         slcand {} TTY {name}", words(.mode), slcand(.mode)
    )]
    HiddenBitRate {
        /// The interface.
        name: String,
        /// What was asked for.
        mode: Mode,
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

/// Why nobody can tell what became of a frame: what [`TxOutcome::Unknown`](link_core::TxOutcome::Unknown) stands for.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Unconfirmed {
    /// The socket has lost what it received, of which the echo of the frame may have been part.
    #[error(
        "frames were lost that came faster than they were read, and with them what became of an own one: it may be sent twice"
    )]
    Overrun,
    /// Nothing that the filters let pass was heard while the frame was waited for, and no error.
    #[error(
        "its driver tells neither that a frame was sent nor of an error: so it is when nobody acknowledges, alone on the bus or at the \
         wrong bit rate"
    )]
    Silence,
    /// Others were heard meanwhile, or errors.
    #[error("its driver does not tell that a frame was sent, though others are heard: it may be sent twice")]
    Unheard,
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

/// The options that open an adapter in this mode. Its command `S` has a number for each bit rate that it knows.
fn slcand(mode: &Mode) -> String {
    let number = SLCAN_BIT_RATES.iter().position(|rate| *rate == mode.bit_rate.0);
    let number = number.map_or_else(|| "N".into(), |number| number.to_string());
    format!("{} -s{number}", if mode.listen_only { "-l" } else { "-o" })
}

/// In bit/s, by the number of the command `S` (LAWICEL CAN232 manual).
const SLCAN_BIT_RATES: [u32; 9] =
    [10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000];

#[cfg(test)]
mod tests {
    use super::*;

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
    fn an_adapter_that_hides_its_bit_rate_gets_it_when_it_is_attached() {
        let mode = Mode { bit_rate: BitRate::K500, listen_only: false };
        let refusal = Refusal::HiddenBitRate { name: "slcan0".into(), mode };
        assert_eq!(
            refusal.to_string(),
            "slcan0: its driver neither tells nor sets the bit rate; an slcan adapter gets 500 kbit/s when it is attached, \
             as root: slcand -o -s6 TTY slcan0"
        );
        let mode = Mode { bit_rate: BitRate::K125, listen_only: true };
        let refusal = Refusal::HiddenBitRate { name: "slcan0".into(), mode };
        assert!(refusal.to_string().ends_with("slcand -l -s4 TTY slcan0"), "{refusal}");
    }

    /// Where no command helps, none is named.
    #[test]
    fn a_mode_that_cannot_be_had_names_no_command() {
        let name = || "can0".to_owned();
        let refusals = [
            Refusal::BitRate { name: name(), bit_rate: BitRate(2_000_000) },
            Refusal::NoListenOnly { name: name() },
        ];
        for refusal in refusals {
            assert!(!refusal.to_string().contains("ip link"), "{refusal}");
        }
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
