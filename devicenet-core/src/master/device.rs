//! An entry of the scan list from what a device supports, as its Electronic Data Sheet says.

use cip_core::scan::{self, DeviceKey, IoType, IoTypes, ScanConnection};

use super::scan_list::{
    BitStrobeConnection, ChangeOfStateConnection, ElectronicKey, PollConnection, ScanEntry,
};
use crate::id::MacId;

/// Why connections of a device cannot be in the scan list together.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ConnectionError {
    /// The device does not support it.
    #[error("the device does not support {0}: choose another connection")]
    NotSupported(IoType),
    /// Not together.
    #[error("the device does not support {0} together with {1}: choose one of them")]
    Incompatible(IoType, IoType),
}

/// Every attribute counts.
impl From<DeviceKey> for ElectronicKey {
    fn from(key: DeviceKey) -> Self {
        Self {
            vendor: Some(key.vendor),
            device_type: Some(key.device_type),
            product_code: Some(key.product_code),
            revision: Some(key.revision),
        }
    }
}

impl ScanEntry {
    /// The expected packet rate that scanners begin with, in ms.
    pub const DEFAULT_EXPECTED_PACKET_RATE: u16 = 75;

    /// The entry of a device, with the connections that are used if nobody chooses; see [`with`](Self::with).
    pub fn of_device(mac_id: MacId, device: &scan::ScanEntry) -> Result<Self, ConnectionError> {
        Self::with(mac_id, device, device.default)
    }

    /// The entry of a device, with these connections.
    ///
    /// What an Electronic Data Sheet does not say is as scanners begin with it, and can be changed: expected packet rates
    /// of 75 ms, no inhibit time, change-of-state and cyclic messages with acknowledge, polled in every scan, not replaced.
    ///
    /// ```
    /// use cip_core::identity::Revision;
    /// use cip_core::scan::{self, DeviceKey, IoType, IoTypes, ScanConnection, ScanData};
    /// use devicenet_core::MacId;
    /// use devicenet_core::master::{PollConnection, ScanEntry};
    ///
    /// // What `cip_core::eds::Eds::scan_entry` reads from the file of a device with two bytes of inputs and one of outputs.
    /// let poll = ScanConnection {
    ///     ty: IoType::Poll,
    ///     compatible: IoTypes::POLL,
    ///     produced: ScanData { size: 2, ..ScanData::default() },
    ///     consumed: ScanData { size: 1, ..ScanData::default() },
    /// };
    /// let revision = Revision { major: 1, minor: 2 };
    /// let device = scan::ScanEntry {
    ///     key: DeviceKey { vendor: 999.into(), device_type: 7.into(), product_code: 42, revision },
    ///     connections: [poll].into_iter().collect(),
    ///     default: IoTypes::POLL,
    /// };
    ///
    /// let mut entry = ScanEntry::with(MacId::try_from(10)?, &device, IoTypes::POLL)?;
    /// assert_eq!(entry.poll, Some(PollConnection { produce: 2, consume: 1, expected_packet_rate: 75 }));
    /// assert_eq!(entry.key.product_code, Some(42));
    ///
    /// // Any revision will do.
    /// entry.key.revision = None;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with(mac_id: MacId, device: &scan::ScanEntry, types: IoTypes) -> Result<Self, ConnectionError> {
        let mut entry = Self { key: device.key.into(), ..Self::explicit_only(mac_id) };
        for ty in IoType::ALL.into_iter().filter(|ty| types.contains(ty.mask())) {
            let connection = device.connection(ty).ok_or(ConnectionError::NotSupported(ty))?;
            if let Some(other) = incompatible(device, connection, types) {
                return Err(ConnectionError::Incompatible(ty, other));
            }
            entry.add(connection);
        }
        Ok(entry)
    }

    fn add(&mut self, connection: &ScanConnection) {
        let (produce, consume) = (connection.produced.size, connection.consumed.size);
        let expected_packet_rate = Self::DEFAULT_EXPECTED_PACKET_RATE;
        let poll = PollConnection { produce, consume, expected_packet_rate };
        match connection.ty {
            IoType::Poll => self.poll = Some(poll),
            IoType::BitStrobe => {
                self.bit_strobe = Some(BitStrobeConnection { produce, expected_packet_rate });
            }
            IoType::ChangeOfState | IoType::Cyclic => {
                self.change_of_state = Some(ChangeOfStateConnection {
                    cyclic: connection.ty == IoType::Cyclic,
                    acknowledged: true,
                    produce,
                    consume,
                    expected_packet_rate,
                    inhibit: 0,
                });
            }
            IoType::MulticastPoll => self.multicast_poll = Some(poll),
        }
    }
}

