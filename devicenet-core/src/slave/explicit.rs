//! The explicit connection of the predefined set: requests on 0x404 + 8s, responses on 0x403 + 8s.

use cip_core::connection::{ExplicitCause, ExplicitState};
use cip_core::message::BodyFormat;

use super::allocation::{Door, Requester};
use super::application::{Application, Parts};
use super::event::Ignored;
use super::machine::Slave;
use crate::id::{Identifier, MacId};

impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize> Slave<A, MESSAGE, DYNAMIC> {
    #[inline]
    pub(super) fn explicit_frame(&mut self, id: Identifier, field: &[u8]) {
        if A::PARTS.contains(Parts::FAST_WAYS) {
            self.explicit_frame_fast(id, field);
        } else {
            self.any_explicit_frame(id, field);
        }
    }

    #[inline(never)]
    fn explicit_frame_fast(&mut self, id: Identifier, field: &[u8]) {
        if !self.fast_get(field) {
            self.any_explicit_frame(id, field);
        }
    }

    #[inline(never)]
    fn any_explicit_frame(&mut self, id: Identifier, field: &[u8]) {
        if let Err(why) = self.explicit_message(field) {
            self.node.ignored(id, why);
        }
    }

    fn explicit_message(&mut self, field: &[u8]) -> Result<(), Ignored> {
        if self.node.explicit.state() == ExplicitState::NonExistent {
            return Err(Ignored::NoConnection);
        }
        let &header = field.first().ok_or(Ignored::TooShort)?;
        let mac = MacId::from_low_bits(header);
        if Some(mac) != self.node.master {
            return Err(Ignored::ForeignNode);
        }
        self.check_departure()?;
        // It exists: nothing is refused.
        let _ = self.node.explicit_step(ExplicitCause::Message);
        let rules = self.rules();
        if !self.explicit.receive(&mut self.node.timers, rules, header, field)? {
            return Ok(());
        }
        let (mut server, explicit, _) =
            self.serving(Requester { mac, door: Door::Predefined, format: BodyFormat::Class8Instance8 });
        explicit.answer(header, field, |request, out| server.answer(request, out))
    }
}
