//! What a device costs.

use super::bus::Station;
use crate::device::{Application, Device, Fragmented};
use crate::message::ConnectionInstance;
use cip_core::identity::DeviceIdentity;
use cip_core::object::Identity;
use core::mem::size_of;

/// A device without data.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
struct Bare<L>(DeviceIdentity, core::marker::PhantomData<L>);

fn bare() -> Bare<()> {
    Bare(super::bus::identity(), core::marker::PhantomData)
}

impl<L: crate::device::LongMessages> Application for Bare<L> {
    type Long = L;

    fn identity(&self) -> Identity<'_> {
        Identity::new(&self.0)
    }

    fn produced(&self, _: ConnectionInstance) -> &[u8] {
        &[]
    }

    fn consumed(&mut self, _: ConnectionInstance) -> &mut [u8] {
        &mut []
    }
}

#[test]
fn the_size_of_a_device_is_known() {
    let application = size_of::<Bare<()>>();
    let none = size_of::<Device<Bare<()>, 32, 0>>();
    let each = size_of::<Device<Bare<()>, 32, 1>>() - none;
    let long = size_of::<Device<Bare<Fragmented<64>>, 32, 1>>() - none;
    assert_eq!((none - application, each, long), (760, 160, 296));
}

#[test]
fn a_device_that_cannot_be() {
    use crate::device::{Config, InvalidDevice};
    let config =
        || Config::new(&super::bus::identity(), crate::message::PortByte::ZERO, crate::access::Role::Device);
    let short = Device::<Bare<()>, 7, 1>::new(config(), bare()).map(|_| ());
    assert_eq!(short, Err(InvalidDevice::MessageTooShort(7)));
    let many = Device::<Bare<()>, 8, 128>::new(config(), bare()).map(|_| ());
    assert_eq!(many, Err(InvalidDevice::TooManyConnections(128)));
    let station = Station { inputs: std::vec![0; 33], ..super::bus::station() };
    let long = Device::<Station, 8, 1>::new(config(), station).map(|_| ());
    assert_eq!(
        long.map_err(|error| std::string::ToString::to_string(&error)),
        Err("polled, 11 bits has 33 bytes, and there is room for 32: let Application::Long be Fragmented<33>, at most 448".into())
    );
}
