//! What can go wrong, in words that say what to do.

use std::io;

use link_core::ethernet::MacAddress;

/// Why a port could not be opened, or has failed for good. What happens on the network, and an interface that goes down, is no
/// error but an [`Input`](link_core::ethernet::Input).
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// There is no interface of that name.
    #[error("there is no interface {name}; {}", known(.present))]
    NoInterface {
        /// The name asked for.
        name: String,
        /// The Ethernet interfaces that there are.
        present: Vec<String>,
    },
    /// It is not an Ethernet interface.
    #[error("{name} is not an Ethernet interface; {}", known(.present))]
    NotEthernet {
        /// The name asked for.
        name: String,
        /// The Ethernet interfaces that there are.
        present: Vec<String>,
    },
    /// Not everybody may send and receive raw frames.
    #[error(
        "{name}: raw Ethernet frames need the right cap_net_raw: run it as root, or give the right to the program, as root: \
         setcap cap_net_raw+ep {program}"
    )]
    NoRight {
        /// The interface.
        name: String,
        /// The file of this program.
        program: String,
    },
    /// The kernel has no packet sockets.
    #[error("this kernel has no packet sockets: load the module af_packet (modprobe af_packet)")]
    NoPacketSockets,
    /// Numbers up to 0x05FF are lengths.
    #[error("0x{0:04X} is not an EtherType: those begin at 0x0600")]
    NotAnEtherType(u16),
    /// Another adapter has taken the name of the interface, or its address was changed.
    #[error("{name} came back with the address {is} instead of {was}: start again to use it")]
    OtherAddress {
        /// The interface.
        name: String,
        /// As it was when the port was opened.
        was: MacAddress,
        /// As it is.
        is: MacAddress,
    },
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
        "this machine has no Ethernet interface".into()
    } else {
        format!("there is {}", present.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_name_is_answered_with_the_right_ones() {
        let present = vec!["eth0".into(), "eth1".into()];
        let error = Error::NoInterface { name: "eht0".into(), present };
        assert_eq!(error.to_string(), "there is no interface eht0; there is eth0, eth1");
    }

    #[test]
    fn a_missing_right_names_the_command() {
        let error = Error::NoRight { name: "eth0".into(), program: "/usr/bin/devicenet".into() };
        assert_eq!(
            error.to_string(),
            "eth0: raw Ethernet frames need the right cap_net_raw: run it as root, or give the right to the program, as root: \
             setcap cap_net_raw+ep /usr/bin/devicenet"
        );
    }
}
