//! A device and the MAC ID that it is to have, as people write them.

use core::fmt;
use core::str::FromStr;

use devicenet_core::MacId;
use devicenet_core::message::DeviceIdentity;

use super::attribute::number;

/// A device, as people write it: `VENDOR:SERIAL`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Device(pub DeviceIdentity);

/// A device and its new MAC ID: `VENDOR:SERIAL=MAC`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Assignment {
    /// The device.
    pub device: Device,
    /// What it is given.
    pub mac: MacId,
}

/// `0x1234:0x00002345`
impl fmt::Display for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "0x{:04X}:0x{:08X}", self.0.vendor.0, self.0.serial)
    }
}

impl FromStr for Device {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once(':').and_then(|(vendor, serial)| {
            let vendor = u16::try_from(number(vendor)?).ok()?;
            Some(DeviceIdentity { vendor: vendor.into(), serial: u32::try_from(number(serial)?).ok()? })
        });
        parts.map(Self).ok_or_else(|| "VENDOR:SERIAL expected, such as 0x1234:0x00002345".into())
    }
}

impl FromStr for Assignment {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || "VENDOR:SERIAL=MAC expected, such as 0x1234:0x00002345=12".to_owned();
        let (device, mac) = text.split_once('=').ok_or_else(expected)?;
        let mac = number(mac)
            .and_then(|mac| MacId::new(u8::try_from(mac).ok()?))
            .ok_or_else(|| format!("`{mac}`: a MAC ID from 0 to 63 expected after the ="))?;
        Ok(Self { device: device.parse()?, mac })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn devices_as_they_are_written() {
        let device: Device = "0x1234:9029".parse().unwrap();
        assert_eq!(device.to_string(), "0x1234:0x00002345");
        let assignment: Assignment = "4660:0x2345=0x0C".parse().unwrap();
        assert_eq!((assignment.device, assignment.mac.number()), (device, 12));
        for text in ["", "1", "1:", "65536:1", "1:4294967296", "1:+1", "a:1"] {
            assert!(text.parse::<Device>().is_err(), "{text}");
        }
        for text in ["1:1", "1:1=64", "1:1=", "1=1:1"] {
            assert!(text.parse::<Assignment>().is_err(), "{text}");
        }
    }
}
