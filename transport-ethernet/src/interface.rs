//! An Ethernet interface of the machine.

use link_core::ethernet::MacAddress;
use nix::ifaddrs::getifaddrs;
use nix::net::if_::InterfaceFlags;
use nix::sys::socket::SockaddrStorage;

use crate::error::Error;

/// An Ethernet interface. Its index changes when an adapter is unplugged and comes back.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Interface {
    name: String,
    index: i32,
    mac: MacAddress,
    has_link: bool,
}

impl Interface {
    /// Looks an interface up.
    ///
    /// # Errors
    /// [`Error::NoInterface`] and [`Error::NotEthernet`], with the names of those that there are.
    pub fn find(name: &str) -> Result<Self, Error> {
        let all = all();
        let names = || names(&all);
        match all.iter().find(|found| found.name == name) {
            Some(Found { ethernet: Some(interface), .. }) => Ok(interface.clone()),
            Some(_) => Err(Error::NotEthernet { name: name.to_owned(), present: names() }),
            None => Err(Error::NoInterface { name: name.to_owned(), present: names() }),
        }
    }

    /// The names of all Ethernet interfaces.
    #[must_use]
    pub fn names() -> Vec<String> {
        names(&all())
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The address of its adapter.
    #[must_use]
    pub const fn mac(&self) -> MacAddress {
        self.mac
    }

    /// Whether it is up, and its cable plugged in: as it was when it was looked up, or of a port when it was last told.
    #[must_use]
    pub const fn has_link(&self) -> bool {
        self.has_link
    }

    pub(crate) const fn set_link(&mut self, has_link: bool) {
        self.has_link = has_link;
    }

    pub(crate) const fn index(&self) -> i32 {
        self.index
    }
}

/// An interface of any kind.
struct Found {
    name: String,
    ethernet: Option<Interface>,
}

/// Asked by rtnetlink, which knows the interfaces of this network namespace; `/sys` may show those of another.
fn all() -> Vec<Found> {
    let entries = getifaddrs().into_iter().flatten();
    entries
        .filter_map(|entry| {
            let address = entry.address.as_ref().and_then(SockaddrStorage::as_link_addr)?;
            let mac = address.addr().filter(|_| address.hatype() == libc::ARPHRD_ETHER);
            let ethernet = mac.zip(i32::try_from(address.ifindex()).ok()).map(|(mac, index)| Interface {
                name: entry.interface_name.clone(),
                index,
                mac: MacAddress(mac),
                has_link: entry.flags.contains(InterfaceFlags::IFF_UP | InterfaceFlags::IFF_RUNNING),
            });
            Some(Found { name: entry.interface_name, ethernet })
        })
        .collect()
}

fn names(all: &[Found]) -> Vec<String> {
    let mut names: Vec<String> =
        all.iter().filter(|found| found.ethernet.is_some()).map(|found| found.name.clone()).collect();
    names.sort();
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_ethernet_interface_is_told_apart() {
        assert!(matches!(Interface::find("lo"), Err(Error::NotEthernet { .. })));
        assert!(matches!(Interface::find("no-such-one"), Err(Error::NoInterface { .. })));
    }
}
