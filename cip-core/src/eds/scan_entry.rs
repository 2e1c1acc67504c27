//! From a file to an entry of a master's scan list.

use super::Eds;
use super::model::{Device, IoData, IoInfo};
use crate::identity::Revision;
use crate::scan::{DeviceKey, IoType, IoTypes, SCAN_PATH_MAX, ScanConnection, ScanData, ScanEntry};

/// Why no scan list entry can be made from a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
pub enum ScanEntryError {
    /// `[Device]` does not say what the device is.
    #[error("`{0}` is missing or wrong in [Device]: a master could not tell the device from others")]
    NoKey(&'static str),
    /// The file describes no I/O connection.
    #[error("[IO_Info] describes no connection: the device has no I/O, or the file does not tell it")]
    NoConnection,
    /// A connection carries data that the file does not describe.
    #[error(
        "`{keyword}{number}` is missing or wrong in [IO_Info], and the {connection} connection carries it"
    )]
    NoData {
        /// `Input` or `Output`.
        keyword: &'static str,
        /// Its number.
        number: u16,
        /// Who carries it.
        connection: IoType,
    },
    /// The path to the data is too long.
    #[error("the path of `{keyword}{number}` in [IO_Info] has more than {SCAN_PATH_MAX} bytes")]
    LongPath {
        /// `Input` or `Output`.
        keyword: &'static str,
        /// Its number.
        number: u16,
    },
}

impl Eds {
    /// What a master must know to use the device: its key, its connections with the data that they carry if nobody
    /// chooses, and the connections that are used.
    ///
    /// If `Default` names no connection that the file describes, the first of poll, change of state, cyclic, bit-strobe
    /// and multicast poll is taken.
    ///
    /// # Errors
    /// [`ScanEntryError`] says what the file lacks.
    pub fn scan_entry(&self) -> Result<ScanEntry, ScanEntryError> {
        let key = key(self.device())?;
        let io = self.io_info().ok_or(ScanEntryError::NoConnection)?;
        let mut connections = heapless::Vec::new();
        for connection in &io.connections {
            let ty = connection.ty;
            let produced = data(io, connection.input, "Input", ty, IoInfo::input)?;
            let consumed = data(io, connection.output, "Output", ty, IoInfo::output)?;
            // One for each kind, and there are as many kinds as there is room for.
            let _ = connections.push(ScanConnection {
                ty,
                compatible: connection.compatible,
                produced,
                consumed,
            });
        }
        let supported = io.connections.iter().fold(IoTypes::empty(), |types, it| types | it.ty.mask());
        let preferred = PREFERENCE.into_iter().find(|ty| supported.contains(ty.mask()));
        let fallback = preferred.ok_or(ScanEntryError::NoConnection)?.mask();
        let default = io.default & supported;
        Ok(ScanEntry { key, connections, default: if default.is_empty() { fallback } else { default } })
    }
}

fn key(device: &Device) -> Result<DeviceKey, ScanEntryError> {
    Ok(DeviceKey {
        vendor: device.vendor.ok_or(ScanEntryError::NoKey("VendCode"))?,
        device_type: device.device_type.ok_or(ScanEntryError::NoKey("ProdType"))?,
        product_code: device.product_code.ok_or(ScanEntryError::NoKey("ProdCode"))?,
        revision: device
            .revision
            .filter(|revision: &Revision| revision.is_valid())
            .ok_or(ScanEntryError::NoKey("MajRev"))?,
    })
}

fn data<'a>(
    io: &'a IoInfo,
    number: Option<u16>,
    keyword: &'static str,
    connection: IoType,
    find: impl Fn(&'a IoInfo, u16) -> Option<&'a IoData>,
) -> Result<ScanData, ScanEntryError> {
    let Some(number) = number else { return Ok(ScanData::default()) };
    let data = find(io, number).ok_or(ScanEntryError::NoData { keyword, number, connection })?;
    let path = heapless::Vec::from_slice(&data.path);
    let path = path.map_err(|_| ScanEntryError::LongPath { keyword, number })?;
    Ok(ScanData { size: data.size, path })
}

const PREFERENCE: [IoType; 5] =
    [IoType::Poll, IoType::ChangeOfState, IoType::Cyclic, IoType::BitStrobe, IoType::MulticastPoll];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::{DeviceType, VendorId};
    use crate::eds::tests::DEMO;
    use std::string::ToString as _;

    #[test]
    fn the_entry_of_a_file() {
        let entry = Eds::parse(DEMO).unwrap().scan_entry().unwrap();
        let revision = Revision { major: 1, minor: 2 };
        let (vendor, device_type) = (VendorId(0x1234), DeviceType(7));
        assert_eq!(entry.key, DeviceKey { vendor, device_type, product_code: 42, revision });
        assert_eq!(entry.default, IoTypes::POLL);
        let poll = entry.connection(IoType::Poll).unwrap();
        assert_eq!((poll.produced.size, poll.consumed.size), (2, 1));
        assert_eq!(poll.produced.path[..], [0x20, 0x04, 0x24, 0x65, 0x30, 0x03]);
        assert_eq!(poll.compatible, IoTypes::POLL | IoTypes::BIT_STROBE);
        let strobe = entry.connection(IoType::BitStrobe).unwrap();
        assert_eq!(strobe.consumed, ScanData::default());
        assert_eq!(entry.default_connections().count(), 1);
        assert_eq!(entry.connection(IoType::Cyclic), None);
    }

    #[test]
    fn a_default_that_is_not_described_is_replaced() {
        let file = DEMO.replace("Default    = 0x0001", "Default = 0x0008");
        assert_eq!(Eds::parse(file).unwrap().scan_entry().unwrap().default, IoTypes::POLL);
        let file = DEMO.replace("Default    = 0x0001", "Default = 0").replace("PollInfo   =", "MPollInfo =");
        assert_eq!(Eds::parse(file).unwrap().scan_entry().unwrap().default, IoTypes::CHANGE_OF_STATE);
    }

    #[test]
    fn what_is_missing_is_named() {
        let error = |from: &str, to: &str| {
            let file = DEMO.replace(from, to);
            Eds::parse(file).unwrap().scan_entry().unwrap_err().to_string()
        };
        assert!(error("MajRev = 1;", "MajRev = 0;").contains("`MajRev`"));
        assert!(error("VendCode", "Vendor").contains("`VendCode`"));
        assert!(error("[IO_Info]", "[1_Info]").contains("no connection"));
        assert!(error("Input1  =", "Input7 =").contains("`Input1`"));
    }
}
