//! The Identity object (class 0x01).

use super::{AttributeRule, Call, Effect, Effects, Failure, Object, Size, exact};
use crate::code::{AttributeId, ClassId, GeneralStatus, InstanceId, ServiceCode};
use crate::codec::{Wire, Writer};
use crate::identity::{DeviceIdentity, DeviceState, IdentityStatus};
use crate::message::ResetType;

/// Instance 1 of the Identity object: what the device is, and how it is at the time of a request.
///
/// | Attribute | Value | Access |
/// |---|---|---|
/// | 1 | vendor, UINT | Get |
/// | 2 | device type, UINT | Get |
/// | 3 | product code, UINT | Get |
/// | 4 | revision, two USINT | Get |
/// | 5 | status, WORD | Get |
/// | 6 | serial number, UDINT | Get |
/// | 7 | product name, SHORT_STRING | Get |
/// | 8 | state, USINT | Get, if there |
/// | 9 | configuration consistency value, UINT | Get, if there |
/// | 10 | heartbeat interval in s, USINT, 0: none | Get and Set, if there |
///
/// | Service | Answer |
/// |---|---|
/// | 0x01 Get_Attributes_All | as [`IdentityAttributes`](crate::identity::IdentityAttributes) |
/// | 0x05 Reset | `85`, and [`Effects::reset`]; see [`Resets`] |
/// | 0x0E, 0x10 | Set only with attribute 10 |
///
/// Class attribute 1 (revision) is 1. Source: CIP Vol. 1, chapter 5; product manuals.
///
/// The owner puts it together for a request, and takes the heartbeat interval back after
/// [`Effect::HEARTBEAT_INTERVAL`]. What is constant can be in read-only memory:
///
/// ```
/// # use cip_core::code::{DeviceType, VendorId};
/// # use cip_core::codec::Writer;
/// # use cip_core::identity::{DeviceIdentity, IdentityStatus, ProductName, Revision};
/// use cip_core::code::{ClassId, InstanceId, ServiceCode};
/// use cip_core::message::ResetType;
/// use cip_core::object::{Call, FailureOptions, Identity, Resets, respond};
///
/// # let device = DeviceIdentity {
/// #     vendor: VendorId(65_000), device_type: DeviceType::GENERIC, product_code: 1,
/// #     revision: Revision::new(1, 1).ok_or("revision")?, serial: 1, name: ProductName::new("x").ok_or("name")?,
/// # };
/// let mut identity = Identity::new(&device);
/// identity.status = IdentityStatus::OWNED;
/// identity.resets = Resets::OUT_OF_BOX;
///
/// let call = Call::new(ServiceCode::RESET, ClassId::IDENTITY, InstanceId(1), &[1]);
/// let mut buffer = [0; 8];
/// let mut out = Writer::new(&mut buffer);
/// let effects = respond(&mut (identity,), &call, FailureOptions::default(), &mut out).map_err(|_| "refused")?;
/// assert_eq!(out.written(), [0x85]);
/// assert_eq!(effects.reset_type(), Some(ResetType::OUT_OF_BOX)); // once the response is on the network
/// # Ok::<(), &str>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Identity<'a> {
    /// Attributes 1-4, 6 and 7.
    pub device: &'a DeviceIdentity,
    /// Attribute 5.
    pub status: IdentityStatus,
    /// Attribute 8, if the device has it.
    pub state: Option<DeviceState>,
    /// Attribute 9, if the device has it.
    pub configuration_consistency: Option<u16>,
    /// Attribute 10 in seconds, if the device has it.
    pub heartbeat_interval: Option<u8>,
    /// The reset types beyond the power cycle, which every device has.
    pub resets: Resets,
    /// Why a reset is impossible just now: 0x10 or 0x0C.
    pub reset_refused: Option<Failure>,
}