/// Another of the chosen connections that does not go with this one. It is enough if one of the two says that they go
/// together; change of state and cyclic are one connection.
fn incompatible(device: &scan::ScanEntry, connection: &ScanConnection, types: IoTypes) -> Option<IoType> {
    let state_changes = IoTypes::CHANGE_OF_STATE.union(IoTypes::CYCLIC);
    let others = device.connections.iter().filter(|other| types.contains(other.ty.mask()));
    let clashes = |other: &&ScanConnection| {
        other.ty != connection.ty
            && (state_changes.contains(other.ty.mask().union(connection.ty.mask()))
                || !(connection.compatible.contains(other.ty.mask())
                    || other.compatible.contains(connection.ty.mask())))
    };
    others.into_iter().find(clashes).map(|other| other.ty)
}

#[cfg(test)]
mod tests {
    use cip_core::code::{DeviceType, VendorId};
    use cip_core::identity::Revision;
    use cip_core::scan::ScanData;

    use super::*;

    /// Everything; strobe goes with poll, and nothing says that multicast poll goes with anything.
    fn device() -> scan::ScanEntry {
        let connections = IoType::ALL.map(|ty| ScanConnection {
            ty,
            compatible: match ty {
                IoType::Poll => IoTypes::POLL | IoTypes::BIT_STROBE | IoTypes::CYCLIC,
                IoType::ChangeOfState => IoTypes::CYCLIC,
                IoType::BitStrobe | IoType::Cyclic | IoType::MulticastPoll => ty.mask(),
            },
            produced: ScanData { size: 2, ..ScanData::default() },
            consumed: ScanData { size: 3, ..ScanData::default() },
        });
        scan::ScanEntry {
            key: DeviceKey {
                vendor: VendorId(999),
                device_type: DeviceType(7),
                product_code: 42,
                revision: Revision { major: 1, minor: 2 },
            },
            connections: connections.into_iter().collect(),
            default: IoTypes::POLL,
        }
    }

    #[test]
    fn each_kind_becomes_its_connection() {
        let mac = MacId::new(10).unwrap();
        let entry = |types| ScanEntry::with(mac, &device(), types).unwrap();
        let poll = Some(PollConnection { produce: 2, consume: 3, expected_packet_rate: 75 });
        let strobe = Some(BitStrobeConnection { produce: 2, expected_packet_rate: 75 });
        let change = |cyclic| {
            let (produce, consume) = (2, 3);
            let rate = 75;
            Some(ChangeOfStateConnection {
                cyclic,
                acknowledged: true,
                produce,
                consume,
                expected_packet_rate: rate,
                inhibit: 0,
            })
        };
        let key = ElectronicKey::from(device().key);
        let none = ScanEntry { key, ..ScanEntry::explicit_only(mac) };
        assert_eq!(entry(IoTypes::empty()), none);
        assert_eq!(ScanEntry::of_device(mac, &device()), Ok(ScanEntry { poll, ..none }));
        assert_eq!(
            entry(IoTypes::POLL | IoTypes::BIT_STROBE),
            ScanEntry { poll, bit_strobe: strobe, ..none }
        );
        assert_eq!(entry(IoTypes::CHANGE_OF_STATE), ScanEntry { change_of_state: change(false), ..none });
        assert_eq!(
            entry(IoTypes::CYCLIC | IoTypes::POLL),
            ScanEntry { poll, change_of_state: change(true), ..none }
        );
        assert_eq!(entry(IoTypes::MULTICAST_POLL), ScanEntry { multicast_poll: poll, ..none });
    }

    #[test]
    fn connections_that_the_device_has_not_or_not_together_are_refused() {
        let refused =
            |device: &scan::ScanEntry, types| ScanEntry::with(MacId::MIN, device, types).unwrap_err();
        let incompatible = ConnectionError::Incompatible;
        let (poll, change, cyclic) = (IoType::Poll, IoType::ChangeOfState, IoType::Cyclic);
        let both = IoTypes::CHANGE_OF_STATE | IoTypes::CYCLIC;
        assert_eq!(refused(&device(), both), incompatible(change, cyclic));
        let multicast = IoTypes::POLL | IoTypes::MULTICAST_POLL;
        assert_eq!(refused(&device(), multicast), incompatible(poll, IoType::MulticastPoll));
        let mut small = device();
        small.connections.retain(|connection| connection.ty == IoType::Poll);
        let error = refused(&small, both);
        assert_eq!(error, ConnectionError::NotSupported(change));
        assert_eq!(
            std::string::ToString::to_string(&error),
            "the device does not support change of state: choose another connection"
        );
    }
}
