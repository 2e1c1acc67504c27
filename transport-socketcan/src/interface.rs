//! A CAN interface of the machine: what it is, and what netlink can do to it.

mod link_kind;

use core::time::Duration;
use std::fs;
use std::io;

use link_core::{BitRate, Mode};
use socketcan::CanInterface;
use socketcan::nl::{CanCtrlMode, CanState, InterfaceCanParams};

use crate::error::{Error, Refusal};
use link_kind::link_kind;

/// What an interface is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kind {
    /// It has a controller, with a bit rate.
    Controller {
        /// `None` where it was not set by netlink: not at all, or by the program that attached an `slcan` adapter.
        bit_rate: Option<BitRate>,
        /// It neither sends nor acknowledges.
        listen_only: bool,
    },
    /// It has a bit rate, which its driver does not tell: an `slcan` adapter before Linux 6.0.
    HiddenBitRate,
    /// `vcan` or `vxcan`.
    WithoutBitRate,
}

/// A CAN interface, by its name. Its index changes when an adapter is unplugged and comes back.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Interface {
    name: String,
}

impl Interface {
    /// Looks an interface up.
    ///
    /// # Errors
    /// [`Error::NoInterface`] and [`Error::NotCan`], with the names of those that there are.
    pub fn find(name: &str) -> Result<Self, Error> {
        let name = name.to_owned();
        match hardware_type(&name) {
            Some(ARPHRD_CAN) => Ok(Self { name }),
            Some(_) => Err(Error::NotCan { name, present: Self::names() }),
            None => Err(Error::NoInterface { name, present: Self::names() }),
        }
    }

    /// The names of all CAN interfaces.
    #[must_use]
    pub fn names() -> Vec<String> {
        let entries = fs::read_dir(CLASS_NET).into_iter().flatten().flatten();
        let mut names: Vec<String> = entries
            .filter_map(|entry| entry.file_name().into_string().ok())
            .filter(|name| hardware_type(name) == Some(ARPHRD_CAN))
            .collect();
        names.sort();
        names
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its present index; `None` while it is unplugged.
    pub(crate) fn index(&self) -> Option<u32> {
        fs::read_to_string(format!("{CLASS_NET}/{}/ifindex", self.name)).ok()?.trim().parse().ok()
    }

    /// Whether it is there and up.
    #[must_use]
    pub fn is_up(&self) -> bool {
        self.flags() & IFF_UP != 0
    }

    /// Whether it echoes a frame when that was on the bus, as controllers do. For one that does not, such as `vcan`, the
    /// kernel makes the echo when the interface has taken the frame.
    #[must_use]
    pub fn has_echo(&self) -> bool {
        self.flags() & IFF_ECHO != 0
    }

    fn flags(&self) -> u32 {
        let flags = fs::read_to_string(format!("{CLASS_NET}/{}/flags", self.name)).unwrap_or_default();
        u32::from_str_radix(flags.trim().trim_start_matches("0x"), 16).unwrap_or(0)
    }

    /// What it is, and in which mode.
    ///
    /// # Errors
    /// What netlink says.
    pub fn kind(&self) -> io::Result<Kind> {
        let index = self.present_index()?;
        let parameters = CanInterface::open_iface(index).can_params().map_err(io_error)?;
        Ok(kind(link_kind(index)?.as_deref(), &parameters))
    }

    /// Whether its controller is off the bus. One that does not tell is not.
    pub(crate) fn is_bus_off(&self) -> bool {
        self.netlink().is_ok_and(|netlink| matches!(netlink.state(), Ok(Some(CanState::BusOff))))
    }

    /// Sets bit rate and mode, for which it goes down and up again. `false`: they were in force already.
    pub(crate) fn set_mode(&self, mode: Mode) -> Result<bool, Refusal> {
        let name = || self.name.clone();
        let refused = |error: io::Error| Refusal::Mode { name: name(), mode, reason: error.to_string() };
        match self.kind().map_err(refused)? {
            Kind::WithoutBitRate => return Ok(false),
            Kind::Controller { bit_rate, listen_only }
                if (bit_rate, listen_only) == (Some(mode.bit_rate), mode.listen_only) =>
            {
                return Ok(false);
            }
            _ if mode.bit_rate.0 == 0 || mode.bit_rate > BitRate::M1 => {
                return Err(Refusal::BitRate { name: name(), bit_rate: mode.bit_rate });
            }
            Kind::HiddenBitRate => return Err(Refusal::HiddenBitRate { name: name(), mode }),
            Kind::Controller { .. } => {}
        }
        let netlink = self.netlink().map_err(refused)?;
        netlink.bring_down().map_err(io_error).map_err(refused)?;
        let bit_rate = netlink.set_bitrate(mode.bit_rate.0, None).map_err(io_error);
        let listen_only = netlink.set_ctrlmode(CanCtrlMode::ListenOnly, mode.listen_only).map_err(io_error);
        // Whatever came of it, an interface that was up is not left down.
        let up = netlink.bring_up().map_err(io_error);
        bit_rate.map_err(refused)?;
        listen_only.map_err(|error| match error.raw_os_error() {
            Some(libc::EOPNOTSUPP) => Refusal::NoListenOnly { name: name() },
            _ => refused(error),
        })?;
        up.map_err(refused)?;
        Ok(true)
    }

    /// Takes the controller out of bus-off, unless the kernel does it.
    pub(crate) fn restart(&self) -> io::Result<Restart> {
        let netlink = self.netlink()?;
        let restart = restart(&netlink.can_params().map_err(io_error)?);
        if restart == Restart::Now {
            netlink.restart().map_err(io_error)?;
        }
        Ok(restart)
    }

    fn netlink(&self) -> io::Result<CanInterface> {
        Ok(CanInterface::open_iface(self.present_index()?))
    }

    fn present_index(&self) -> io::Result<u32> {
        self.index().ok_or_else(|| io::Error::from_raw_os_error(libc::ENODEV))
    }
}

/// How a controller comes out of bus-off.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Restart {
    /// It is not off the bus, or there is none.
    NotNeeded,
    /// When it is told to.
    Now,
    /// By the kernel, so long after the bus-off; which then takes no command to do it.
    ByItself(Duration),
}

