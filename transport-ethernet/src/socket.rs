//! A packet socket that is bound to one EtherType of one interface.

use core::time::Duration;
use std::io::{self, IoSliceMut};
use std::os::fd::{AsFd, AsRawFd as _, BorrowedFd, OwnedFd};

use link_core::ethernet::MacAddress;
use nix::errno::Errno;
use nix::sys::socket::{
    AddressFamily, ControlMessageOwned, MsgFlags, SockFlag, SockType, getsockopt, recvmsg, send, setsockopt,
    socket, sockopt,
};
use nix::sys::time::TimeSpec;

#[derive(Debug)]
pub(crate) struct Socket {
    inner: OwnedFd,
    /// Room for a time and a count.
    control: Vec<u8>,
}

/// What was received beside the bytes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Received {
    /// The length of the frame; more than the buffer has room for if it was cut.
    pub(crate) len: usize,
    /// Since 1970.
    pub(crate) stamp: Option<Duration>,
    /// How many frames the socket has lost since it was opened, modulo 2^32; absent while it has lost none.
    pub(crate) lost: Option<u32>,
}

/// What was tried, and what the kernel said.
type Failure = (&'static str, Errno);

impl Socket {
    /// Opens a socket on an interface, up or down.
    pub(crate) fn open(index: i32, ethertype: u16, groups: &[MacAddress]) -> Result<Self, Failure> {
        let flags = SockFlag::SOCK_CLOEXEC;
        // Without a protocol: it receives nothing before it is bound, and so nothing of other interfaces.
        let inner = socket(AddressFamily::Packet, SockType::Raw, flags, None)
            .map_err(|error| ("cannot open a packet socket", error))?;
        set_options(&inner).map_err(|error| ("cannot set the options of the socket", error))?;
        attach(inner.as_fd(), index, ethertype, groups)?;
        Ok(Self { inner, control: nix::cmsg_space!(TimeSpec, u32) })
    }

    /// Never waits for room.
    pub(crate) fn send(&self, frame: &[u8]) -> Result<(), Errno> {
        retried(|| send(self.inner.as_raw_fd(), frame, MsgFlags::MSG_DONTWAIT)).map(|_| ())
    }

    /// Takes a frame, if one is there.
    pub(crate) fn receive(&mut self, buffer: &mut [u8]) -> Result<Option<Received>, Errno> {
        let flags = MsgFlags::MSG_DONTWAIT | MsgFlags::MSG_TRUNC;
        let (socket, control) = (self.inner.as_raw_fd(), &mut self.control);
        let received = retried(|| {
            let mut parts = [IoSliceMut::new(buffer)];
            let message = recvmsg::<()>(socket, &mut parts, Some(control), flags)?;
            let mut received = Received { len: message.bytes, stamp: None, lost: None };
            for part in message.cmsgs()? {
                match part {
                    ControlMessageOwned::ScmTimestampns(time) => received.stamp = Some(Duration::from(time)),
                    ControlMessageOwned::RxqOvfl(count) => received.lost = Some(count),
                    _ => {}
                }
            }
            Ok(received)
        });
        match received {
            Ok(received) => Ok(Some(received)),
            Err(Errno::EAGAIN) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Whether the interface has gone since this was asked, or since a call has failed for it.
    pub(crate) fn has_broken(&self) -> bool {
        getsockopt(&self.inner, sockopt::SocketError).is_ok_and(|error| is_gone(Errno::from_raw(error)))
    }
}

impl AsFd for Socket {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.inner.as_fd()
    }
}

fn set_options(socket: &OwnedFd) -> Result<(), Errno> {
    setsockopt(socket, sockopt::ReceiveTimestampns, &true)?;
    setsockopt(socket, sockopt::RxqOvfl, &1)?;
    // Beyond the limit of the system only the administrator may go; what others get is still more than the default.
    if setsockopt(socket, sockopt::RcvBufForce, &RECEIVE_BUFFER).is_err() {
        let _ = setsockopt(socket, sockopt::RcvBuf, &RECEIVE_BUFFER);
    }
    Ok(())
}

/// Binds the socket, and joins the groups.
#[allow(unsafe_code, reason = "no safe interface has an address with an EtherType, or the memberships")]
fn attach(socket: BorrowedFd<'_>, index: i32, ethertype: u16, groups: &[MacAddress]) -> Result<(), Failure> {
    /// The length of a plain C structure.
    const fn len<T>() -> libc::socklen_t {
        #[allow(clippy::as_conversions, reason = "two structures of 20 and 16 bytes")]
        let len = size_of::<T>() as libc::socklen_t;
        len
    }
    let family = u16::try_from(libc::AF_PACKET).unwrap_or_default();
    // SAFETY: all-zero is a valid value of these plain C structures. Both calls get the address of a local one with its
    // size, read it before they return, and keep no pointer. The descriptor is borrowed, so it is open.
    unsafe {
        let mut address: libc::sockaddr_ll = core::mem::zeroed();
        address.sll_family = family;
        address.sll_protocol = ethertype.to_be();
        address.sll_ifindex = index;
        let bound = libc::bind(socket.as_raw_fd(), (&raw const address).cast(), len::<libc::sockaddr_ll>());
        Errno::result(bound).map_err(|error| ("cannot bind the socket", error))?;
        for group in groups {
            let mut membership: libc::packet_mreq = core::mem::zeroed();
            membership.mr_ifindex = index;
            membership.mr_type = u16::try_from(libc::PACKET_MR_MULTICAST).unwrap_or_default();
            membership.mr_alen = 6;
            let [a, b, c, d, e, f] = group.0;
            membership.mr_address = [a, b, c, d, e, f, 0, 0];
            let joined = libc::setsockopt(
                socket.as_raw_fd(),
                libc::SOL_PACKET,
                libc::PACKET_ADD_MEMBERSHIP,
                (&raw const membership).cast(),
                len::<libc::packet_mreq>(),
            );
            Errno::result(joined).map_err(|error| ("cannot join a group", error))?;
        }
    }
    Ok(())
}

/// After a signal, again.
pub(crate) fn retried<T>(mut call: impl FnMut() -> Result<T, Errno>) -> Result<T, Errno> {
    loop {
        match call() {
            Err(Errno::EINTR) => {}
            result => return result,
        }
    }
}

/// The interface is down or unplugged.
pub(crate) const fn is_gone(error: Errno) -> bool {
    matches!(error, Errno::ENETDOWN | Errno::ENODEV | Errno::ENXIO)
}

pub(crate) fn io_error(error: Errno) -> io::Error {
    error.into()
}

/// In bytes, of which a frame of 60 takes some 770 with the kernel's bookkeeping: 2700 frames instead of 280.
const RECEIVE_BUFFER: usize = 1 << 20;
