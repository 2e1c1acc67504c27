//! Fragmentation once more, with a `Vec` and a count: the tables of CIP Vol. 3, row by row. It shares nothing with the
//! machines.

/// What an explicit connection does with a fragment.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum Explicit {
    /// An acknowledge with this status is due; with it, the message if it is complete.
    Acknowledge(u8, Option<Vec<u8>>),
    /// Nothing is answered.
    Silent,
    /// It belongs to the sender.
    ForSender,
}

/// The receiving side of an explicit connection.
#[derive(Clone, Debug)]
pub(crate) struct ExplicitReceiver {
    limit: usize,
    /// What has arrived, and the count expected next.
    partial: Option<(Vec<u8>, u8)>,
    /// XID and count of the last fragment of the completed message.
    completed: Option<(bool, u8)>,
}

impl ExplicitReceiver {
    pub(crate) const fn new(limit: usize) -> Self {
        Self { limit, partial: None, completed: None }
    }

    pub(crate) const fn is_receiving(&self) -> bool {
        self.partial.is_some()
    }

    pub(crate) const fn remembers_completed(&self) -> bool {
        self.completed.is_some()
    }

    pub(crate) fn received(&self) -> usize {
        self.partial.as_ref().map_or(0, |(bytes, _)| bytes.len())
    }

    /// A complete message, or the end of the connection.
    pub(crate) fn discard(&mut self) {
        (self.partial, self.completed) = (None, None);
    }

    pub(crate) fn forget_completed(&mut self) {
        self.completed = None;
    }

    pub(crate) fn fragment(&mut self, xid: bool, byte: u8, data: &[u8]) -> Explicit {
        let count = byte % 64;
        match byte / 64 {
            3 => Explicit::ForSender,
            0 => {
                self.discard();
                if count != 0 {
                    return Explicit::Silent;
                }
                self.partial = Some((Vec::new(), 0));
                self.append(data)
            }
            kind => match &self.partial {
                Some((_, expected)) if *expected == count && kind == 1 => self.append(data),
                Some((_, expected)) if (count + 1) % 64 == *expected && kind == 1 => {
                    Explicit::Acknowledge(0, None)
                }
                Some((_, expected)) if *expected == count => match self.append(data) {
                    Explicit::Acknowledge(0, _) => {
                        self.completed = Some((xid, count));
                        Explicit::Acknowledge(0, self.partial.take().map(|(bytes, _)| bytes))
                    }
                    refused => refused,
                },
                Some(_) => {
                    self.discard();
                    Explicit::Silent
                }
                None if kind == 2 && self.completed == Some((xid, count)) => Explicit::Acknowledge(0, None),
                None => Explicit::Silent,
            },
        }
    }

    fn append(&mut self, data: &[u8]) -> Explicit {
        let Some((bytes, expected)) = &mut self.partial else { return Explicit::Silent };
        bytes.extend(data);
        *expected = (*expected + 1) % 64;
        if bytes.len() > self.limit {
            self.discard();
            return Explicit::Acknowledge(1, None);
        }
        Explicit::Acknowledge(0, None)
    }
}

/// The pieces of an explicit message: fragmentation byte and bytes. None if it goes unfragmented.
pub(crate) fn explicit_pieces(message: &[u8]) -> Vec<(u8, Vec<u8>)> {
    if message.len() <= 7 {
        return Vec::new();
    }
    pieces(message, 6).map(|(byte, bytes)| (byte, bytes.to_vec())).collect()
}

/// The data fields of an I/O message on a connection that fragments; no message has more than 448 bytes.
pub(crate) fn io_fields(message: &[u8], empty_as_3f: bool) -> Vec<Vec<u8>> {
    match message.len() {
        0 if empty_as_3f => return vec![vec![0x3F]],
        0 => return vec![Vec::new()],
        1..=7 => return vec![[&[0x3F][..], message].concat()],
        _ => {}
    }
    pieces(message, 7).map(|(byte, bytes)| [&[byte][..], bytes].concat()).collect()
}

