//! What a master says at the two doors of a slave, the unconnected port of Group 2 and the UCMM: bodies from the service
//! byte on, and what it reads of the answers.

use cip_core::code::InstanceId;
use cip_core::message::{AllocationChoice, BodyFormat};

use crate::id::MacId;

/// Allocate of the explicit connection.
pub(super) const fn allocate_explicit(own: MacId) -> [u8; 5] {
    [ALLOCATE, DEVICENET, INSTANCE, AllocationChoice::EXPLICIT.bits(), own.number()]
}

/// Release.
pub(super) const fn release(choice: AllocationChoice) -> [u8; 4] {
    [RELEASE, DEVICENET, INSTANCE, released(choice)]
}

/// A release choice: acknowledge suppression is no connection.
pub(super) const fn released(choice: AllocationChoice) -> u8 {
    choice.difference(AllocationChoice::ACK_SUPPRESSION).bits()
}

/// Open with the UCMM, in Group 3.
pub(super) const fn open(format: BodyFormat) -> [u8; 3] {
    [ALLOCATE, format.code(), OPEN_GROUP_3]
}

/// Close with the UCMM.
pub(super) const fn close(connection: InstanceId) -> [u8; 3] {
    let [low, high] = connection.0.to_le_bytes();
    [RELEASE, low, high]
}

/// The body format that the data of an Allocate response tell, whatever their reserved bits are.
pub(super) fn format_told(data: &[u8]) -> Option<BodyFormat> {
    BodyFormat::from_code(data.first()? & FORMAT)
}

/// The Message ID for the master's requests on connections that the UCMM opens.
pub(super) const SOURCE_MESSAGE: u8 = OPEN_GROUP_3 & 0x0F;
/// Group Select 3, and that Message ID.
const OPEN_GROUP_3: u8 = 0x34;
/// Also Open with the UCMM.
const ALLOCATE: u8 = 0x4B;
/// Also Close with the UCMM.
pub(super) const RELEASE: u8 = 0x4C;
/// The class of the object that is meant, and its instance.
const DEVICENET: u8 = 0x03;
const INSTANCE: u8 = 0x01;
/// The body format in an Allocate response.
const FORMAT: u8 = 0x0F;
