//! Paths as text.

use core::fmt;

use super::{ElectronicKey, Epath, Segment};
use crate::text::{Hex, Quoted, write_decimal, write_hex8};

impl fmt::Display for Epath<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.bytes.is_empty() {
            return f.write_str("empty path");
        }
        let mut segments = self.segments();
        loop {
            let start = segments.reader.offset();
            let Some(segment) = segments.next() else { break };
            if start != 0 {
                f.write_str(" ")?;
            }
            if let Ok(segment) = segment {
                fmt::Display::fmt(&segment, f)?;
                continue;
            }
            f.write_str("malformed ")?;
            fmt::Display::fmt(&Hex(self.bytes.get(start..).unwrap_or_default()), f)?;
        }
        Ok(())
    }
}

impl fmt::Display for Segment<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Port { port, link } => {
                f.write_str("port ")?;
                write_decimal(f, port.into())?;
                f.write_str(" link ")?;
                fmt::Display::fmt(&Hex(link), f)
            }
            Self::Logical { kind, value, .. } => {
                f.write_str(kind.name())?;
                f.write_str(" ")?;
                write_decimal(f, value.into())
            }
            Self::ElectronicKey(key) => fmt::Display::fmt(&key, f),
            Self::Network { subtype, data } => {
                write_byte_label(f, "network 0x", subtype)?;
                f.write_str(": ")?;
                fmt::Display::fmt(&Hex(data), f)
            }
            Self::Symbol(name) | Self::AnsiSymbol(name) => {
                f.write_str("symbol ")?;
                fmt::Display::fmt(&Quoted(name), f)
            }
            Self::ExtendedSymbol(symbol) => {
                write_byte_label(f, "symbol 0x", symbol.format)?;
                f.write_str(": ")?;
                fmt::Display::fmt(&Hex(symbol.data), f)
            }
            Self::Data(data) => {
                f.write_str("data ")?;
                fmt::Display::fmt(&Hex(data), f)
            }
            Self::ConstructedType { code, data } => {
                write_byte_label(f, "type 0x", code)?;
                f.write_str(": ")?;
                fmt::Display::fmt(&Hex(data), f)
            }
            Self::ElementaryType(code) => {
                f.write_str("type ")?;
                fmt::Display::fmt(&code, f)
            }
        }
    }
}

impl fmt::Display for ElectronicKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("key vendor ")?;
        write_decimal(f, self.vendor.0.into())?;
        f.write_str(" type ")?;
        write_decimal(f, self.device_type.0.into())?;
        f.write_str(" product ")?;
        write_decimal(f, self.product_code.into())?;
        f.write_str(" revision ")?;
        write_decimal(f, self.major.into())?;
        f.write_str(".")?;
        write_decimal(f, self.minor.into())?;
        f.write_str(if self.compatible { " or compatible" } else { "" })
    }
}

fn write_byte_label(f: &mut fmt::Formatter<'_>, label: &str, byte: u8) -> fmt::Result {
    f.write_str(label)?;
    write_hex8(f, byte)
}
