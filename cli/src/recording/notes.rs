//! What a recording tells besides its frames.

/// What a recording tells besides its frames, as far as it was read.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Notes {
    /// Frames that the recorder says it lost: the `DROPCOUNT` lines of `candump -d`, the interface statistics of pcapng.
    pub dropped: u64,
    /// Packets of interfaces of another network than the one that is read, which a pcapng file may hold too. They are skipped.
    pub foreign: u64,
}

impl Notes {
    /// Takes note of a line that candump writes where it lost frames
    /// (`DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)`), and says whether it is one.
    #[cold]
    pub(super) fn take_drop_count(&mut self, line: &[u8]) -> bool {
        let Some(rest) = line.strip_prefix(b"DROPCOUNT: dropped ") else { return false };
        let digits = rest.split(|byte| *byte == b' ').next().unwrap_or_default();
        let frames = core::str::from_utf8(digits).ok().and_then(|digits| digits.parse::<u32>().ok());
        self.dropped = self.dropped.saturating_add(frames.map_or(0, u64::from));
        frames.is_some()
    }
}
