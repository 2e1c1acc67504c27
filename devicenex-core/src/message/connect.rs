//! Connection request and response: a connection in two steps.

use core::fmt;

use cip_core::code::{GeneralStatus, InstanceId, ServiceCode};
use cip_core::codec::{Full, ParseError, ParseErrorKind, Reader, Tail, Wire, Writer};
use cip_core::connection::WatchdogAction;
use cip_core::message::BodyFormat;

use super::ConnectionInstance;
use super::fields::constant;
use crate::id::MessageId;

/// Connection request (paper 4.4, figures 7 and 10) **\[P\]**. Not valid from or to OA 127.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | 0x4B |
/// | 1 | bit 7 P: 1 predefined; bits 6-4 Group Select; bits 3-0 Source Message ID: that with which the *requester* will produce **\[R\]** |
/// | 2-3 | target connection instance ID, little-endian |
/// | 4-5 | target expected packet rate in ms, little-endian |
/// | 6 | target watchdog timeout action |
///
/// Two bytes ask for a dynamic connection, which is in *Configuring* then, with default attributes. Seven bytes ask for a
/// connection that is *Established* at once. Between these lengths nothing is allowed ([`refusal`](Self::refusal)).
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ConnectionRequest {
    /// P: a connection of the predefined set.
    pub predefined: bool,
    /// Where the requester would like the connection to be.
    pub group: GroupSelect,
    /// That with which the requester will produce.
    pub source_message: MessageId,
    /// Which connection, in a request of seven bytes.
    pub target: Option<Target>,
}

/// The conditional part of a connection request.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Target {
    /// Which connection of the target.
    pub instance: InstanceId,
    /// In ms; 0: it never times out.
    pub expected_packet_rate: u16,
    /// What the target does when it times out.
    pub watchdog_action: WatchdogAction,
}

/// Connection response (paper 4.4, figure 8) **\[P\]**.
///
/// | Byte | Content |
/// |---|---|
/// | 0 | 0x4B: that it is a response says the R bit of the identifier **\[R\]** |
/// | 1 | bit 7 P; bits 6-4 actual group; bits 3-0 Source Message ID of the *target* |
/// | 2 | bits 7-4 reserved, 0; bits 3-0 message body format, as in DeviceNet |
/// | 3-4 | predefined: actual expected packet rate in ms; dynamic: connection instance ID; little-endian |
///
/// "Conditional" in the figure is read as: bytes 3 and 4 are always there, and P says what they are **\[R\]**. A refusal
/// is an [`ErrorResponse`](super::ErrorResponse) **\[D\]**.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ConnectionResponse {
    /// Where the connection is.
    pub group: GroupSelect,
    /// That with which the target will produce.
    pub source_message: MessageId,
    /// How requests name an object.
    pub body_format: FormatByte,
    /// What was granted; it decides about P.
    pub granted: Granted,
}

/// Bytes 3 and 4 of a connection response.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Granted {
    /// A connection of the predefined set.
    Predefined {
        /// The rate that the target keeps, in ms.
        expected_packet_rate: u16,
    },
    /// A dynamic connection.
    Dynamic {
        /// That the target chose.
        instance: InstanceId,
    },
}

/// Where a connection shall be: three bits.
///
/// | Value | Group |
/// |---|---|
/// | 0, 1, 3 | Group 1, 2, 3 of 11-bit identifiers, as in DeviceNet |
/// | 4 | implicit messages with 29 bits **\[D\]** |
/// | 5 | explicit messages with 29 bits **\[D\]** |
/// | 2, 6, 7 | reserved |
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(transparent))]
pub struct GroupSelect(u8);

/// Byte 2 of a connection response, reserved bits and codes included.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(transparent))]
pub struct FormatByte(pub u8);

impl ConnectionRequest {
    /// Why a target must refuse the request, whatever connections it has; `None` if that depends on them.
    ///
    /// | Request | General status |
    /// |---|---|
    /// | two bytes with P = 1: no instance is named **\[D\]** | 0x20, invalid parameter |
    /// | a reserved instance **\[D\]** | 0x05, path destination unknown |
    /// | P = 1 with a dynamic instance, P = 0 with one of 1 to 13 **\[D\]** | 0x20 |
    #[must_use]
    pub fn refusal(&self) -> Option<GeneralStatus> {
        let Some(target) = self.target else {
            return self.predefined.then_some(GeneralStatus::INVALID_PARAMETER);
        };
        match (ConnectionInstance::of(target.instance), self.predefined) {
            (ConnectionInstance::Reserved(_), _) => Some(GeneralStatus::PATH_DESTINATION_UNKNOWN),
            (ConnectionInstance::Predefined(_), false) | (ConnectionInstance::Dynamic(_), true) => {
                Some(GeneralStatus::INVALID_PARAMETER)
            }
            (ConnectionInstance::Predefined(_), true) | (ConnectionInstance::Dynamic(_), false) => None,
        }
    }

