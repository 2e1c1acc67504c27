//! Values of parameters in words: scaled, with their unit, or the text that they stand for.

use std::format;
use std::string::{String, ToString as _};

use super::model::Param;
use super::scaling::{Factors, Precision};
use crate::codec::Reader;
use crate::data_type::{DataType, Value};
use crate::parameter::ParameterDescriptor;

impl Param {
    /// A value in words, as [`text`](Self::text) has it, from its bytes; `None` if they are no value of its type.
    ///
    /// ```
    /// use cip_core::eds::Eds;
    ///
    /// let file = "[Params] Param1 = 0, 6, \"20 0F 24 01 30 01\", 0x0004, 0xC7, 2, \"Speed\", \"Hz\", \"\",
    ///     0, 4000, 0, 1, 10, 1, 0, 0, 0, 0, 0, 1;";
    /// let eds = Eds::parse(file)?;
    /// let speed = eds.param(1).ok_or("no parameter")?;
    /// assert_eq!(speed.text_of_bytes(&[0x57, 0x02], |_| None).as_deref(), Some("59.9 Hz"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn text_of_bytes(&self, bytes: &[u8], linked: impl Fn(u16) -> Option<i128>) -> Option<String> {
        let mut reader = Reader::new(bytes);
        let value = self.data_type?.read(&mut reader).ok()?;
        reader.is_empty().then(|| self.text(&value, linked))
    }

    /// A value in words: `59.9 Hz`, `Hold last state (1)`, `0x05 (Alarm, Warning)`. `linked` tells the values of other
    /// parameters, where scaling is taken from them; where it does not, the value is shown as it is.
    pub fn text(&self, value: &Value<'_>, linked: impl Fn(u16) -> Option<i128>) -> String {
        let Some(actual) = whole_number(value) else { return self.other_text(value, linked) };
        if self.is_bit_string() {
            return self.bits_text(value, actual);
        }
        if let Some(text) = self.text_of(actual) {
            return format!("{text} ({actual})");
        }
        if !self.descriptor.contains(ParameterDescriptor::SCALING) {
            return self.with_units(value.to_string());
        }
        let engineering = self
            .factors(linked)
            .and_then(|factors| self.engineering_value(actual, &factors, Precision::default()));
        match engineering {
            Some(engineering) => self.with_units(engineering.to_string()),
            None => format!("{actual} (not scaled)"),
        }
    }

    /// The same for a piece of an assembly: as many bits as the value has there, the first of them bit `first_bit` of
    /// the parameter.
    pub fn text_of_bits(
        &self,
        actual: u64,
        width: u32,
        first_bit: u16,
        linked: impl Fn(u16) -> Option<i128>,
    ) -> String {
        let is_whole = first_bit == 0 && u32::from(self.size).checked_mul(8) == Some(width);
        if is_whole
            && let Some(bytes) = actual.to_le_bytes().get(..usize::from(self.size))
            && let Some(text) = self.text_of_bytes(bytes, &linked)
        {
            return text;
        }
        if self.is_bit_string() {
            let shifted = actual.checked_shl(first_bit.into()).unwrap_or(0);
            return self.names_of_bits(format!("0x{actual:X}"), shifted);
        }
        if first_bit != 0 {
            return format!("bits {first_bit} and up: 0x{actual:X}");
        }
        let signed = if self.data_type.is_some_and(DataType::is_signed) {
            sign_extended(actual, width)
        } else {
            actual.into()
        };
        match i64::try_from(signed) {
            Ok(value) => self.text(&Value::Lint(value), linked),
            Err(_) => format!("{signed}"),
        }
    }

    /// A real number, a string, a date.
    fn other_text(&self, value: &Value<'_>, linked: impl Fn(u16) -> Option<i128>) -> String {
        let real = match *value {
            Value::Real(real) => f64::from(real),
            Value::Lreal(real) => real,
            _ => return self.with_units(value.to_string()),
        };
        let is_scaled = self.descriptor.contains(ParameterDescriptor::SCALING);
        let engineering = if is_scaled {
            self.factors(linked).and_then(|factors| scaled_real(real, &factors))
        } else {
            None
        };
        let places = usize::from(self.decimal_places.min(MAX_REAL_PLACES));
        match (engineering, places) {
            (None, _) if is_scaled => format!("{value} (not scaled)"),
            (Some(engineering), 0) => self.with_units(format!("{engineering}")),
            (None, 0) => self.with_units(value.to_string()),
            (engineering, _) => self.with_units(format!("{:.places$}", engineering.unwrap_or(real))),
        }
    }

    fn bits_text(&self, value: &Value<'_>, actual: i128) -> String {
        self.names_of_bits(value.to_string(), u64::try_from(actual).unwrap_or(0))
    }

    /// The number, and in parentheses the texts of the bits that are set.
    fn names_of_bits(&self, number: String, bits: u64) -> String {
        let is_set = |bit: i64| {
            u32::try_from(bit).ok().and_then(|bit| bits.checked_shr(bit)).is_some_and(|rest| rest & 1 == 1)
        };
        let mut text = number;
        let mut separator = " (";
        for name in self.texts.iter().filter(|text| is_set(text.value)) {
            text.push_str(separator);
            text.push_str(&name.text);
            separator = ", ";
        }
        if separator == ", " {
            text.push(')');
        }
        text
    }

    fn with_units(&self, mut number: String) -> String {
        let units = self.units.trim();
        if !units.is_empty() {
            number.push(' ');
            number.push_str(units);
        }
        number
    }
}

