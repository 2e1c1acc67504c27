//! What the monitor makes of a frame.

use cip_core::code::VendorId;
use cip_core::message::AllocationChoice;
use cip_core::monitor::{Answered, ConnectionState, Explicit, Frag, Remark, Remarks};
use link_core::{Frame, Instant};

use super::connections::DynamicConnection;
use super::kind::Kind;
use super::problem::Problem;
use crate::id::{Identifier, MacId};

/// A frame, read.
///
/// `Display` is the one line that a trace shows; [`words`](Self::words) is the same without the problem. With feature
/// `serde` it serialises to one flat object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading<'a> {
    /// When the frame was on the bus.
    pub at: Instant,
    /// Its number in the recording.
    pub n: u64,
    /// The frame.
    pub frame: Frame,
    /// The message group, 1-4; `None` outside of them.
    pub group: Option<u8>,
    /// The Message ID inside the group.
    pub msg: Option<u8>,
    /// Who has sent it, where the identifier, the header or the learned state tells.
    pub src: Option<MacId>,
    /// Who shall receive it; `None` also for a broadcast.
    pub dst: Option<MacId>,
    /// The connection that it is on, of those that UCMM has opened or Create has made. One of the predefined set is told by
    /// the identifier.
    pub dynamic: Option<DynamicConnection>,
    /// What it is.
    pub kind: Kind,
    /// What it says.
    pub fields: Fields<'a>,
    /// The fragmentation byte, in a fragment or its acknowledge.
    pub frag: Option<Frag>,
    /// The whole message, in the frame that completes a fragmented one.
    pub message: Option<Message<'a>>,
    /// The frame that it answers: the request of a response, the fragment of an acknowledge, the command of an I/O
    /// response.
    pub request: Option<Answered>,
    /// Why it is wrong or suspicious.
    pub problem: Option<Problem>,
    /// What else a reader should know, without anything being wrong.
    pub note: Option<Note>,
    /// It could not be known for certain without frames that the recording does not contain.
    pub assumed: bool,
}

/// What a complete message says. A field that the message does not have, and that the request it answers does not
/// give either, is `None`. The data of I/O stand where an explicit message has its value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Fields<'a> {
    /// What it says as an explicit message.
    pub explicit: Explicit<'a>,
    /// Allocation or release choice; in a response that of the request.
    pub choice: Option<AllocationChoice>,
    /// Vendor of a duplicate MAC ID or offline message.
    pub vendor: Option<VendorId>,
    /// Serial number of a duplicate MAC ID or offline message.
    pub serial: Option<u32>,
    /// Physical port of a duplicate MAC ID check or Who response.
    pub port: Option<u8>,
    /// The service is one of UCMM.
    pub(super) is_ucmm: bool,
    /// What only some messages have.
    pub detail: Detail,
}

/// What only some messages have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Detail {
    /// Nothing.
    #[default]
    None,
    /// Allocate request.
    Allocate {
        /// The master.
        allocator: u8,
    },
    /// Response to Allocate.
    Allocated {
        /// Code of the body format.
        format: u8,
    },
    /// UCMM Open request.
    Open {
        /// Code of the body format asked for.
        format: u8,
        /// Group Select.
        group: u8,
        /// The Message ID that the client will use.
        source: u8,
    },
    /// Response to UCMM Open.
    Opened {
        /// Code of the body format.
        format: u8,
        /// The Message ID that the client must use in Group 2.
        destination: u8,
        /// The Message ID that the server will use.
        source: u8,
    },
    /// UCMM Close request or its response.
    Close,
    /// Device Heartbeat.
    Heartbeat {
        /// State of the Identity object.
        state: u8,
        /// Fault flags: bit 3 event, bit 2 system, bit 1 user, bit 0 device fault.
        flags: u8,
        /// Configuration consistency value.
        consistency: u16,
    },
    /// Device Shutdown.
    Shutdown {
        /// The shutdown code.
        code: u16,
    },
    /// Who request.
    Who {
        /// Bit 6 Match, bits 5-0 Value.
        nodes: u8,
        /// The byte of the response that sets the delay.
        delay_offset: u8,
    },
    /// Who response.
    WhoAnswer,
    /// Identify request or response.
    Identify {
        /// Bit 6 Match, bits 5-0 Value.
        nodes: u8,
    },
    /// Change_MAC_ID request.
    ChangeMacId {
        /// The MAC ID that the device shall use.
        mac: MacId,
    },
    /// Offline Ownership request or response.
    Ownership {
        /// The tool.
        client: MacId,
    },
}

/// A message put together from its fragments.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Message<'a> {
    /// The kind that the message would have in one frame.
    pub kind: Kind,
    /// What it says.
    pub fields: Fields<'a>,
    /// The whole of it: an explicit message from the service byte on, or the I/O data.
    pub data: &'a [u8],
}

/// Something to know about a frame that is not wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Note {
    /// It is on a connection that is not established by what was seen before. A receiver ignores it; a slave that answers
    /// all the same shows that something was missed.
    NoConnection(ConnectionState),
    /// A message that this frame is part of does not fit into the monitor.
    NotStored,
    /// A node that was on line checks its MAC ID again: it has restarted.
    Restarted,
    /// The MAC ID of a node on line whose identity is not known is checked: it has restarted, or another device wants it.
    RestartedOrAnother,
    /// A fragment that was sent before, or an acknowledge that was.
    Repeated,
}

impl Fields<'_> {
    /// Of a message that is all data.
    pub(super) fn of_data(data: &[u8]) -> Self {
        Self { explicit: Explicit::of_data(data), ..Self::default() }
    }
}

impl<'a> Reading<'a> {
    pub(super) fn new(at: Instant, n: u64, frame: &Frame, identifier: Option<Identifier>) -> Self {
        let group = identifier.and_then(|id| id.group().number());
        Self {
            at,
            n,
            frame: *frame,
            group,
            msg: identifier.filter(|_| group.is_some()).map(Identifier::message_id),
            src: None,
            dst: None,
            dynamic: None,
            kind: Kind::Foreign,
            fields: Fields::default(),
            frag: None,
            message: None,
            request: None,
            problem: None,
            note: None,
            assumed: false,
        }
    }

    /// The attribute value, service data or I/O data of the frame; `None` if it carries none. Of a fragmented message
    /// ask [`Message::value`].
    #[must_use]
    pub fn value(&self) -> Option<&[u8]> {
        self.fields.explicit.value.map(|span| span.of(self.frame.data()))
    }

    /// Keeps the first problem found.
    pub(super) fn flag(&mut self, problem: impl Into<Problem>) {
        self.problem.get_or_insert(problem.into());
    }

    pub(super) fn flag_if(&mut self, problem: Option<impl Into<Problem>>) {
        if let Some(problem) = problem {
            self.flag(problem);
        }
    }
}

impl Remarks for Reading<'_> {
    fn remark(&mut self, remark: Remark) {
        match remark {
            Remark::Flaw(flaw) => self.flag(flaw),
            Remark::NoConnection(state) => self.note = Some(Note::NoConnection(state)),
            Remark::NotStored => self.note = Some(Note::NotStored),
            Remark::Repeated => self.note = Some(Note::Repeated),
            Remark::Assumed => self.assumed = true,
            Remark::Answers(request) => self.request = Some(request),
        }
    }
}

impl<'a> Message<'a> {
    /// The attribute value, service data or I/O data; `None` if it carries none.
    #[must_use]
    pub fn value(&self) -> Option<&'a [u8]> {
        self.fields.explicit.value.map(|span| span.of(self.data))
    }
}