/// Pieces of so many bytes, each with its fragmentation byte: first, middle or last, and the count, which wraps at 64.
fn pieces(message: &[u8], size: usize) -> impl Iterator<Item = (u8, &[u8])> {
    let last = message.len().div_ceil(size) - 1;
    message.chunks(size).enumerate().map(move |(index, bytes)| {
        let kind = match index {
            0 => 0x00,
            _ if index == last => 0x80,
            _ => 0x40,
        };
        (kind | (index % 64) as u8, bytes)
    })
}

/// The receiving side of an I/O connection that fragments.
#[derive(Clone, Debug)]
pub(crate) struct IoReceiver {
    limit: usize,
    /// What has arrived, and the count expected next.
    partial: Option<(Vec<u8>, u8)>,
}

/// What an I/O connection does with a frame.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum Io {
    /// More must follow.
    Stored,
    /// A whole message.
    Complete(Vec<u8>),
    /// Nothing is left of the message, because it is too long.
    TooLong,
    /// Nothing is left of it, for another reason.
    Discarded,
}

impl IoReceiver {
    pub(crate) const fn new(limit: usize) -> Self {
        Self { limit, partial: None }
    }

    pub(crate) const fn is_receiving(&self) -> bool {
        self.partial.is_some()
    }

    pub(crate) fn discard(&mut self) {
        self.partial = None;
    }

    pub(crate) fn frame(&mut self, field: &[u8]) -> Io {
        let before = self.partial.take();
        let Some((byte, data)) = field.split_first() else { return Io::Complete(Vec::new()) };
        let (kind, count) = (byte / 64, byte % 64);
        let mut message = match (kind, before) {
            (0, _) if count == 0 || count == 63 => Vec::new(),
            (1 | 2, Some((message, expected))) if count == expected => message,
            _ => return Io::Discarded,
        };
        message.extend(data);
        if message.len() > self.limit {
            return Io::TooLong;
        }
        if kind == 2 || (kind == 0 && count == 63) {
            return Io::Complete(message);
        }
        self.partial = Some((message, count + 1));
        Io::Stored
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_example_of_the_explicit_table() {
        // Class 4 instance 0x66 attribute 3, six bytes: ten bytes of body.
        let body = [0x10, 4, 0x66, 3, 1, 2, 3, 4, 5, 6];
        let pieces = explicit_pieces(&body);
        assert_eq!(pieces[0], (0x00, body[..6].to_vec()));
        assert_eq!(pieces[1], (0x81, body[6..].to_vec()));
        let mut receiver = ExplicitReceiver::new(10);
        assert_eq!(receiver.fragment(false, 0x00, &pieces[0].1), Explicit::Acknowledge(0, None));
        assert_eq!(
            receiver.fragment(false, 0x81, &pieces[1].1),
            Explicit::Acknowledge(0, Some(body.to_vec()))
        );
        assert_eq!(receiver.fragment(false, 0x81, &pieces[1].1), Explicit::Acknowledge(0, None));
        assert_eq!(receiver.fragment(true, 0x81, &pieces[1].1), Explicit::Silent);
        let mut short = ExplicitReceiver::new(9);
        assert_eq!(short.fragment(false, 0x00, &pieces[0].1), Explicit::Acknowledge(0, None));
        assert_eq!(short.fragment(false, 0x81, &pieces[1].1), Explicit::Acknowledge(1, None));
    }

    #[test]
    fn the_example_of_the_io_table() {
        let message = [0xA1, 0xA2, 0xA3, 0xA4, 0xA5, 0xA6, 0xA7, 0xA8, 0xA9, 0xAA];
        let fields = io_fields(&message, false);
        assert_eq!(fields[1], [0x81, 0xA8, 0xA9, 0xAA]);
        let mut receiver = IoReceiver::new(10);
        assert_eq!(receiver.frame(&fields[0]), Io::Stored);
        assert_eq!(receiver.frame(&fields[1]), Io::Complete(message.to_vec()));
        assert_eq!(receiver.frame(&fields[1]), Io::Discarded);
    }
}