/// The number in a value of a type that has whole numbers.
#[must_use]
pub fn whole_number(value: &Value<'_>) -> Option<i128> {
    Some(match *value {
        Value::Bool(value) => value.into(),
        Value::Sint(value) => value.into(),
        Value::Int(value) | Value::Itime(value) => value.into(),
        Value::Dint(value) | Value::Ftime(value) | Value::Time(value) => value.into(),
        Value::Lint(value) | Value::Ltime(value) => value.into(),
        Value::Usint(value) | Value::Byte(value) => value.into(),
        Value::Uint(value) | Value::Word(value) | Value::Engunit(value) => value.into(),
        Value::Udint(value) | Value::Dword(value) | Value::Stime(value) => value.into(),
        Value::Ulint(value) | Value::Lword(value) => value.into(),
        Value::Real(_) | Value::Lreal(_) => return None,
        Value::Date(_) | Value::TimeOfDay(_) | Value::DateAndTime { .. } => return None,
        Value::String(_) | Value::String2(_) | Value::StringN { .. } | Value::ShortString(_) => return None,
        Value::Epath(_) | Value::StringI(_) => return None,
    })
}

fn scaled_real(real: f64, factors: &Factors) -> Option<f64> {
    let number = |number: i128| i32::try_from(number).ok().map(f64::from);
    let (multiplier, base) = (number(factors.multiplier)?, number(factors.base)?);
    Some((real + number(factors.offset)?) * multiplier * base / number(factors.divisor)?)
}

fn sign_extended(value: u64, width: u32) -> i128 {
    let Some(unused) = 64_u32.checked_sub(width).filter(|&unused| unused < 64) else { return value.into() };
    let shifted = value.wrapping_shl(unused);
    i128::from(i64::from_le_bytes(shifted.to_le_bytes()).wrapping_shr(unused))
}

