//! What is left to be done after a service of an object of the application.

use cip_core::code::{AttributeId, ClassId, InstanceId};
use cip_core::codec::Writer;
use cip_core::message::{AllocationChoice, ResetType};
use cip_core::object::{AttributeRule, Call, Effect, Effects, Failure, Identity, Object, ObjectSet};

use super::bus::{Block, Bus, block, config};
use crate::slave::{Application, IoKind, SlaveEvent};

/// An object of the application; all that its services do is their effects.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
struct Effective;

const EFFECT: Effect = Effect::from_bits_retain(0x0100);

impl Object for Effective {
    const CLASS: ClassId = ClassId(0x64);

    fn attributes(&self, _: InstanceId) -> Option<&'static [AttributeRule]> {
        Some(&[])
    }

    fn get(&self, _: InstanceId, _: AttributeId, _: &mut Writer<'_>) -> Result<(), Failure> {
        Ok(())
    }

    fn service(&mut self, call: &Call<'_>, _: &mut Writer<'_>) -> Result<Effects, Failure> {
        match call.service.0 {
            0x32 => Ok(EFFECT.into()),
            _ => Ok(Effects::reset(ResetType(0)).and(EFFECT)),
        }
    }
}

#[derive(Clone, PartialEq, Eq, Hash, Debug)]
struct WithObject(Block, Effective);

impl Application for WithObject {
    const IO: AllocationChoice = AllocationChoice::POLL;
    type Long = ();

    fn identity(&self) -> Identity<'_> {
        self.0.identity()
    }

    fn objects(&mut self) -> impl ObjectSet {
        (&mut self.1,)
    }

    fn produced(&self, connection: IoKind) -> &[u8] {
        self.0.produced(connection)
    }

    fn consumed(&mut self, connection: IoKind) -> &mut [u8] {
        self.0.consumed(connection)
    }
}

/// An effect is told; one together with a reset is not, for the reset is all that counts then.
#[test]
fn an_effect_is_told_and_a_reset_is_all_that_is_told() {
    let mut bus = Bus::<_, 0>::online(config(), WithObject(block(), Effective)).allocated(0x01);
    bus.asks(&[0x32, 0x64, 1], &[0xB2]);
    bus.tells(SlaveEvent::Effect(EFFECT));
    bus.events.clear();
    bus.asks(&[0x33, 0x64, 1], &[0xB3]);
    assert!(!bus.events.contains(&SlaveEvent::Effect(EFFECT)));
    bus.tells(SlaveEvent::Reset(ResetType(0)));
    assert!(!bus.slave.access().is_online());
}
