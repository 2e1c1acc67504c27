//! The characters of a file.

use super::super::Encoding;
use super::super::diagnostic::{Code, Findings};
use super::super::document::Document;
use super::super::encoding::Characters;
use super::super::span::Span;
use super::super::token::TokenKind;

pub(super) fn check(document: &Document, findings: &mut Findings) {
    let (encoding, bytes) = (document.encoding(), document.bytes());
    let mark = document.tokens().first().filter(|token| token.kind == TokenKind::ByteOrderMark);
    let mark = mark.map_or(Span::at(0), |token| token.span);
    match encoding {
        Encoding::Utf16Le | Encoding::Utf16Be => {
            let message = format_args!("the file is {}; save it as ISO 8859-1", encoding.name());
            findings.add(Code::EncodingUtf16, mark, message);
        }
        Encoding::Utf8 if mark.end > 0 => {
            let message =
                format_args!("the file begins with a byte order mark; save it without, as ISO 8859-1");
            findings.add(Code::ByteOrderMark, mark, message);
        }
        Encoding::Utf8 | Encoding::Ascii | Encoding::Latin1 => {}
    }
    each_kind_once(document, Span { start: mark.end, end: bytes.len() }, findings);
    line_ends(document, findings);
}

/// Reports the first character of each kind that should not be there, and how many there are.
fn each_kind_once(document: &Document, span: Span, findings: &mut Findings) {
    let encoding = document.encoding();
    if encoding == Encoding::Ascii && !document.bytes().iter().any(u8::is_ascii_control) {
        return;
    }
    let kind_of = |character: char, byte: u8| match character {
        char::REPLACEMENT_CHARACTER => Some(0),
        '\t' | '\r' | '\n' | '\u{C}' => None,
        '\u{80}'..='\u{9F}' if encoding == Encoding::Latin1 => Some(1),
        _ if encoding == Encoding::Latin1 && (0x80..=0x9F).contains(&byte) => Some(2),
        control if control.is_control() => Some(1),
        character if encoding == Encoding::Utf8 && !character.is_ascii() => Some(3),
        _ => None,
    };
    let mut found: [Option<(Span, char, usize)>; 4] = [None; 4];
    for located in Characters::of(document.bytes(), span, encoding) {
        let place = Span { start: located.start, end: located.end };
        let byte = place.of(document.bytes()).first().copied().unwrap_or(0);
        let Some(kind) = kind_of(located.character, byte).and_then(|kind: usize| found.get_mut(kind)) else {
            continue;
        };
        let (_, _, count) = kind.get_or_insert((place, located.character, 0));
        *count = count.saturating_add(1);
    }
    let [broken, control, windows, utf8] = found;
    if let Some((span, _, count)) = broken {
        let message = format_args!(
            "bytes that are no character in {}, {count} in all; write the characters again, as ISO 8859-1",
            encoding.name()
        );
        findings.add(Code::BrokenCharacter, span, message);
    }
    if let Some((span, character, count)) = control {
        let code = u32::from(character);
        let message = format_args!("a control character (0x{code:02X}), {count} in all; remove it");
        findings.add(Code::ControlCharacter, span, message);
    }
    if let Some((span, character, count)) = windows {
        let message = format_args!(
            "`{character}` is a character of Windows, not of ISO 8859-1, {count} in all; replace it"
        );
        findings.add(Code::EncodingWindows1252, span, message);
    }
    if let Some((span, character, count)) = utf8 {
        let message = format_args!(
            "`{character}` is written as UTF-8, {count} characters in all; save the file as ISO 8859-1"
        );
        findings.add(Code::EncodingUtf8, span, message);
    }
}

fn line_ends(document: &Document, findings: &mut Findings) {
    let mut ends = document.tokens().iter().filter(|token| token.kind == TokenKind::NewLine);
    let text = |span: Span| span.of(document.bytes()).to_vec();
    let Some(first) = ends.next().map(|token| text(token.span)) else { return };
    if let Some(other) = ends.find(|token| token.span.of(document.bytes()) != first) {
        findings.add(
            Code::MixedLineEnds,
            other.span,
            format_args!("this line ends with other characters than the first; let all lines end alike"),
        );
    }
}