/// More digits than a double has mean nothing.
const MAX_REAL_PLACES: u8 = 17;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eds::Eds;
    use proptest::prelude::*;

    fn param(fields: &str) -> Param {
        let eds = Eds::parse(format!("[Params] Param1 = 0,,, {fields};")).unwrap();
        eds.params()[0].clone()
    }

    #[track_caller]
    fn shows(fields: &str, bytes: &[u8], expected: &str) {
        assert_eq!(param(fields).text_of_bytes(bytes, |_| None).as_deref(), Some(expected), "{fields}");
    }

    #[test]
    fn whole_numbers_are_scaled_exactly() {
        // Tenths: one decimal place, divisor 10.
        let tenths = "4, 0xC3, 2, \"\", \"Hz\", \"\", , , , 1, 10, 1, 0, , , , , 1";
        shows(tenths, &[0x57, 0x02], "59.9 Hz");
        shows(tenths, &[0xFF, 0xFF], "-0.1 Hz");
        // Extended precision: 4-20 mA, the offset before the factors, hundredths by the decimal places.
        let current = "0x44, 0xC7, 2, \"\", \"mA\", \"\", , , , 1, 1927, 100, 7712, , , , , 2";
        shows(current, &0_u16.to_le_bytes(), "4.00 mA");
        shows(current, &30_840_u16.to_le_bytes(), "20.01 mA");
        // Thirds are rounded, halves away from zero.
        shows("4, 0xC2, 1, \"\", \"\", \"\", , , , 1, 3, 1, 0, , , , , 3", &[1], "0.333");
        shows("4, 0xC2, 1, \"\", \"\", \"\", , , , 1, 2, 1, 0, , , , , 0", &[0xFF], "-1");
        // Without bit 2 the numbers mean nothing.
        shows("0, 0xC7, 2, \"\", \"ms\", \"\", , , , 1, 10, 1, 0, , , , , 1", &[8, 0], "8 ms");
    }

    #[test]
    fn the_decimal_places_can_always_count() {
        let tenths = param("4, 0xC3, 2, \"\", \"Hz\", \"\", , , , 1, 10, 1, 0, , , , , 1");
        let value = |precision| tenths.engineering_value(599, &tenths.factors(|_| None).unwrap(), precision);
        assert_eq!(value(Precision::ByDescriptor).unwrap().to_string(), "59.9");
        assert_eq!(value(Precision::Always).unwrap().to_string(), "6.0");
    }

    #[test]
    fn what_cannot_be_computed_is_shown_as_it_is() {
        shows("4, 0xC7, 2, \"\", \"x\", \"\", , , , 1, 0, 1, 0, , , , , 1", &[8, 0], "8 (not scaled)");
        shows("4, 0xC7, 2, \"\", \"x\", \"\", , , , 1, 1, 1, 0, , , , , 99", &[8, 0], "8 (not scaled)");
        let linked = param("0x0C, 0xC7, 2, \"\", \"x\", \"\", , , , 1, 1, 1, 0, 0, 7, , , 1");
        assert_eq!(linked.text_of_bytes(&[8, 0], |_| None).unwrap(), "8 (not scaled)");
        let seven = |number| (number == 7).then_some(16);
        assert_eq!(linked.text_of_bytes(&[8, 0], seven).unwrap(), "0.5 x");
    }

    #[test]
    fn other_types() {
        shows(
            "0, 0xCA, 4, \"\", \"bar\", \"\", , , , , , , , , , , , 2",
            &1.236_f32.to_le_bytes(),
            "1.24 bar",
        );
        shows("4, 0xCA, 4, \"\", \"\", \"\", , , , 5, 2, 1, 1, , , , , 0", &1.0_f32.to_le_bytes(), "5");
        shows("0, 0xDA, 1, \"\", \"\", \"\"", b"\x02ab", "\"ab\"");
        assert_eq!(param("0, 0xC7, 2, \"\", \"\", \"\"").text_of_bytes(&[1], |_| None), None);
        assert_eq!(param("0, 0xC7, 2, \"\", \"\", \"\"").text_of_bytes(&[1, 2, 3], |_| None), None);
    }

    #[test]
    fn texts_of_values_and_of_bits() {
        let value = "2, 0xC6, 1, \"\", \"\", \"\"; Enum1 = 0, \"Off\", 0x0A, \"On\"";
        shows(value, &[10], "On (10)");
        shows(value, &[1], "1");
        let bits = "2, 0xD1, 1, \"\", \"\", \"\"; Enum1 = 0, \"Alarm\", 3, \"Warning\"";
        shows(bits, &[0x0B], "0x0B (Alarm, Warning)");
        shows(bits, &[0x02], "0x02");
        assert_eq!(param(bits).text_of_bits(0b10, 2, 2, |_| None), "0x2 (Warning)");
    }

    #[test]
    fn pieces_of_assemblies() {
        let small = param("0, 0xC2, 1, \"\", \"K\", \"\"");
        assert_eq!(small.text_of_bits(0xF, 4, 0, |_| None), "-1 K");
        assert_eq!(small.text_of_bits(0x7F, 8, 0, |_| None), "127 K");
        assert_eq!(small.text_of_bits(0x3, 2, 1, |_| None), "bits 1 and up: 0x3");
        let wide = param("0, 0xC9, 8, \"\", \"\", \"\"");
        assert_eq!(wide.text_of_bits(u64::MAX, 64, 0, |_| None), u64::MAX.to_string());
    }

    proptest! {
        #[test]
        fn scaling_agrees_with_real_arithmetic(
            raw: i16, multiplier in 1..100_u32, divisor in 1..1000_u32, base in 1..100_u32, offset: i16, places in 0..5_u8,
        ) {
            let fields = format!(
                "4, 0xC3, 2, \"\", \"\", \"\", , , , {multiplier}, {divisor}, {base}, {offset}, , , , , {places}"
            );
            let text = param(&fields).text_of_bytes(&raw.to_le_bytes(), |_| None).unwrap();
            let expected = (f64::from(raw) + f64::from(offset)) * f64::from(multiplier) * f64::from(base) / f64::from(divisor);
            let half = 0.5 / 10_f64.powi(places.into());
            prop_assert!((text.parse::<f64>().unwrap() - expected).abs() <= half * 1.000_001 + 1e-9, "{} {}", text, expected);
            prop_assert_eq!(text.split_once('.').map_or(0, |(_, digits)| digits.len()), usize::from(places));
        }
    }
}
