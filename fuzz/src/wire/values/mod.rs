//! Any value of each message: emitted and read back, within exactly the bytes that it says.
//!
//! A wire type without a generator here does not compile.

mod cip;
mod devicenet;
mod devicenex;
mod requests;
mod segments;

use arbitrary::{Result, Unstructured};

/// Makes one value of every message and checks the laws on it.
pub(super) fn check(input: &mut Unstructured<'_>) -> Result<()> {
    macro_rules! cip {
        ($($Type:ty),*) => { $( <$Type as Generated>::check(input)?; )* };
    }
    macro_rules! devicenet {
        ($($Type:ident),*) => { $( <devicenet_core::message::$Type as Generated>::check(input)?; )* };
    }
    macro_rules! devicenex {
        ($($Type:ident),*) => { $( <devicenex_core::message::$Type as Generated>::check(input)?; )* };
    }
    requests::check(input)?;
    segments::check(input)?;
    devicenet_core::for_each_wire_type!(devicenet);
    cip_core::for_each_wire_type!(cip);
    devicenex_core::for_each_wire_type!(devicenex);
    Ok(())
}

/// A type of which values can be made from bytes.
trait Generated {
    /// Makes a value and checks the laws on it.
    fn check(input: &mut Unstructured<'_>) -> Result<()>;
}

/// Implements [`Generated`] by an expression that makes a value from `$input`.
macro_rules! generated {
    ($($Type:ident: |$input:ident| $value:expr;)*) => {$(
        impl super::Generated for $Type<'_> {
            generated!(@check $input, $value);
        }
    )*};
    (owned $($Type:ident: |$input:ident| $value:expr;)*) => {$(
        impl super::Generated for $Type {
            generated!(@check $input, $value);
        }
    )*};
    (@check $input:ident, $value:expr) => {
        fn check($input: &mut Unstructured<'_>) -> Result<()> {
            let mut buffer = [0; super::CAPACITY];
            laws::round_trip(&$value, &mut buffer);
            Ok(())
        }
    };
}
use generated;

/// Up to 31 bytes of free data.
fn free<'a>(input: &mut Unstructured<'a>) -> Result<&'a [u8]> {
    at_most(0x1F, input)
}

/// Up to `most` bytes of free data, which is one less than a power of two.
fn at_most<'a>(most: u8, input: &mut Unstructured<'a>) -> Result<&'a [u8]> {
    let len = usize::from(input.arbitrary::<u8>()? & most).min(input.len());
    input.bytes(len)
}

/// Free data of a whole number of items of `size` bytes.
fn items<'a>(size: usize, input: &mut Unstructured<'a>) -> Result<&'a [u8]> {
    let bytes = free(input)?;
    Ok(&bytes[..bytes.len() / size * size])
}

const CAPACITY: usize = 256;
