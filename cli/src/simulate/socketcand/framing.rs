//! Cuts what a client says into commands, in whatever pieces it comes.

/// The beginning of a command whose end has not come.
#[derive(Debug, Default)]
pub(super) struct Framing(State);

#[derive(Debug, Default)]
enum State {
    /// The next command has not begun.
    #[default]
    Between,
    /// Rubbish was reported, and goes on up to the next command.
    Skipping,
    /// What came after `<`.
    Inside(Vec<u8>),
}

impl Framing {
    /// Takes a byte, which may complete a command: what stood between `<` and `>`, or what is wrong.
    pub(super) fn take(&mut self, byte: u8) -> Option<Result<String, &'static str>> {
        match (&mut self.0, byte) {
            (state, b'<') => {
                let before = core::mem::replace(state, State::Inside(Vec::new()));
                let is_unfinished = matches!(before, State::Inside(text) if !text.is_empty());
                is_unfinished.then_some(Err("a command ends with >"))
            }
            (State::Between, byte) if byte.is_ascii_whitespace() => None,
            (state @ State::Between, _) => {
                *state = State::Skipping;
                Some(Err("a command begins with <"))
            }
            (State::Skipping, _) => None,
            (State::Inside(text), b'>') => {
                let text = core::mem::take(text);
                self.0 = State::Between;
                Some(Ok(String::from_utf8_lossy(&text).into_owned()))
            }
            (State::Inside(text), byte) if text.len() < LONGEST_COMMAND => {
                text.push(byte);
                None
            }
            (state @ State::Inside(_), _) => {
                *state = State::Skipping;
                Some(Err("the command is too long"))
            }
        }
    }
}

/// The longest is `add` with eight bytes.
const LONGEST_COMMAND: usize = 256;

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(text: &str) -> Vec<Result<String, &'static str>> {
        let mut framing = Framing::default();
        text.bytes().filter_map(|byte| framing.take(byte)).collect()
    }

    #[test]
    fn several_commands_may_come_at_once() {
        let ok = |text: &str| Ok(text.to_owned());
        assert_eq!(cut("< open a >\r\n<echo><>"), [ok(" open a "), ok("echo"), ok("")]);
        assert_eq!(cut("< op"), []);
    }

    #[test]
    fn rubbish_is_reported_once() {
        let echo = || Ok("echo".to_owned());
        assert_eq!(cut("hello > you <echo>"), [Err("a command begins with <"), echo()]);
        assert_eq!(cut("< send 1<<echo>"), [Err("a command ends with >"), echo()]);
        let long = format!("<{}> <echo>", "x".repeat(LONGEST_COMMAND + 1));
        assert_eq!(cut(&long), [Err("the command is too long"), echo()]);
        assert_eq!(cut(&format!("<{}>", "x".repeat(LONGEST_COMMAND)))[0].as_ref().unwrap().len(), 256);
    }
}
