//! Values of parameters as numbers of their unit.
//!
//! ```text
//! engineering value = (actual value + offset) * multiplier * base / divisor
//! ```
//! With descriptor bit 6 the divisor is multiplied by ten to the power of the decimal places (Parameter object, CIP
//! Vol. 1). All of it is computed exactly, and rounded once, to the decimal places.

use core::fmt;
use std::format;

use super::model::Param;
use crate::parameter::ParameterDescriptor;

/// A number with a point: `digits / 10^places`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Decimal {
    /// All digits, as a whole number.
    pub digits: i128,
    /// How many of them stand behind the point.
    pub places: u8,
}

impl fmt::Display for Decimal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let places = usize::from(self.places);
        let sign = if self.digits < 0 { "-" } else { "" };
        if places == 0 {
            return write!(f, "{}", self.digits);
        }
        let digits = format!("{:0width$}", self.digits.unsigned_abs(), width = places.saturating_add(1));
        let (whole, fraction) =
            digits.split_at_checked(digits.len().saturating_sub(places)).unwrap_or_default();
        write!(f, "{sign}{whole}.{fraction}")
    }
}

/// Whether the decimal places are part of the scaling.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Precision {
    /// Only if the parameter says so in bit 6 of its descriptor.
    #[default]
    ByDescriptor,
    /// Always.
    Always,
}

/// The numbers that scale a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Factors {
    /// Multiplier.
    pub multiplier: i128,
    /// Divisor, not 0.
    pub divisor: i128,
    /// Base.
    pub base: i128,
    /// Offset.
    pub offset: i128,
}

impl Factors {
    /// No scaling.
    pub const ONE: Self = Self { multiplier: 1, divisor: 1, base: 1, offset: 0 };
}

impl Param {
    /// The numbers that scale its value. `linked` tells the value of another parameter, where scaling is taken from one;
    /// `None` if it does not, or if the divisor is 0.
    pub fn factors(&self, linked: impl Fn(u16) -> Option<i128>) -> Option<Factors> {
        if !self.descriptor.contains(ParameterDescriptor::SCALING) {
            return Some(Factors::ONE);
        }
        let has_links = self.descriptor.contains(ParameterDescriptor::SCALING_LINKS);
        let [multiplier, divisor, base, offset] = self.scaling.links;
        let scaling = &self.scaling;
        let number = |link: u16, written: Option<i128>, neutral: i128| match link {
            0 => Some(written.unwrap_or(neutral)),
            _ if !has_links => Some(written.unwrap_or(neutral)),
            _ => linked(link),
        };
        let factors = Factors {
            multiplier: number(multiplier, scaling.multiplier.map(Into::into), 1)?,
            divisor: number(divisor, scaling.divisor.map(Into::into), 1)?,
            base: number(base, scaling.base.map(Into::into), 1)?,
            offset: number(offset, scaling.offset.map(Into::into), 0)?,
        };
        (factors.divisor != 0).then_some(factors)
    }

    /// The engineering value of a whole number; `None` if it is too large to compute.
    #[must_use]
    pub fn engineering_value(
        &self,
        actual: i128,
        factors: &Factors,
        precision: Precision,
    ) -> Option<Decimal> {
        if !self.descriptor.contains(ParameterDescriptor::SCALING) {
            return Some(Decimal { digits: actual, places: 0 });
        }
        let places = self.decimal_places;
        let shift = 10_i128.checked_pow(places.into())?;
        let product =
            actual.checked_add(factors.offset)?.checked_mul(factors.multiplier)?.checked_mul(factors.base)?;
        let is_extended = precision == Precision::Always
            || self.descriptor.contains(ParameterDescriptor::EXTENDED_PRECISION);
        // Digits behind the point and the power of ten in the divisor cancel out.
        let numerator = if is_extended { product } else { product.checked_mul(shift)? };
        Some(Decimal { digits: divide_rounding(numerator, factors.divisor)?, places })
    }
}

/// Rounds to the nearest, and from the middle away from zero.
fn divide_rounding(numerator: i128, divisor: i128) -> Option<i128> {
    let is_negative = (numerator < 0) != (divisor < 0);
    let (numerator, divisor) = (numerator.unsigned_abs(), divisor.unsigned_abs());
    let quotient = numerator.checked_div(divisor)?;
    let remainder = numerator.checked_rem(divisor)?;
    let is_upper = remainder >= divisor.checked_sub(remainder)?;
    let rounded = i128::try_from(quotient.checked_add(is_upper.into())?).ok()?;
    Some(if is_negative { rounded.saturating_neg() } else { rounded })
}
