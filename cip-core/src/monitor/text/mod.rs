//! Explicit messages in words.

mod service;
mod value;

pub use value::ValueText;

use core::fmt::{self, Display, Formatter};

use super::{Explicit, Frag, Vocabulary};
use crate::code::{AdditionalCode, GeneralStatus, ServiceCode};
use crate::text::{Hex, write_decimal, write_hex8, write_prefixed_hex};

impl Explicit<'_> {
    /// Writes the message. `value` is what its span refers to.
    ///
    /// # Errors
    /// When `f` fails.
    pub fn write(
        &self,
        f: &mut Formatter<'_>,
        vocabulary: &Vocabulary,
        is_response: bool,
        value: &[u8],
    ) -> fmt::Result {
        let Some(service) = self.service else {
            return f.write_str(if is_response { "response" } else { "request" });
        };
        self.write_service(f, vocabulary, self.requested.unwrap_or(service))?;
        let text = self.text_of(vocabulary, value);
        if is_response {
            return self.write_answer(f, vocabulary, text, value);
        }
        self.write_target(f, vocabulary)?;
        match text {
            Some(text) => {
                f.write_str(" ")?;
                text.fmt(f)
            }
            None => self.write_raw(f, vocabulary, value),
        }
    }

    /// `: ok`, `: Vendor 12`, `: error 0x16 Object does not exist`; `text` is what the value means.
    ///
    /// # Errors
    /// When `f` fails.
    pub fn write_answer(
        &self,
        f: &mut Formatter<'_>,
        vocabulary: &Vocabulary,
        text: Option<impl Display>,
        value: &[u8],
    ) -> fmt::Result {
        f.write_str(": ")?;
        if let Some(status) = self.status {
            f.write_str("error ")?;
            let additional = self.additional.unwrap_or(AdditionalCode::NONE);
            let name = self.class.and_then(|class| (vocabulary.additional)(class, additional));
            return write_status(f, status, additional, name);
        }
        match text {
            Some(text) => text.fmt(f),
            None if value.is_empty() => f.write_str("ok"),
            None => Hex(value).fmt(f),
        }
    }

    /// The short words of the services that everybody knows by them, else the name, else the number.
    ///
    /// # Errors
    /// When `f` fails.
    pub fn write_service(
        &self,
        f: &mut Formatter<'_>,
        vocabulary: &Vocabulary,
        service: ServiceCode,
    ) -> fmt::Result {
        let name = match (service, self.class) {
            (ServiceCode::ERROR_RESPONSE, _) => Some("response"),
            (service, Some(class)) => (vocabulary.short_service)(class, service),
            (service, None) => service.name(),
        };
        match name {
            Some(name) => f.write_str(name),
            None => service.fmt(f),
        }
    }

    /// ` Identity 1`, ` Connection class`
    ///
    /// # Errors
    /// When `f` fails.
    pub fn write_target(&self, f: &mut Formatter<'_>, vocabulary: &Vocabulary) -> fmt::Result {
        let Some(class) = self.class else { return Ok(()) };
        f.write_str(" ")?;
        (vocabulary.class)(class, f)?;
        match self.instance {
            Some(instance) if instance.is_class() => f.write_str(" class"),
            Some(instance) => {
                f.write_str(" ")?;
                write_decimal(f, instance.0.into())
            }
            None => Ok(()),
        }
    }

    /// The attribute and the bytes of a value whose meaning is not known.
    ///
    /// # Errors
    /// When `f` fails.
    pub fn write_raw(&self, f: &mut Formatter<'_>, vocabulary: &Vocabulary, value: &[u8]) -> fmt::Result {
        if let Some(attribute) = self.attribute {
            f.write_str(" ")?;
            match self.attribute_name(vocabulary) {
                Some(name) => f.write_str(name)?,
                None => attribute.fmt(f)?,
            }
        }
        write_bytes(f, value)
    }

    /// The name of the service.
    #[must_use]
    pub fn service_name(&self, vocabulary: &Vocabulary) -> Option<&'static str> {
        let service = self.service?;
        match self.class.filter(|_| service != ServiceCode::ERROR_RESPONSE) {
            Some(class) => (vocabulary.service)(class, service),
            None => service.name(),
        }
    }

    /// The name of the attribute.
    #[must_use]
    pub fn attribute_name(&self, vocabulary: &Vocabulary) -> Option<&'static str> {
        vocabulary.attribute_name(self.class?, self.instance?, self.attribute?)
    }
}

/// `0x0C Object state conflict, another master owns the connection set`; `name` is what the additional code means.
///
/// # Errors
/// When `f` fails.
pub fn write_status(
    f: &mut Formatter<'_>,
    status: GeneralStatus,
    additional: AdditionalCode,
    name: Option<&str>,
) -> fmt::Result {
    f.write_str("0x")?;
    write_hex8(f, status.0)?;
    if let Some(name) = status.name() {
        f.write_str(" ")?;
        f.write_str(name)?;
    }
    if additional == AdditionalCode::NONE {
        return Ok(());
    }
    f.write_str(", ")?;
    match name {
        Some(name) => f.write_str(name),
        None => {
            f.write_str("additional ")?;
            write_prefixed_hex(f, additional.0.into())
        }
    }
}

/// The data of I/O: those of the frame, of a fragment what it is and its piece, in the last one the `whole` message.
///
/// # Errors
/// When `f` fails.
pub fn write_data(
    f: &mut Formatter<'_>,
    frag: Option<Frag>,
    whole: Option<&[u8]>,
    data: &[u8],
) -> fmt::Result {
    let Some(frag) = frag else { return write_bytes(f, data) };
    f.write_str("  ")?;
    frag.fmt(f)?;
    match whole {
        Some(message) => {
            f.write_str(" completes")?;
            write_bytes(f, message)
        }
        None => write_bytes(f, data.get(1..).unwrap_or_default()),
    }
}

/// ` (restart) (assumed)`: what stands after the words of a reading, if there is anything.
///
/// # Errors
/// When `f` fails.
pub fn write_remarks(f: &mut Formatter<'_>, note: Option<impl Display>, assumed: bool) -> fmt::Result {
    if let Some(note) = note {
        f.write_str(" (")?;
        note.fmt(f)?;
        f.write_str(")")?;
    }
    if assumed { f.write_str(" (assumed)") } else { Ok(()) }
}

/// Two spaces and the bytes, if there are any.
///
/// # Errors
/// When `f` fails.
pub fn write_bytes(f: &mut Formatter<'_>, data: &[u8]) -> fmt::Result {
    if data.is_empty() {
        return Ok(());
    }
    f.write_str("  ")?;
    Hex(data).fmt(f)
}
