//! What every DeviceNet node has, and what those of DeviceNeX share with it.

use core::ops::Range;

use cip_core::code::{DeviceType, VendorId};
use cip_core::identity::{DeviceIdentity, PRODUCT_NAME_MAX, ProductName, Revision};
use toml::Spanned;

use super::Checker;
use crate::scenario::diagnostic::ScenarioError;
use crate::scenario::model::{AccessNode, Protocol};
use crate::scenario::raw::{RawIdentity, RawNode};

impl Checker<'_> {
    pub(super) fn access(&self, raw: &RawNode, table: &Range<usize>) -> Result<AccessNode, ScenarioError> {
        self.protocol(raw, table, Protocol::DeviceNet)?;
        let mac =
            self.mac_id("mac", self.required(raw.mac.as_ref(), table, "`mac`, the MAC ID of the node,")?)?;
        Ok(AccessNode {
            mac,
            device: self.required_identity(raw, table)?,
            port: self.port(raw)?,
            boi: is_set(raw.boi.as_ref()),
            quick_connect: is_set(raw.quick_connect.as_ref()),
            offline_set: is_set(raw.offline_set.as_ref()),
            switches: is_set(raw.switches.as_ref()),
        })
    }

    /// A node says what it speaks, and that is what its role speaks.
    pub(super) fn protocol(
        &self,
        raw: &RawNode,
        table: &Range<usize>,
        of_role: Protocol,
    ) -> Result<(), ScenarioError> {
        let what = format!("`protocol = \"{of_role}\"` of the node");
        let protocol = self.required(raw.protocol.as_ref(), table, &what)?;
        let named = self.name("protocol", Some(protocol), Protocol::ALL, Protocol::name)?;
        match (named, &raw.role) {
            (Some(named), Some(role)) if named != of_role => self.fail(
                &protocol.span(),
                format!("the role `{}` is not one of {named}; expected `{of_role}`", role.get_ref()),
            ),
            _ => Ok(()),
        }
    }

    pub(super) fn required_identity(
        &self,
        raw: &RawNode,
        table: &Range<usize>,
    ) -> Result<DeviceIdentity, ScenarioError> {
        let what = "`identity = { vendor = .., serial = .. }` of the node";
        self.identity(self.required(raw.identity.as_ref(), table, what)?, raw.name.as_ref())
    }

    pub(super) fn port(&self, raw: &RawNode) -> Result<u8, ScenarioError> {
        match &raw.port {
            Some(port) => self.number("port", port, 0, 127, "a physical port number, 0 to 127"),
            None => Ok(0),
        }
    }

    /// Who it is. Network access shows vendor and serial number only; what has a name by default has that of the node.
    fn identity(
        &self,
        table: &Spanned<RawIdentity>,
        node: Option<&Spanned<String>>,
    ) -> Result<DeviceIdentity, ScenarioError> {
        let (raw, span) = (table.get_ref(), table.span());
        let number = |key, value: &Option<Spanned<i64>>| match value {
            Some(value) => self.number::<u16>(key, value, 0, 0xFFFF, "a number of 16 bits"),
            None => Ok(0),
        };
        let (device_type, product_code) =
            (number("device_type", &raw.device_type)?, number("product", &raw.product)?);
        let revision = match &raw.revision {
            Some(revision) => self.revision(revision)?,
            None => Revision { major: 1, minor: 1 },
        };
        let name = match (&raw.name, node) {
            (Some(name), _) => match ProductName::new(name.get_ref()) {
                Some(product) => product,
                None => {
                    return self.fail(
                        &name.span(),
                        "`name` is no product name; expected at most 32 characters of ISO 8859-1",
                    );
                }
            },
            (None, Some(node)) => {
                let short: String = node.get_ref().chars().take(PRODUCT_NAME_MAX).collect();
                ProductName::new(&short).unwrap_or_default()
            }
            (None, None) => ProductName::default(),
        };
        let vendor = self.required(raw.vendor.as_ref(), &span, "`vendor` of the identity")?;
        let serial = self.required(raw.serial.as_ref(), &span, "`serial` of the identity")?;
        Ok(DeviceIdentity {
            vendor: VendorId(self.vendor(vendor)?),
            device_type: DeviceType(device_type),
            product_code,
            revision,
            serial: self.serial(serial)?,
            name,
        })
    }

    pub(super) fn vendor(&self, value: &Spanned<i64>) -> Result<u16, ScenarioError> {
        self.number("vendor", value, 0, 0xFFFF, "a Vendor ID, 0 to 0xFFFF")
    }

    pub(super) fn serial(&self, value: &Spanned<i64>) -> Result<u32, ScenarioError> {
        self.number("serial", value, 0, 0xFFFF_FFFF, "a serial number, 0 to 0xFFFF_FFFF")
    }

    pub(super) fn revision(&self, value: &Spanned<[i64; 2]>) -> Result<Revision, ScenarioError> {
        let [major, minor] = *value.get_ref();
        match (u8::try_from(major), u8::try_from(minor)) {
            (Ok(major), Ok(minor)) => Ok(Revision { major, minor }),
            _ => {
                self.fail(&value.span(), "`revision` is out of range; expected [major, minor], 0 to 255 each")
            }
        }
    }
}

/// A flag that is given, and true.
pub(super) fn is_set(flag: Option<&Spanned<bool>>) -> bool {
    flag.is_some_and(|flag| *flag.get_ref())
}
