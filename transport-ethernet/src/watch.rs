//! Word of interfaces that go up and down, are unplugged and come back: rtnetlink.

use std::os::fd::{AsFd, AsRawFd as _, BorrowedFd, OwnedFd};

use nix::errno::Errno;
use nix::sys::socket::{
    AddressFamily, MsgFlags, NetlinkAddr, SockFlag, SockProtocol, SockType, bind, recv, socket,
};

use crate::socket::retried;

#[derive(Debug)]
pub(crate) struct Watch {
    inner: OwnedFd,
}

impl Watch {
    pub(crate) fn start() -> Result<Self, Errno> {
        let flags = SockFlag::SOCK_CLOEXEC;
        let inner = socket(AddressFamily::Netlink, SockType::Raw, flags, SockProtocol::NetlinkRoute)?;
        bind(inner.as_raw_fd(), &NetlinkAddr::new(0, RTMGRP_LINK))?;
        Ok(Self { inner })
    }

    /// Takes all news, and tells whether there were any of this interface. Which, the interface itself tells.
    pub(crate) fn has_news_of(&self, index: Option<i32>) -> Result<bool, Errno> {
        let mut has_news = false;
        let mut message = [0; ROOM];
        loop {
            match retried(|| recv(self.inner.as_raw_fd(), &mut message, MsgFlags::MSG_DONTWAIT)) {
                Ok(len) => {
                    let of = message.get(..len).and_then(subject);
                    has_news |= index.is_none() || of.is_none() || of == index;
                }
                // So many that some were lost: any of them may have been of this interface.
                Err(Errno::ENOBUFS) => has_news = true,
                Err(Errno::EAGAIN) => return Ok(has_news),
                Err(error) => return Err(error),
            }
        }
    }
}

impl AsFd for Watch {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.inner.as_fd()
    }
}

/// The interface that a message is of: `ifi_index`, behind the 16 bytes of `nlmsghdr` and 4 of `ifinfomsg` (rtnetlink(7)).
fn subject(message: &[u8]) -> Option<i32> {
    message.get(20..24)?.try_into().ok().map(i32::from_ne_bytes)
}

/// linux/rtnetlink.h
const RTMGRP_LINK: u32 = 1;
/// The beginning of a message is enough.
const ROOM: usize = 64;