fn restart(parameters: &InterfaceCanParams) -> Restart {
    match (parameters.state, parameters.restart_ms) {
        (Some(CanState::BusOff), Some(millis)) if millis > 0 => {
            Restart::ByItself(Duration::from_millis(millis.into()))
        }
        (Some(CanState::BusOff), _) => Restart::Now,
        _ => Restart::NotNeeded,
    }
}

fn kind(link_kind: Option<&str>, parameters: &InterfaceCanParams) -> Kind {
    if matches!(link_kind, Some("vcan" | "vxcan")) {
        return Kind::WithoutBitRate;
    }
    // Every controller that netlink knows has a state.
    if parameters.state.is_none() {
        return Kind::HiddenBitRate;
    }
    let bit_rate = parameters.bit_timing.map(|timing| BitRate(timing.bitrate));
    Kind::Controller {
        bit_rate: bit_rate.filter(|rate| rate.0 > 0 && *rate != BIT_RATE_UNKNOWN),
        listen_only: parameters.ctrl_mode.is_some_and(|modes| modes.has_mode(CanCtrlMode::ListenOnly)),
    }
}

fn hardware_type(name: &str) -> Option<u32> {
    // A name with a slash would be another file.
    if name.contains('/') {
        return None;
    }
    fs::read_to_string(format!("{CLASS_NET}/{name}/type")).ok()?.trim().parse().ok()
}

/// The kernel's own words, where it said a number.
fn io_error(error: socketcan::Error) -> io::Error {
    match error {
        socketcan::Error::Io(error) => error,
        other => io::Error::other(other),
    }
}

const CLASS_NET: &str = "/sys/class/net";
/// linux/if_arp.h
const ARPHRD_CAN: u32 = 280;
/// linux/if.h
const IFF_UP: u32 = 1;
const IFF_ECHO: u32 = 1 << 18;
/// `CAN_BITRATE_UNKNOWN`, linux/can/bittiming.h. A kernel that knows the name keeps the number to itself.
const BIT_RATE_UNKNOWN: BitRate = BitRate(u32::MAX);

#[cfg(test)]
mod tests {
    use super::*;
    use socketcan::nl::CanBitTiming;

    #[test]
    fn what_is_no_can_interface_is_told_apart() {
        assert!(matches!(Interface::find("lo"), Err(Error::NotCan { .. })));
        assert!(matches!(Interface::find("no-such-interface"), Err(Error::NoInterface { .. })));
        assert!(matches!(Interface::find("../net/lo"), Err(Error::NoInterface { .. })));
        assert!(matches!(Interface::find(""), Err(Error::NoInterface { .. })));
    }

    #[test]
    fn the_kind_of_a_link_is_that_of_its_driver() {
        assert_eq!(link_kind(1).unwrap(), None, "the loopback interface has none");
        assert_eq!(link_kind(0x7FFF_FFFF).unwrap_err().raw_os_error(), Some(libc::ENODEV));
    }

    #[test]
    fn a_kernel_that_restarts_by_itself_is_not_told_to() {
        let parameters = |state, restart_ms| InterfaceCanParams { state, restart_ms, ..Default::default() };
        assert_eq!(restart(&parameters(None, None)), Restart::NotNeeded);
        assert_eq!(restart(&parameters(Some(CanState::ErrorPassive), Some(100))), Restart::NotNeeded);
        assert_eq!(restart(&parameters(Some(CanState::BusOff), None)), Restart::Now);
        assert_eq!(restart(&parameters(Some(CanState::BusOff), Some(0))), Restart::Now);
        let by_itself = Restart::ByItself(Duration::from_millis(100));
        assert_eq!(restart(&parameters(Some(CanState::BusOff), Some(100))), by_itself);
    }

    #[test]
    fn only_a_virtual_interface_has_every_bit_rate() {
        let silent = InterfaceCanParams::default();
        assert_eq!(kind(Some("vcan"), &silent), Kind::WithoutBitRate);
        assert_eq!(kind(Some("vxcan"), &silent), Kind::WithoutBitRate);
        assert_eq!(kind(None, &silent), Kind::HiddenBitRate);
        assert_eq!(kind(Some("can"), &silent), Kind::HiddenBitRate);
    }

    #[test]
    fn a_bit_rate_that_was_not_set_confirms_nothing() {
        for (bitrate, expected) in [(0, None), (u32::MAX, None), (125_000, Some(BitRate::K125))] {
            let timing = CanBitTiming { bitrate, ..CanBitTiming::default() };
            let parameters = InterfaceCanParams {
                state: Some(CanState::ErrorActive),
                bit_timing: Some(timing),
                ..InterfaceCanParams::default()
            };
            let expected = Kind::Controller { bit_rate: expected, listen_only: false };
            assert_eq!(kind(Some("can"), &parameters), expected);
        }
    }
}
