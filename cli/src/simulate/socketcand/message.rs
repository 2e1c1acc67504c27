//! The commands of a client: `< word word .. >`.

use core::time::Duration;

use link_core::{ExtendedId, Frame, Id, StandardId};

/// One command.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Command {
    Open { channel: String },
    Echo,
    RawMode,
    BcmMode,
    ControlMode,
    Send(Frame),
    Add { every: Duration, frame: Frame },
    Update(Frame),
    Delete(Id),
    Subscribe { every: Duration, id: Id },
    Filter { every: Duration, id: Id, mask: [u8; 8] },
    Unsubscribe(Id),
    Statistics { every: Duration },
}

/// Reads what stands between `<` and `>`; else what is wrong with it.
pub(super) fn parse(text: &str) -> Result<Command, String> {
    let mut words = Words(text.split_ascii_whitespace());
    let name = words.next("a command")?;
    let command = match name {
        "open" => Command::Open { channel: words.next("a bus")?.to_owned() },
        "echo" => Command::Echo,
        "rawmode" => Command::RawMode,
        "bcmmode" => Command::BcmMode,
        "controlmode" => Command::ControlMode,
        "send" => Command::Send(words.frame_or_remote()?),
        "sendrtr" => {
            let (id, dlc) = (words.id()?, words.dlc()?);
            Command::Send(Frame::remote(id, dlc).ok_or("no such remote frame")?)
        }
        "add" => Command::Add { every: words.interval()?, frame: words.frame()? },
        "update" => Command::Update(words.frame()?),
        "delete" => Command::Delete(words.id()?),
        "subscribe" => Command::Subscribe { every: words.interval()?, id: words.id()? },
        "filter" => {
            let (every, id, dlc) = (words.interval()?, words.id()?, words.dlc()?);
            Command::Filter { every, id, mask: words.bytes(dlc)?.0 }
        }
        "unsubscribe" => Command::Unsubscribe(words.id()?),
        "statistics" => Command::Statistics { every: Duration::from_millis(words.number("milliseconds")?) },
        "muxfilter" | "isotpmode" | "isotpconf" | "sendpdu" => {
            return Err(format!("{name} is not supported"));
        }
        _ => return Err(format!("unknown command {}", printable(name))),
    };
    match words.0.next() {
        None => Ok(command),
        Some(word) => Err(format!("{name}: {} is too much", printable(word))),
    }
}

/// What is left of a command.
struct Words<'a>(core::str::SplitAsciiWhitespace<'a>);

impl<'a> Words<'a> {
    fn next(&mut self, what: &str) -> Result<&'a str, String> {
        self.0.next().ok_or_else(|| format!("{what} is missing"))
    }

    fn number(&mut self, what: &str) -> Result<u64, String> {
        let word = self.next(what)?;
        let number = word.parse().ok().filter(|number| is_digits(word) && *number <= MOST);
        number.ok_or_else(|| format!("{} is not a number of {what}", printable(word)))
    }

    /// Seconds and microseconds.
    fn interval(&mut self) -> Result<Duration, String> {
        Ok(Duration::from_secs(self.number("seconds")?) + Duration::from_micros(self.number("microseconds")?))
    }

    /// At most three hexadecimal digits are an 11-bit identifier, more are one of 29 bits.
    fn id(&mut self) -> Result<Id, String> {
        let word = self.next("an identifier")?;
        let bits = u32::from_str_radix(word, 16).ok().filter(|_| is_digits(word));
        let id = match word.len() {
            0..=3 => {
                bits.and_then(|bits| u16::try_from(bits).ok()).and_then(StandardId::new).map(Id::Standard)
            }
            _ => bits.and_then(ExtendedId::new).map(Id::Extended),
        };
        id.ok_or_else(|| format!("{} is not an identifier", printable(word)))
    }

    fn dlc(&mut self) -> Result<u8, String> {
        let word = self.next("a length")?;
        let dlc = u8::from_str_radix(word, 16).ok().filter(|dlc| is_digits(word) && *dlc <= 8);
        dlc.ok_or_else(|| format!("{} is not a length, 0 to 8", printable(word)))
    }

    fn bytes(&mut self, length: u8) -> Result<([u8; 8], usize), String> {
        let (mut data, length) = ([0; 8], usize::from(length));
        for byte in data.iter_mut().take(length) {
            let word = self.next("a data byte")?;
            let value = u8::from_str_radix(word, 16).ok().filter(|_| is_digits(word));
            *byte = value.ok_or_else(|| format!("{} is not a byte", printable(word)))?;
        }
        Ok((data, length))
    }

    fn frame(&mut self) -> Result<Frame, String> {
        let (id, dlc) = (self.id()?, self.dlc()?);
        self.data(id, dlc)
    }

    /// A length that no data follow makes a remote frame, as python-can sends it. One of length 0 cannot be told from a
    /// data frame, and is one.
    fn frame_or_remote(&mut self) -> Result<Frame, String> {
        let (id, dlc) = (self.id()?, self.dlc()?);
        if dlc > 0 && self.0.clone().next().is_none() {
            return Frame::remote(id, dlc).ok_or_else(|| "no such remote frame".to_owned());
        }
        self.data(id, dlc)
    }

    fn data(&mut self, id: Id, dlc: u8) -> Result<Frame, String> {
        let (data, length) = self.bytes(dlc)?;
        Frame::new(id, &data[..length]).ok_or_else(|| "no such frame".to_owned())
    }
}

