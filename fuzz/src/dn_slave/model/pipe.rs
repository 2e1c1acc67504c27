//! One explicit connection as requests in and responses out, with two timers.

use core::time::Duration;

use link_core::Instant;

use crate::fragment::reference::{Explicit, ExplicitReceiver, explicit_pieces};

/// What a request is answered with.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(in crate::dn_slave) enum Reply {
    /// These bytes, from the service byte on.
    Exact(Vec<u8>),
    /// Success or an error of this service, in one frame; the objects have tests of their own.
    Short(u8),
    /// Nothing.
    Ignored,
    /// The model does not know the service.
    Unknown,
}

/// What a frame on the connection was.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum Incoming {
    /// A request, complete: to be served, and answered with [`Pipe::reply`].
    Request(Vec<u8>),
    /// Nothing more is to be done.
    Done,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Stage {
    Idle,
    Due,
    /// To be sent for the second time.
    Again,
    Handed,
    Waiting,
}

/// A frame that is handed out.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Piece {
    Acknowledge,
    Response,
}

#[derive(Clone, Debug)]
pub(in crate::dn_slave) struct Pipe {
    receiver: ExplicitReceiver,
    reply: Reply,
    /// Pieces of the response that are not acknowledged yet.
    pieces: Vec<(u8, Vec<u8>)>,
    /// The first of them is being sent for the second time.
    again: bool,
    header: u8,
    stage: Stage,
    acknowledge: Option<[u8; 3]>,
    acknowledge_timer: Option<Instant>,
    receive_timer: Option<Instant>,
}

impl Pipe {
    pub(super) fn new() -> Self {
        Self {
            receiver: ExplicitReceiver::new(LONGEST),
            reply: Reply::Ignored,
            pieces: Vec::new(),
            again: false,
            header: 0,
            stage: Stage::Idle,
            acknowledge: None,
            acknowledge_timer: None,
            receive_timer: None,
        }
    }

    /// Takes a frame of `peer`.
    pub(super) fn receive(&mut self, now: Instant, peer: u8, reacknowledge: bool, field: &[u8]) -> Incoming {
        let (header, body) = (field[0], &field[1..]);
        let xid = header & 0x40 != 0;
        if header & 0x80 == 0 {
            self.abort();
            self.forget();
            self.header = header & 0x40 | peer;
            return Incoming::Request(body.to_vec());
        }
        let Some((&byte, data)) = body.split_first() else { return Incoming::Done };
        if byte >> 6 == 3 {
            if let Some(&status) = data.first() {
                self.acknowledged(byte & 0x3F, status);
            }
            return Incoming::Done;
        }
        if byte >> 6 == 0 {
            self.abort();
        }
        let verdict = self.receiver.fragment(xid, byte, data);
        if let Explicit::Acknowledge(status, _) = verdict {
            self.acknowledge = Some([0x80 | header & 0x40 | peer, 0xC0 | byte & 0x3F, status]);
        }
        match verdict {
            Explicit::Acknowledge(_, Some(request)) => {
                self.acknowledge_timer = None;
                self.receive_timer = reacknowledge.then(|| now + ACKNOWLEDGE);
                if !reacknowledge {
                    self.receiver.discard();
                }
                self.header = header & 0x40 | peer;
                return Incoming::Request(request);
            }
            Explicit::Acknowledge(0, None) if self.receiver.is_receiving() => {
                self.receive_timer = Some(now + RECEIVE);
            }
            _ if !self.receiver.remembers_completed() => self.receive_timer = None,
            _ => {}
        }
        Incoming::Done
    }

    /// The request was served.
    pub(super) fn reply(&mut self, reply: Reply) {
        if reply == Reply::Ignored {
            return;
        }
        self.pieces = match &reply {
            Reply::Exact(body) => explicit_pieces(body),
            _ => Vec::new(),
        };
        (self.reply, self.again, self.stage) = (reply, false, Stage::Due);
    }

    pub(super) fn is_quiet(&self) -> bool {
        self.stage == Stage::Idle
    }

    /// The count of the fragment that waits for its acknowledge.
    pub(in crate::dn_slave) fn waiting(&self) -> Option<u8> {
        self.pieces.first().map(|(byte, _)| byte & 0x3F)
    }

    pub(super) fn is_due(&self) -> bool {
        self.acknowledge.is_some() || matches!(self.stage, Stage::Due | Stage::Again)
    }

    pub(super) fn must_acknowledge(&self) -> bool {
        self.acknowledge.is_some()
    }

    /// Judges the frame that is handed out.
    pub(super) fn hand_out(&mut self, field: &[u8]) -> Piece {
        if let Some(expected) = self.acknowledge.take() {
            assert_eq!(field, expected, "the acknowledge of a fragment");
            return Piece::Acknowledge;
        }
        assert!(self.is_due(), "{field:02X?}: nothing is to be sent");
        self.stage = Stage::Handed;
        if let Some((byte, data)) = self.pieces.first() {
            assert_eq!(
                field,
                [&[0x80 | self.header, *byte][..], data].concat(),
                "a fragment of the response"
            );
            return Piece::Response;
        }
        match &self.reply {
            Reply::Exact(body) => assert_eq!(field, [&[self.header][..], body].concat()),
            Reply::Short(service) => {
                assert_eq!(field[0], self.header);
                assert!(field[1] == 0x94 && field.len() == 4 || field[1] == 0x80 | service, "{field:02X?}");
            }
            Reply::Ignored | Reply::Unknown => panic!("{field:02X?}: a response to nothing"),
        }
        Piece::Response
    }

    pub(super) fn handed(&mut self, now: Instant, piece: Piece) {
        if piece != Piece::Response || self.stage != Stage::Handed {
            return;
        }
        if self.pieces.is_empty() {
            self.stage = Stage::Idle;
        } else {
            (self.stage, self.acknowledge_timer) = (Stage::Waiting, Some(now + ACKNOWLEDGE));
        }
    }

    pub(super) fn expire(&mut self, until: Instant) {
        if self.receive_timer.is_some_and(|at| at <= until) {
            self.receive_timer = None;
            self.receiver.discard();
        }
        if self.acknowledge_timer.is_some_and(|at| at <= until) {
            self.acknowledge_timer = None;
            if self.again {
                self.abort();
            } else {
                (self.again, self.stage) = (true, Stage::Again);
            }
        }
    }

    /// The end of the connection: the response in one frame that told so still goes out, and the acknowledge before it.
    pub(super) fn close(&mut self) {
        self.forget();
        if !self.pieces.is_empty() {
            self.abort();
        }
    }

    pub(super) fn clear(&mut self) {
        self.close();
        self.acknowledge = None;
        self.abort();
    }

    fn acknowledged(&mut self, count: u8, status: u8) {
        if self.stage == Stage::Due || self.waiting() != Some(count) {
            return;
        }
        self.acknowledge_timer = None;
        self.pieces.remove(0);
        if status != 0 {
            self.pieces.clear();
        }
        self.again = false;
        self.stage = if self.pieces.is_empty() { Stage::Idle } else { Stage::Due };
    }

    fn abort(&mut self) {
        self.pieces.clear();
        (self.acknowledge_timer, self.stage) = (None, Stage::Idle);
    }

    fn forget(&mut self) {
        self.receiver.discard();
        self.receive_timer = None;
    }
}

/// The longest explicit message of the slave under test.
pub(in crate::dn_slave) const LONGEST: usize = 24;
const ACKNOWLEDGE: Duration = Duration::from_secs(1);
const RECEIVE: Duration = Duration::from_secs(3);
