//! The laws of a wire type as assertions, for the unit tests, property tests and fuzz targets of this and other
//! crates. They need neither `std` nor `alloc`: the caller lends the buffer.

use core::fmt::Debug;

use super::{Full, ParseError, Tail, Wire, Writer};

/// Emits `value` into `buffer` and checks every law of [`Wire`] on the result, which is returned.
///
/// `buffer` must be at least one byte longer than the message.
#[track_caller]
pub fn round_trip<'a, T>(value: &T, buffer: &'a mut [u8]) -> &'a [u8]
where
    T: Wire<'a> + PartialEq + Debug,
{
    round_trip_by(value, T::TAIL, buffer, T::parse, T::emit, T::wire_len)
}

/// As [`round_trip`], for a type whose layout depends on a context that the functions carry.
#[track_caller]
pub fn round_trip_by<'a, T, E>(
    value: &T,
    tail: Tail,
    buffer: &'a mut [u8],
    parse: impl Fn(&'a [u8]) -> Result<T, ParseError>,
    emit: impl Fn(&T, &mut Writer<'_>) -> Result<(), E>,
    wire_len: impl Fn(&T) -> usize,
) -> &'a [u8]
where
    T: PartialEq + Debug,
    E: PartialEq + Debug + From<Full>,
{
    let len = wire_len(value);
    assert!(len < buffer.len(), "the buffer must have room for {len} bytes and one more");
    for short in 0..len {
        let mut writer = Writer::new(buffer.get_mut(..short).unwrap_or_default());
        assert_eq!(emit(value, &mut writer), Err(E::from(Full)), "emit into {short} of {len} bytes");
    }
    buffer.fill(UNWRITTEN);
    let mut writer = Writer::new(buffer);
    assert_eq!(emit(value, &mut writer), Ok(()), "emit {value:?}");
    assert_eq!(writer.len(), len, "emit writes wire_len bytes of {value:?}");

    let buffer: &'a [u8] = buffer;
    let (bytes, after) = buffer.split_at_checked(len).unwrap_or_default();
    assert!(after.iter().all(|&byte| byte == UNWRITTEN), "emit writes past its end");
    assert_eq!(parse(bytes).as_ref(), Ok(value), "parse(emit(x)) == x, of {bytes:02X?}");
    if tail == Tail::Closed {
        for short in 0..len {
            let prefix = bytes.get(..short).unwrap_or_default();
            assert!(parse(prefix).is_err(), "the first {short} bytes of {bytes:02X?} must be refused");
        }
        let longer = buffer.get(..len.saturating_add(1)).unwrap_or_default();
        assert!(parse(longer).is_err(), "a byte after {bytes:02X?} must be refused");
    }
    bytes
}

/// Parses `bytes`, which may be anything, and demands that what is accepted is emitted again byte for byte,
/// and that no strict prefix of a closed type is accepted. Returns whether it was accepted.
#[track_caller]
pub fn accepted_bytes_survive<'a, T>(bytes: &'a [u8], buffer: &mut [u8]) -> bool
where
    T: Wire<'a> + Debug,
{
    let Ok(value) = T::parse(bytes) else {
        return false;
    };
    let mut writer = Writer::new(buffer);
    assert_eq!(value.emit(&mut writer), Ok(()), "emit {value:?}");
    assert_eq!(writer.written(), bytes, "emit(parse(b)) == b, of {value:?}");
    assert_eq!(value.wire_len(), bytes.len(), "wire_len of {value:?}");
    if T::TAIL == Tail::Closed {
        for short in 0..bytes.len() {
            let prefix = bytes.get(..short).unwrap_or_default();
            assert!(T::parse(prefix).is_err(), "the first {short} bytes of {bytes:02X?} must be refused");
        }
    }
    true
}

/// A byte that no emit leaves behind by accident: an unwritten gap inside a message shows.
const UNWRITTEN: u8 = 0xA5;

/// How a value of each wire type is made, for tests with `proptest`: a type of a list without one makes the list of tests
/// incomplete, which [`frame_laws!`](crate::frame_laws) does not compile.
#[doc(hidden)]
#[macro_export]
macro_rules! samples {
    ($($Type:ident $(<$life:lifetime>)? = $strategy:expr;)*) => {
        trait Sample: Sized + core::fmt::Debug {
            fn strategy() -> proptest::strategy::BoxedStrategy<Self>;
        }

        $(
            impl Sample for $Type $(<$life>)? {
                fn strategy() -> proptest::strategy::BoxedStrategy<Self> {
                    proptest::strategy::Strategy::boxed($strategy)
                }
            }
        )*
    };
}

/// A test of the laws for each wire type that is the data of a CAN frame, by a sample of it, and by the bytes that
/// `near_messages` of the caller makes.
#[doc(hidden)]
#[macro_export]
macro_rules! frame_laws {
    ($($Type:ident),*) => {
        proptest::proptest! {
            $(
                #[test]
                #[expect(non_snake_case, reason = "named after the type")]
                fn $Type(value in $Type::strategy(), bytes in near_messages()) {
                    let mut buffer = [0; 16];
                    let emitted = $crate::codec::laws::round_trip(&value, &mut buffer);
                    proptest::prop_assert!(emitted.len() <= $crate::Frame::MAX_DATA, "it fits into a frame");
                    $crate::codec::laws::accepted_bytes_survive::<$Type>(&bytes, &mut [0; 16]);
                }
            )*
        }
    };
}