    /// The general status by which a target answers a request that it cannot read: 0x13 for a short one, 0x15 for a long
    /// one, 0x08 for another service **\[D\]**.
    #[must_use]
    pub const fn status_of(error: &ParseError) -> GeneralStatus {
        match error.kind {
            ParseErrorKind::Short { .. } => GeneralStatus::NOT_ENOUGH_DATA,
            ParseErrorKind::Trailing { .. } => GeneralStatus::TOO_MUCH_DATA,
            // The service is the only field with a value that is not allowed.
            ParseErrorKind::Value { .. } => GeneralStatus::SERVICE_NOT_SUPPORTED,
        }
    }
}

impl GroupSelect {
    /// 0
    pub const GROUP_1: Self = Self(0);
    /// 1
    pub const GROUP_2: Self = Self(1);
    /// 3
    pub const GROUP_3: Self = Self(3);
    /// 4
    pub const IMPLICIT_29: Self = Self(4);
    /// 5
    pub const EXPLICIT_29: Self = Self(5);

    /// The selection of that number; `None` above 7.
    #[must_use]
    pub const fn new(number: u8) -> Option<Self> {
        if number <= THREE_BITS { Some(Self(number)) } else { None }
    }

    /// 0 to 7.
    #[must_use]
    pub const fn number(self) -> u8 {
        self.0
    }

    /// The name; `None` for a reserved value.
    #[must_use]
    pub const fn name(self) -> Option<&'static str> {
        match self {
            Self::GROUP_1 => Some("Group 1"),
            Self::GROUP_2 => Some("Group 2"),
            Self::GROUP_3 => Some("Group 3"),
            Self::IMPLICIT_29 => Some("29-bit implicit"),
            Self::EXPLICIT_29 => Some("29-bit explicit"),
            _ => None,
        }
    }
}

/// The name, or `reserved group 7`.
impl fmt::Display for GroupSelect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name() {
            Some(name) => f.write_str(name),
            None => write!(f, "reserved group {}", self.0),
        }
    }
}

impl FormatByte {
    /// The body format; `None` for a reserved code.
    #[must_use]
    pub const fn body_format(self) -> Option<BodyFormat> {
        BodyFormat::from_code(self.0 & FOUR_BITS)
    }
}

impl From<BodyFormat> for FormatByte {
    fn from(format: BodyFormat) -> Self {
        Self(format.code())
    }
}

impl Wire<'_> for ConnectionRequest {
    const NAME: &'static str = "connection request";
    /// The two bytes of the short form begin the long one.
    const TAIL: Tail = Tail::Open;

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        constant(reader, "service", CONNECT)?;
        let (predefined, group, source_message) = split(reader.u8("P, group and Source Message ID")?);
        let target = if reader.is_empty() { None } else { Some(Target::read(reader)?) };
        Ok(Self { predefined, group, source_message, target })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.bytes(&[CONNECT, join(self.predefined, self.group, self.source_message)])?;
        self.target.map_or(Ok(()), |target| target.emit(out))
    }

    fn wire_len(&self) -> usize {
        if self.target.is_some() { 7 } else { 2 }
    }
}

impl Target {
    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        Ok(Self {
            instance: InstanceId(reader.u16("connection instance")?),
            expected_packet_rate: reader.u16("expected packet rate")?,
            watchdog_action: WatchdogAction(reader.u8("watchdog timeout action")?),
        })
    }

    fn emit(self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u16(self.instance.0)?;
        out.u16(self.expected_packet_rate)?;
        out.u8(self.watchdog_action.0)
    }
}

impl Wire<'_> for ConnectionResponse {
    const NAME: &'static str = "connection response";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        constant(reader, "service", CONNECT)?;
        Self::read_after_service(reader)
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        let (predefined, value) = match self.granted {
            Granted::Predefined { expected_packet_rate } => (true, expected_packet_rate),
            Granted::Dynamic { instance } => (false, instance.0),
        };
        out.bytes(&[CONNECT, join(predefined, self.group, self.source_message), self.body_format.0])?;
        out.u16(value)
    }

    fn wire_len(&self) -> usize {
        5
    }
}

impl ConnectionResponse {
    /// Reads all that follows the service.
    pub(crate) fn read_after_service(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let (predefined, group, source_message) = split(reader.u8("P, group and Source Message ID")?);
        let body_format = FormatByte(reader.u8("message body format")?);
        let granted = if predefined {
            Granted::Predefined { expected_packet_rate: reader.u16("expected packet rate")? }
        } else {
            Granted::Dynamic { instance: InstanceId(reader.u16("connection instance")?) }
        };
        Ok(Self { group, source_message, body_format, granted })
    }
}

const fn split(byte: u8) -> (bool, GroupSelect, MessageId) {
    (byte & PREDEFINED != 0, GroupSelect(byte >> 4 & THREE_BITS), MessageId::from_low_bits(byte))
}

fn join(predefined: bool, group: GroupSelect, source_message: MessageId) -> u8 {
    let flag = if predefined { PREDEFINED } else { 0 };
    flag | group.number() << 4 | source_message.number()
}

const CONNECT: u8 = ServiceCode::ALLOCATE.request_byte();
const PREDEFINED: u8 = 0x80;
const THREE_BITS: u8 = 7;
const FOUR_BITS: u8 = 0xF;
