//! Messages from a CAN socket, with what only `recvmmsg` tells: whether a frame is the echo of an own one, when it came, and
//! how many were lost.

use core::time::Duration;
use std::io;
use std::os::fd::{AsRawFd, BorrowedFd};

use libc::can_frame;
use socketcan::frame::can_frame_default;

/// A frame as the kernel hands it over.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Message {
    pub(crate) raw: can_frame,
    /// It is the echo of a frame that this socket sent.
    pub(crate) is_own: bool,
    /// Since 1970.
    pub(crate) stamp: Option<Duration>,
    /// How many frames the socket has lost since it was opened, modulo 2^32.
    pub(crate) lost: Option<u32>,
}

/// What one call takes at most.
pub(crate) const BATCH: usize = 16;

/// The length of a classic CAN frame. A CAN FD frame is longer, and not for us.
const FRAME_LEN: u32 = 16;

/// Room for the control messages of a frame: a time and a count, each aligned and with its header. 64 bytes are used on
/// 64-bit machines.
#[repr(C, align(8))]
#[derive(Clone, Copy)]
struct Control([u8; CONTROL_LEN]);
const CONTROL_LEN: usize = 128;

/// Whether to wait for a first message.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Patience {
    /// Take what is there.
    None,
    /// At most as long as the socket's `SO_RCVTIMEO` says.
    Short,
}

/// Takes what has been received. Nothing new in the list: nothing there.
///
/// # Errors
/// What the kernel says: `ENETDOWN` when the interface went down, `ENODEV` when it is gone.
#[allow(
    unsafe_code,
    clippy::as_conversions,
    clippy::indexing_slicing,
    reason = "no safe interface hands out MSG_CONFIRM and SO_RXQ_OVFL; the lengths are those of the buffers beside them"
)]
pub(crate) fn receive(
    socket: BorrowedFd<'_>,
    patience: Patience,
    messages: &mut Vec<Message>,
) -> io::Result<()> {
    let flags = match patience {
        Patience::None => libc::MSG_DONTWAIT,
        Patience::Short => libc::MSG_WAITFORONE,
    };
    let mut frames = [can_frame_default(); BATCH];
    let mut controls = [Control([0; CONTROL_LEN]); BATCH];
    // SAFETY: all-zero is a valid value of these plain C structures; every pointer put into them is to an element of a local
    // array that lives, unmoved, until the end of the block, with its length beside it. The kernel writes at most those
    // lengths, and `msg_controllen` of what it returns bounds the walk over the control messages. A control message is read
    // only when its own length covers the type that its level and type name, and unaligned. A `can_frame` is plain data, in
    // which every bit pattern is valid.
    // The C libraries differ in the types of lengths and flags.
    unsafe {
        let mut parts: [libc::iovec; BATCH] = core::mem::zeroed();
        let mut headers: [libc::mmsghdr; BATCH] = core::mem::zeroed();
        for index in 0..BATCH {
            parts[index].iov_base = (&raw mut frames[index]).cast();
            parts[index].iov_len = size_of::<can_frame>();
            headers[index].msg_hdr.msg_iov = &raw mut parts[index];
            headers[index].msg_hdr.msg_iovlen = 1;
            headers[index].msg_hdr.msg_control = controls[index].0.as_mut_ptr().cast();
            headers[index].msg_hdr.msg_controllen = CONTROL_LEN as _;
        }
        let count = libc::recvmmsg(
            socket.as_raw_fd(),
            headers.as_mut_ptr(),
            BATCH as libc::c_uint,
            flags as _,
            core::ptr::null_mut(),
        );
        let Ok(count) = usize::try_from(count) else {
            let error = io::Error::last_os_error();
            return if error.kind() == io::ErrorKind::WouldBlock { Ok(()) } else { Err(error) };
        };
        for (header, raw) in headers.iter().zip(frames).take(count) {
            if header.msg_len != FRAME_LEN {
                continue;
            }
            let is_own = header.msg_hdr.msg_flags & libc::MSG_CONFIRM != 0;
            let mut message = Message { raw, is_own, stamp: None, lost: None };
            let mut control = libc::CMSG_FIRSTHDR(&raw const header.msg_hdr);
            while !control.is_null() {
                let (level, kind, len) = ((*control).cmsg_level, (*control).cmsg_type, (*control).cmsg_len);
                let holds = |size: usize| len >= libc::CMSG_LEN(size as libc::c_uint) as _;
                let data = libc::CMSG_DATA(control);
                match (level, kind) {
                    (libc::SOL_SOCKET, libc::SCM_TIMESTAMPNS) if holds(size_of::<libc::timespec>()) => {
                        let time = data.cast::<libc::timespec>().read_unaligned();
                        message.stamp = Some(socketcan::timestamp::timespec_to_duration(time));
                    }
                    (libc::SOL_SOCKET, libc::SO_RXQ_OVFL) if holds(size_of::<u32>()) => {
                        message.lost = Some(data.cast::<u32>().read_unaligned());
                    }
                    _ => {}
                }
                control = libc::CMSG_NXTHDR(&raw const header.msg_hdr, control);
            }
            messages.push(message);
        }
    }
    Ok(())
}
