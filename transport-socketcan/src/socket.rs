//! A raw CAN socket with the options that a port needs.

use std::io;
use std::os::fd::{AsFd, BorrowedFd};

use core::time::Duration;
use link_core::{Filter, FilterSet, Frame};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use rustix::net::{SendFlags, send};
use socketcan::id::ERR_MASK_ALL;
use socketcan::{CanFilter, CanSocket, Socket as _, SocketOptions as _};

use crate::frame;
use crate::receive::{self, Message, Patience};

#[derive(Debug)]
pub(crate) struct Socket {
    inner: CanSocket,
}

impl Socket {
    /// Opens a socket on an interface, up or down; with the echoes of the frames that it sends.
    pub(crate) fn open(index: u32, with_echoes: bool) -> Result<Self, (&'static str, io::Error)> {
        let inner = CanSocket::open_iface(index).map_err(|error| ("cannot open a CAN socket", error))?;
        let socket = Self { inner };
        socket.set_options(with_echoes).map_err(|error| ("cannot set the options of the socket", error))?;
        Ok(socket)
    }

    fn set_options(&self, with_echoes: bool) -> io::Result<()> {
        let (socket, level) = (&self.inner, libc::SOL_SOCKET);
        socket.set_read_timeout(SHORT)?;
        socket.set_recv_own_msgs(with_echoes)?;
        socket.set_error_filter(ERR_MASK_ALL)?;
        socket.set_socket_option_int(level, libc::SO_TIMESTAMPNS, 1)?;
        socket.set_socket_option_int(level, libc::SO_RXQ_OVFL, 1)?;
        // The default holds 278 frames, which is 33 ms of a full bus at 1 Mbit/s. Beyond the limit of the system only the
        // administrator may go; what others get is still more than the default.
        if socket.set_socket_option_int(level, libc::SO_RCVBUFFORCE, RECEIVE_BUFFER).is_err() {
            let _ = socket.set_socket_option_int(level, libc::SO_RCVBUF, RECEIVE_BUFFER);
        }
        Ok(())
    }

    pub(crate) fn set_filters(&self, filters: &FilterSet, sent: &[Filter]) -> io::Result<()> {
        let filters: Vec<CanFilter> = filters.as_slice().iter().chain(sent).map(kernel_filter).collect();
        if filters.is_empty() { self.inner.set_filter_drop_all() } else { self.inner.set_filters(&filters) }
    }

    /// `Ok(false)`: the transmit queue is full, or has as much of this socket as it may have. Never waits for room.
    pub(crate) fn send(&self, frame: &Frame) -> io::Result<bool> {
        let Some(frame) = frame::to_kernel(frame) else {
            return Err(io::ErrorKind::InvalidInput.into());
        };
        match send(&self.inner, &frame::bytes(&frame), SendFlags::DONTWAIT) {
            Ok(_) => Ok(true),
            Err(Errno::NOBUFS | Errno::AGAIN | Errno::INTR) => Ok(false),
            Err(error) => Err(error.into()),
        }
    }

    pub(crate) fn receive(&self, patience: Patience, messages: &mut Vec<Message>) -> io::Result<()> {
        loop {
            match receive::receive(self.inner.as_fd(), patience, messages) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                result => return result,
            }
        }
    }
}

/// Waits until something is received, at most so long.
pub(crate) fn wait(socket: Option<&Socket>, span: Option<Duration>) -> io::Result<()> {
    // A span that the kernel cannot express is longer than anybody waits.
    let timeout = span.and_then(|span| Timespec::try_from(span).ok());
    let mut sockets: Vec<PollFd<'_>> =
        socket.into_iter().map(|socket| PollFd::new(socket, PollFlags::IN)).collect();
    match poll(&mut sockets, timeout.as_ref()) {
        // After a signal the caller looks at the clock again.
        Ok(_) | Err(Errno::INTR) => Ok(()),
        Err(error) => Err(error.into()),
    }
}

impl AsFd for Socket {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.inner.as_fd()
    }
}

/// The kernel compares the extended flag too. Remote frames pass as data frames do, because their flag is not in the mask.
fn kernel_filter(filter: &Filter) -> CanFilter {
    let format = if filter.is_extended() { libc::CAN_EFF_FLAG } else { 0 };
    CanFilter::new(filter.value() | format, filter.mask() | libc::CAN_EFF_FLAG)
}

/// How long [`Patience::Short`] lasts.
const SHORT: Duration = Duration::from_millis(10);
/// The kernel counts it in ticks, of which there are 100 a second at least.
pub(crate) const LONGEST_SHORT_WAIT: Duration = Duration::from_millis(20);
/// In bytes, of which a frame takes some 760 with the kernel's bookkeeping: 2700 frames.
const RECEIVE_BUFFER: i32 = 1 << 20;
