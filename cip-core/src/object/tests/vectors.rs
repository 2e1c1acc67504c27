//! Requests and responses as manuals print them and captures have them, without the header byte that belongs to the
//! network. A failure here means that the code is wrong.

use super::{answer, ask};
use crate::code::{AttributeId, ClassId, DeviceType, GeneralStatus, InstanceId, ServiceCode, VendorId};
use crate::codec::Writer;
use crate::identity::{DeviceIdentity, ProductName, Revision};
use crate::message::BodyFormat;
use crate::object::{AttributeRule, Call, Effects, Failure, FailureOptions, Identity, Object, Size, exact};

fn device(vendor: u16, device_type: u16, product_code: u16, name: &str) -> DeviceIdentity {
    DeviceIdentity {
        vendor: VendorId(vendor),
        device_type: DeviceType(device_type),
        product_code,
        revision: Revision { major: 1, minor: 1 },
        serial: 0x1234_5678,
        name: ProductName::new(name).unwrap(),
    }
}

/// Konvolucio.DeviceNet unit-test logs of an Omron GRT1-DRT, 2016.
#[test]
fn omron_grt1_drt() {
    let device = device(47, 12, 0x056C, "GRT1-DRT");
    let mut set = (Identity::new(&device),);
    assert_eq!(ask(&mut set, &[0x0E, 0x01, 0x01, 0x03]), [0x8E, 0x6C, 0x05]); // product code 1388
    // Product name: 00 0E 01 01 07, answered in fragments, the last of which is 80 81 2D 44 52 54.
    let name = ask(&mut set, &[0x0E, 0x01, 0x01, 0x07]);
    assert_eq!(name, *b"\x8E\x08GRT1-DRT");
    assert!(name.ends_with(&[0x2D, 0x44, 0x52, 0x54]));
    assert_eq!(ask(&mut set, &[0x05, 0x01, 0x01]), [0x85]); // Reset
}

/// Jasic NBM-500R protocol V100.
#[test]
fn jasic_nbm_500r() {
    let device = device(0x006C, 0, 0x1482, "");
    let mut set = (Identity::new(&device),);
    assert_eq!(ask(&mut set, &[0x0E, 0x01, 0x01, 0x01]), [0x8E, 0x6C, 0x00]); // vendor ID 108
    assert_eq!(ask(&mut set, &[0x0E, 0x01, 0x01, 0x03]), [0x8E, 0x82, 0x14]); // product code
}

/// An IAI controller, addressed with 16 bits each.
#[test]
fn iai_controller() {
    let device = device(0, 0, 1, "");
    let get = |attribute| {
        let body = [0x0E, 0x01, 0x00, 0x01, 0x00, attribute];
        answer(
            &mut (Identity::new(&device),),
            BodyFormat::Class16Instance16,
            FailureOptions::default(),
            &body,
        )
        .0
    };
    assert_eq!(get(0x02), [0x8E, 0x00, 0x00]); // device type 0, generic
    assert_eq!(get(0x03), [0x8E, 0x01, 0x00]);
}

/// The vendor class of the ICP DAS I-7242D: User Manual v1.1, page 101, sets three bytes.
struct IcpDas([u8; 3]);

impl Object for IcpDas {
    const CLASS: ClassId = ClassId(0x65);

    fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
        (instance.0 == 1).then_some(const { &[AttributeRule::get_set(1, 0).sized(Size::Any)] })
    }

    fn get(&self, _: InstanceId, _: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        Ok(out.bytes(&self.0)?)
    }

    fn set(
        &mut self,
        _: InstanceId,
        _: AttributeId,
        value: &[u8],
        _: &mut Writer<'_>,
    ) -> Result<Effects, Failure> {
        self.0 = exact(value)?;
        Ok(Effects::NONE)
    }
}

/// A class with a vendor service, as Rockwell 1760-UM003A, pages 4-11 and 4-12, shows it.
struct Pico;

impl Object for Pico {
    const CLASS: ClassId = ClassId(0x64);

    fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
        (instance.0 == 1).then_some(&[])
    }

    fn get(&self, _: InstanceId, _: AttributeId, _: &mut Writer<'_>) -> Result<(), Failure> {
        Err(GeneralStatus::ATTRIBUTE_NOT_SUPPORTED.into())
    }

    fn service(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Result<Effects, Failure> {
        match (call.service, call.data) {
            (ServiceCode(0x32), [0x93, 0x05, 0x00]) => Ok(out.bytes(&[0xC2, 0x05, 0x00, 0x05, 0x09])?),
            _ => Err(Failure::new(GeneralStatus::SERVICE_NOT_SUPPORTED)),
        }?;
        Ok(Effects::NONE)
    }
}

#[test]
fn classes_of_vendors() {
    let mut set = (IcpDas([0; 3]), Pico);
    assert_eq!(ask(&mut set, &[0x10, 0x65, 0x01, 0x01, 0x01, 0x46, 0x00]), [0x90]);
    assert_eq!(set.0.0, [0x01, 0x46, 0x00]);
    let answer = ask(&mut set, &[0x32, 0x64, 0x01, 0x93, 0x05, 0x00]);
    assert_eq!(answer, [0xB2, 0xC2, 0x05, 0x00, 0x05, 0x09]);
}
