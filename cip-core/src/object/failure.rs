//! Why an object refuses a service.

use core::fmt;
use core::num::NonZeroU32;

use crate::code::{AdditionalCode, GeneralStatus};
use crate::codec::{Full, ParseError, ParseErrorKind, Writer};
use crate::message::Response;

/// The status of a refused service.
///
/// | Byte of the response | Content |
/// |---|---|
/// | 0 | 0x94 |
/// | 1 | general status |
/// | 2 | additional code, 0xFF: none |
///
/// An object that knows only a general status returns it with `?` or `.into()`.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(from = "Codes", into = "Codes")
)]
pub struct Failure {
    /// Bits 7-0 the general status, bits 15-8 the complement of the additional code. One word is returned in a register,
    /// and as it is never 0, so is its absence: on a small processor all objects are shorter by it.
    word: NonZeroU32,
}

/// Where devices differ in the status of a refusal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FailureOptions {
    /// Answer 0x2A (Group 2 only server general failure) instead of 0x08, 0x0E and 0x14, as a Group 2 Only server with
    /// very little code space may. Default: no.
    pub group_2_only_failure: bool,
    /// Answer 0x05 (Path destination unknown) instead of 0x16 to a path (format 4) whose class or instance does not
    /// exist, as devices of other CIP networks do. Default: no.
    pub path_destination_unknown: bool,
}

impl Failure {
    /// A failure without an additional code.
    pub const fn new(general: GeneralStatus) -> Self {
        Self::of(general, AdditionalCode::NONE)
    }

    /// The same with an additional code.
    #[must_use]
    pub const fn with_additional(self, additional: AdditionalCode) -> Self {
        Self::of(self.general(), additional)
    }

    /// What is wrong. Never 0, which is no failure: 0x01 (connection failure) stands for it.
    pub const fn general(self) -> GeneralStatus {
        let [general, ..] = self.word.get().to_le_bytes();
        GeneralStatus(general)
    }

    /// More about it, in words of the object.
    pub const fn additional(self) -> AdditionalCode {
        let [_, complement, ..] = self.word.get().to_le_bytes();
        AdditionalCode(!complement)
    }

    const fn of(general: GeneralStatus, additional: AdditionalCode) -> Self {
        let general = if general.0 == 0 { GeneralStatus::CONNECTION_FAILURE } else { general };
        match NonZeroU32::new(u32::from_le_bytes([general.0, !additional.0, 0, 0])) {
            Some(word) => Self { word },
            None => Self { word: NonZeroU32::MIN },
        }
    }

    /// The failure as it is answered under `options` to a request that did or did not name its object by a path.
    #[must_use]
    #[inline(never)]
    pub fn under(self, options: FailureOptions, by_path: bool) -> Self {
        let small = matches!(
            self.general(),
            GeneralStatus::SERVICE_NOT_SUPPORTED
                | GeneralStatus::ATTRIBUTE_NOT_SETTABLE
                | GeneralStatus::ATTRIBUTE_NOT_SUPPORTED
        );
        if options.group_2_only_failure && small {
            return Self::of(GeneralStatus::GROUP_2_ONLY_SERVER_FAILURE, self.additional());
        }
        let unknown = self.general() == GeneralStatus::OBJECT_DOES_NOT_EXIST;
        if options.path_destination_unknown && by_path && unknown {
            return Self::of(GeneralStatus::PATH_DESTINATION_UNKNOWN, self.additional());
        }
        self
    }

    /// Writes the error response: three bytes.
    pub fn emit(self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.bytes(&[
            crate::code::ServiceCode::ERROR_RESPONSE.response_byte(),
            self.general().0,
            self.additional().0,
        ])
    }
}

impl fmt::Debug for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Failure")
            .field("general", &self.general())
            .field("additional", &self.additional())
            .finish()
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Failure {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "Failure {} {}", self.general(), self.additional());
    }
}

/// A failure as it is serialised.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "Failure")]
struct Codes {
    general: GeneralStatus,
    additional: AdditionalCode,
}

#[cfg(feature = "serde")]
impl From<Failure> for Codes {
    fn from(failure: Failure) -> Self {
        Self { general: failure.general(), additional: failure.additional() }
    }
}

#[cfg(feature = "serde")]
impl From<Codes> for Failure {
    fn from(codes: Codes) -> Self {
        Self::of(codes.general, codes.additional)
    }
}

impl From<GeneralStatus> for Failure {
    fn from(general: GeneralStatus) -> Self {
        Self::new(general)
    }
}

/// The reply does not fit: 0x11.
impl From<Full> for Failure {
    fn from(_: Full) -> Self {
        Self::new(GeneralStatus::REPLY_DATA_TOO_LARGE)
    }
}

/// Service data that cannot be read: 0x13 if they are too short, 0x15 if too long, 0x20 if a value is not allowed.
impl From<ParseError> for Failure {
    fn from(error: ParseError) -> Self {
        Self::new(match error.kind {
            ParseErrorKind::Short { .. } => GeneralStatus::NOT_ENOUGH_DATA,
            ParseErrorKind::Trailing { .. } => GeneralStatus::TOO_MUCH_DATA,
            ParseErrorKind::Value { .. } => GeneralStatus::INVALID_PARAMETER,
        })
    }
}

impl From<Failure> for Response<'_> {
    fn from(failure: Failure) -> Self {
        Self::Error { status: failure.general(), additional: failure.additional() }
    }
}

/// The value of a fixed size in the data of a service: 0x13 if the data are shorter, 0x15 if they are longer.
///
/// ```
/// use cip_core::object::{Failure, exact};
///
/// fn interval(value: &[u8]) -> Result<u16, Failure> {
///     Ok(u16::from_le_bytes(exact(value)?))
/// }
/// assert_eq!(interval(&[0x0A, 0x0E]), Ok(3594));
/// assert_eq!(interval(&[0x0A]).unwrap_err().general().0, 0x13);
/// assert_eq!(interval(&[0x0A, 0x0E, 0x00]).unwrap_err().general().0, 0x15);
/// ```
pub fn exact<const N: usize>(value: &[u8]) -> Result<[u8; N], Failure> {
    value.try_into().map_err(|_| wrong_length(value.len(), N))
}

/// The failure of data of `found` bytes that must be `expected` bytes long.
pub(super) fn wrong_length(found: usize, expected: usize) -> Failure {
    Failure::new(if found < expected { GeneralStatus::NOT_ENOUGH_DATA } else { GeneralStatus::TOO_MUCH_DATA })
}

#[cfg(test)]
mod tests {
    use super::*;

    proptest::proptest! {
        #[test]
        fn codes_are_kept(general in 1..=u8::MAX, additional: u8) {
            let failure = Failure::new(GeneralStatus(general)).with_additional(AdditionalCode(additional));
            proptest::prop_assert_eq!(failure.general(), GeneralStatus(general));
            proptest::prop_assert_eq!(failure.additional(), AdditionalCode(additional));
        }
    }

    #[test]
    fn success_is_no_failure() {
        let failure = Failure::from(GeneralStatus::SUCCESS).with_additional(AdditionalCode(7));
        assert_eq!((failure.general(), failure.additional()), (GeneralStatus(1), AdditionalCode(7)));
    }
}