bitflags::bitflags! {
    /// Which types of Reset a device carries out. All others are answered with 0x20.
    ///
    /// | Type | Effect | |
    /// |---|---|---|
    /// | none, 0 | as if the power was switched off and on | always |
    /// | 1 | out-of-box configuration, then as 0 | `OUT_OF_BOX` |
    /// | 2 | as 1, but MAC ID and bit rate are kept | `KEEP_COMMUNICATION` |
    /// | 3-99, 200-255 | reserved | never |
    /// | 100-199 | the vendor's | `VENDOR_SPECIFIC`: all of them reach the owner |
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    pub struct Resets: u8 {
        /// Type 1.
        const OUT_OF_BOX = 0x01;
        /// Type 2.
        const KEEP_COMMUNICATION = 0x02;
        /// Types 100-199.
        const VENDOR_SPECIFIC = 0x04;
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Resets {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{=u8:#04x}", self.bits());
    }
}

impl Resets {
    /// True if a Reset of this type is carried out.
    pub const fn allow(self, kind: ResetType) -> bool {
        match kind {
            ResetType::POWER_CYCLE => true,
            ResetType::OUT_OF_BOX => self.contains(Self::OUT_OF_BOX),
            ResetType::OUT_OF_BOX_KEEP_COMMUNICATION => self.contains(Self::KEEP_COMMUNICATION),
            _ => kind.is_vendor_specific() && self.contains(Self::VENDOR_SPECIFIC),
        }
    }
}

impl<'a> Identity<'a> {
    /// A device without faults and without the optional attributes, which resets by a power cycle only.
    pub const fn new(device: &'a DeviceIdentity) -> Self {
        Self {
            device,
            status: IdentityStatus::empty(),
            state: None,
            configuration_consistency: None,
            heartbeat_interval: None,
            resets: Resets::empty(),
            reset_refused: None,
        }
    }

    /// Whether instance 1 has the attribute.
    // Where a device is compiled it is known which it has, and what it has not is no code.
    #[inline]
    pub const fn has(&self, attribute: AttributeId) -> bool {
        match attribute.0 {
            1..=7 => true,
            8 => self.state.is_some(),
            9 => self.configuration_consistency.is_some(),
            10 => self.heartbeat_interval.is_some(),
            _ => false,
        }
    }

    /// Writes an attribute of instance 1, wherever an attribute that the device does not have is written as unknown.
    // What a device is asked most: a call would take a tenth of its instructions.
    #[inline(always)]
    pub fn emit_attribute(&self, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        let word = match attribute.0 {
            1 => self.device.vendor.0,
            2 => self.device.device_type.0,
            3 => self.device.product_code,
            4 => u16::from_le_bytes([self.device.revision.major, self.device.revision.minor]),
            5 => self.status.bits(),
            6 => return Ok(out.u32(self.device.serial)?),
            7 => return Ok(self.device.name.emit(out)?),
            8 => return Ok(out.u8(self.state.unwrap_or(DeviceState::NOT_IMPLEMENTED).0)?),
            9 => self.configuration_consistency.unwrap_or(0),
            10 => return Ok(out.u8(self.heartbeat_interval.unwrap_or(0))?),
            _ => return Err(GeneralStatus::ATTRIBUTE_NOT_SUPPORTED.into()),
        };
        Ok(out.u16(word)?)
    }

    /// The service Reset of instance 1.
    pub fn reset(&self, call: &Call<'_>) -> Result<Effects, Failure> {
        let kind = match call.data {
            [] => ResetType::POWER_CYCLE,
            [kind] => ResetType(*kind),
            [..] => return Err(GeneralStatus::TOO_MUCH_DATA.into()),
        };
        if let Some(refused) = self.reset_refused {
            return Err(refused);
        }
        if self.resets.allow(kind) {
            Ok(Effects::reset(kind))
        } else {
            Err(GeneralStatus::INVALID_PARAMETER.into())
        }
    }

    /// Up to the last attribute that is there; one between that is not has the value that says so.
    fn attributes_all(&self, out: &mut Writer<'_>) -> Result<(), Failure> {
        let last = match (self.state, self.configuration_consistency, self.heartbeat_interval) {
            (_, _, Some(_)) => 10,
            (_, Some(_), None) => 9,
            (Some(_), None, None) => 8,
            (None, None, None) => 7,
        };
        for number in 1..=last {
            self.get(InstanceId(1), AttributeId(number), out)?;
        }
        Ok(())
    }
}

impl Object for Identity<'_> {
    const CLASS: ClassId = ClassId::IDENTITY;

    fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
        if instance.0 != 1 {
            return None;
        }
        let rules = if self.configuration_consistency.is_some() { WITH_9 } else { WITHOUT_9 };
        let without_10 = rules.len().saturating_sub(1);
        let start = usize::from(self.state.is_none());
        let end = if self.heartbeat_interval.is_some() { rules.len() } else { without_10 };
        rules.get(start..end)
    }

    fn get(&self, _: InstanceId, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        self.emit_attribute(attribute, out)
    }

    fn set(
        &mut self,
        _: InstanceId,
        _: AttributeId,
        value: &[u8],
        _: &mut Writer<'_>,
    ) -> Result<Effects, Failure> {
        let [interval] = exact(value)?;
        self.heartbeat_interval = Some(interval);
        Ok(Effect::HEARTBEAT_INTERVAL.into())
    }

    fn service(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Result<Effects, Failure> {
        match call.service {
            ServiceCode::RESET if !call.instance.is_class() => self.reset(call),
            ServiceCode::GET_ATTRIBUTES_ALL if !call.instance.is_class() => {
                call.no_data()?;
                self.attributes_all(out)?;
                Ok(Effects::NONE)
            }
            _ => Err(GeneralStatus::SERVICE_NOT_SUPPORTED.into()),
        }
    }
}

/// What every device has stands between attribute 8 in front and 10 at the end, so that a part of the table is the
/// table of a device without them.
const WITH_9: &[AttributeRule] = &[
    AttributeRule::get(8, 1),
    AttributeRule::get(1, 2),
    AttributeRule::get(2, 2),
    AttributeRule::get(3, 2),
    AttributeRule::get(4, 2),
    AttributeRule::get(5, 2),
    AttributeRule::get(6, 4),
    AttributeRule::get(7, 0).sized(Size::ShortString),
    AttributeRule::get(9, 2),
    AttributeRule::get_set(10, 1),
];

/// The same without attribute 9.
const WITHOUT_9: &[AttributeRule] = &[
    AttributeRule::get(8, 1),
    AttributeRule::get(1, 2),
    AttributeRule::get(2, 2),
    AttributeRule::get(3, 2),
    AttributeRule::get(4, 2),
    AttributeRule::get(5, 2),
    AttributeRule::get(6, 4),
    AttributeRule::get(7, 0).sized(Size::ShortString),
    AttributeRule::get_set(10, 1),
];