/// Without the sign that the standard library takes.
fn is_digits(word: &str) -> bool {
    !word.starts_with('+')
}

/// A word of the client, short and safe to send back inside `< >`.
fn printable(word: &str) -> String {
    word.chars().filter(|c| c.is_ascii_graphic() && !matches!(c, '<' | '>')).take(32).collect()
}

/// The greatest number of seconds, milli- or microseconds: a hundred days of the latter.
const MOST: u64 = 8_640_000_000_000;

#[cfg(test)]
mod tests {
    use super::*;
    use link_core::frame::{extended_id, standard_id};

    #[test]
    fn the_examples_of_the_protocol() {
        let short = Id::Standard(standard_id(0x123));
        let long = [0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88];
        let frame = |data: &[u8]| Frame::new(short, data).unwrap();
        let ms20 = Duration::from_millis(20);
        for (text, command) in [
            (" open can0 ", Command::Open { channel: "can0".to_owned() }),
            (
                "add 1 0 123 8 11 22 33 44 55 66 77 88",
                Command::Add { every: Duration::from_secs(1), frame: frame(&long) },
            ),
            ("add 0 20000 123 4 42 42 42 42", Command::Add { every: ms20, frame: frame(&[0x42; 4]) }),
            ("update 123 3 11 22 33", Command::Update(frame(&[0x11, 0x22, 0x33]))),
            ("delete 123", Command::Delete(short)),
            ("send 123 0", Command::Send(frame(&[]))),
            (
                "send 1AAAAAAA 2 1 F1",
                Command::Send(Frame::new(extended_id(0x1AAA_AAAA), &[0x01, 0xF1]).unwrap()),
            ),
            // python-can 4.6, interfaces/socketcand: the data bytes, of which a remote frame has none, joined by spaces.
            ("send 123 2  ", Command::Send(Frame::remote(short, 2).unwrap())),
            ("send 00000123 8  ", Command::Send(Frame::remote(extended_id(0x123), 8).unwrap())),
            ("send 123 0  ", Command::Send(frame(&[]))),
            ("sendrtr 123 2", Command::Send(Frame::remote(short, 2).unwrap())),
            (
                "filter 1 500000 123 1 FF",
                Command::Filter {
                    every: Duration::from_millis(1_500),
                    id: short,
                    mask: [0xFF, 0, 0, 0, 0, 0, 0, 0],
                },
            ),
            ("subscribe 0 0 123", Command::Subscribe { every: Duration::ZERO, id: short }),
            ("unsubscribe 123", Command::Unsubscribe(short)),
            ("statistics 1000", Command::Statistics { every: Duration::from_secs(1) }),
        ] {
            assert_eq!(parse(text), Ok(command), "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_told() {
        for (text, problem) in [
            ("", "a command is missing"),
            ("frobnicate", "unknown command frobnicate"),
            ("isotpmode", "isotpmode is not supported"),
            ("open", "a bus is missing"),
            ("send", "an identifier is missing"),
            ("send 800 0", "800 is not an identifier"),
            ("send +12 0", "+12 is not an identifier"),
            ("send FFFFFFFF 0", "FFFFFFFF is not an identifier"),
            ("send 123 9", "9 is not a length, 0 to 8"),
            ("send 123 2 11", "a data byte is missing"),
            ("add 1 0 123 1", "a data byte is missing"),
            ("send 123 1 100", "100 is not a byte"),
            ("send 123 1 +1", "+1 is not a byte"),
            ("send 123 +1 1", "+1 is not a length, 0 to 8"),
            ("statistics +1", "+1 is not a number of milliseconds"),
            ("send 123 1 11 22", "send: 22 is too much"),
            ("statistics -1", "-1 is not a number of milliseconds"),
            ("add 99999999999999 0 123 0", "99999999999999 is not a number of seconds"),
        ] {
            assert_eq!(parse(text), Err(problem.to_owned()), "{text}");
        }
    }
}
