//! What the node sends, against what it was asked.

use powerlink_core::nmt::NmtState;
use powerlink_core::wire::{Body, Frame, Sdo};

use super::super::device::{MAC, NODE};
use super::super::heard::Heard;
use super::{Before, Model, Why};

impl Model {
    /// What was sent, against what was asked.
    pub(super) fn answers(
        &mut self,
        why: Why,
        state: NmtState,
        has_failed: bool,
        before: &Before,
        sent: &[Vec<u8>],
    ) {
        sent.iter().for_each(|bytes| own_frame(bytes));
        let heard = match why {
            Why::Heard(heard, _) => heard,
            _ => Heard::Nothing,
        };
        match heard {
            Heard::Preq { flags, .. } if state.answers_poll() => {
                self.signalling.acknowledge(flags & 0x04 != 0);
                match sent {
                    [pres] => self.pres(pres, flags, state, has_failed, before),
                    _ => assert!(has_failed && sent.is_empty(), "a poll in {state}: {sent:02X?}"),
                }
            }
            Heard::Soa { service, is_own: true, flags } if state.is_powerlink_mode() => {
                self.invited(service, flags, why, sent);
            }
            _ if state == NmtState::BasicEthernet => sent.iter().for_each(|bytes| self.sdo(bytes)),
            _ => assert!(sent.is_empty(), "sent in {state} after {why:?}: {sent:02X?}"),
        }
    }

    fn invited(&mut self, service: u8, flags: u8, why: Why, sent: &[Vec<u8>]) {
        assert!(sent.len() <= 1, "one frame for each invitation");
        let answer = sent.first();
        self.signalling.acknowledge(flags & 0x04 != 0);
        match service {
            0x01 => {
                let bytes = answer.expect("an IdentResponse");
                assert_eq!((bytes.len(), bytes[17]), (176, 0x01));
                self.waiting(bytes[19]);
            }
            0x02 => {
                let bytes = answer.expect("a StatusResponse");
                let reset = flags & 0x02 != 0;
                self.signalling.reset(reset, false);
                assert_eq!(bytes[17], 0x02);
                assert!(bytes.len() >= 72 && (bytes.len() - 32).is_multiple_of(20), "{} bytes", bytes.len());
                assert!(bytes.len() <= 32 + 20 * self.options.status_entries);
                self.signalling.saw_status(bytes[18] & 0x08 != 0, bytes[18] & 0x10 != 0, &bytes[32..]);
                self.signalling.reset(reset, true);
                self.waiting(bytes[19]);
            }
            0x03 => match (self.requests.pop_front(), answer) {
                (Some(command), Some(bytes)) => {
                    assert_eq!(bytes[15..20], [240, NODE.0, 0x03, command.0, NODE.0]);
                }
                (None, None) => {}
                (request, answer) => panic!("{answer:02X?} for {request:?}"),
            },
            0xFF => {
                answer.iter().for_each(|bytes| self.sdo(bytes));
                if let Why::Heard(_, Some(waiting)) = why
                    && self.requests.is_empty()
                {
                    assert_eq!(answer.is_some(), waiting & 0x07 > 0, "PR and RS were {waiting:02X}");
                }
            }
            _ => assert_eq!(answer, None),
        }
    }

    /// PR and RS.
    fn waiting(&self, byte: u8) {
        let (priority, count) = (byte >> 3 & 7, byte & 7);
        assert_eq!(byte & 0xC0, 0);
        if self.requests.is_empty() {
            assert!(byte == 0 || (priority == 3 && count > 0), "{byte:02X}");
        } else {
            assert_eq!((priority, usize::from(count)), (7, self.requests.len().min(7)));
        }
    }

    fn pres(&mut self, bytes: &[u8], asked: u8, state: NmtState, has_failed: bool, before: &Before) {
        assert_eq!(bytes[..6], [0x01, 0x11, 0x1E, 0, 0, 2]);
        assert_eq!(bytes[14..17], [0x04, 255, NODE.0]);
        assert!(has_failed || bytes[17] == state.code().0, "state {:02X} in {state}", bytes[17]);
        let limit = usize::from(self.active.pres_limit);
        assert_eq!(bytes.len(), 24 + limit, "of constant length");
        let size = usize::from(u16::from_le_bytes([bytes[22], bytes[23]]));
        let fits = before.mapped <= limit;
        assert_eq!(size, if fits { before.mapped } else { 0 });
        let are_valid = self.are_inputs_valid && self.are_inputs_readable;
        let is_valid = state == NmtState::Operational && are_valid && fits;
        assert!(has_failed || (bytes[18] & 0x01 != 0) == is_valid, "RD in {state}");
        let is_multiplexed = asked & 0x20 != 0 && self.active.multiplexed_cycles > 0;
        assert_eq!(bytes[18] & 0x20 != 0, is_multiplexed, "MS");
        assert_eq!(bytes[18] & !0x31, 0);
        self.signalling.saw_new(bytes[18] & 0x10 != 0);
        self.waiting(bytes[19]);
    }

    /// An SDO frame, to a client that asked.
    fn sdo(&self, bytes: &[u8]) {
        assert_eq!((bytes[14], bytes[17]), (0x06, 0x05), "only SDO: {bytes:02X?}");
        assert!(bytes.len() <= 14 + usize::from(self.active.async_mtu).max(46), "0x1F98/8");
        let mut reader = link_core::codec::Reader::new(&bytes[18..]);
        let sdo = Sdo::read_as(&mut reader, self.options.initiate_size).expect("its own frames are valid");
        if let Some(command) = sdo.command {
            assert!(command.is_response);
            assert!(self.transactions.contains(&(bytes[15], command.transaction)), "{command:?}");
            assert!(!command.is_abort || command.data.len() == 4);
        }
    }
}

/// What every frame of the node has.
fn own_frame(bytes: &[u8]) {
    assert!((60..=1514).contains(&bytes.len()), "{} bytes", bytes.len());
    assert_eq!((&bytes[6..12], &bytes[12..14]), (&MAC.0[..], &[0x88, 0xAB][..]));
    assert_eq!(bytes[16], NODE.0);
    let frame = Frame::parse(bytes).expect("its own frames are valid");
    assert!(!matches!(frame.body, Body::Other(..) | Body::OtherAsnd(..)), "{frame}");
}
