//! Electronic Data Sheets. Whatever a file holds, it is read, written as it was, and judged with places that lie in it; what can
//! be made of it agrees with it.

use cip_core::eds::{Diagnostic, Document, Eds, MAX_DIAGNOSTICS};
use cip_core::scan::IoTypes;

/// Reads `data` as an Electronic Data Sheet, and once more without its last byte and behind a byte order mark.
pub fn run(data: &[u8]) {
    let Ok(eds) = Eds::parse(data) else { panic!("{} bytes are not too many", data.len()) };
    lossless(eds.document(), data);
    tiled(eds.document(), data.len());
    placed(&eds, data);
    values(&eds, data);
    scan_entry(&eds);
    if let Some((_, shorter)) = data.split_last() {
        lossless(Eds::parse(shorter).expect("shorter still").document(), shorter);
    }
    let text: String = data.iter().map(|&byte| char::from(byte)).collect();
    let wide: Vec<u8> = [0xFEFF].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let wide_eds = Eds::parse(wide.clone()).expect("not too long");
    lossless(wide_eds.document(), &wide);
    // In ASCII both are the same text.
    if data.is_ascii() {
        assert_eq!(wide_eds.params().len(), eds.params().len());
        assert_eq!(wide_eds.device().product_code, eds.device().product_code);
        assert_eq!(wide_eds.document().tokens().len(), eds.document().tokens().len() + 1);
    }
}

fn lossless(document: &Document, data: &[u8]) {
    let mut written = Vec::new();
    document.write(&mut written);
    assert_eq!(written, data, "what is written is what was read");
}

/// The words follow one another without a gap, and entries and fields lie in order within.
fn tiled(document: &Document, len: usize) {
    let mut at = 0;
    for token in document.tokens() {
        assert_eq!(token.span.start, at);
        assert!(token.span.end > at, "no word is empty");
        at = token.span.end;
    }
    assert_eq!(at, len);
    let mut at = 0;
    for entry in document.sections().iter().flat_map(|section| &section.entries) {
        assert!(at <= entry.span.start && entry.span.start <= entry.span.end && entry.span.end <= len);
        at = entry.span.end;
        assert!(!entry.fields.is_empty(), "an entry has a field");
        let mut inside = entry.span.start;
        for field in &entry.fields {
            assert!(inside <= field.span.start && field.span.start <= field.span.end);
            assert!(field.span.end <= entry.span.end);
            inside = field.span.end;
        }
    }
}

/// Findings have their order and a place within the file, and the same file has the same.
fn placed(eds: &Eds, data: &[u8]) {
    let found = eds.diagnostics();
    assert!(found.len() <= MAX_DIAGNOSTICS);
    assert!(found.is_sorted_by_key(|found| (found.span.start, found.code)));
    for Diagnostic { span, place, message, .. } in found {
        assert!(span.start <= span.end && span.end <= data.len(), "{message}");
        let line = eds.document().line(place.line);
        assert!(line.start <= span.start && span.start <= line.end.max(line.start), "{message}");
        let len = eds.document().text(line).chars().count();
        // A byte order mark has no column.
        assert!((1..=len + 2).contains(&place.column), "{message}");
        assert!(!message.is_empty() && !message.contains('\n'), "{message}");
    }
    assert_eq!(Eds::parse(data).expect("as before").diagnostics(), found);
}

/// Values are put in words; layouts are in order, and members of it can be read from data of any length.
fn values(eds: &Eds, data: &[u8]) {
    for param in eds.params().iter().take(MOST) {
        let head = &data[..data.len().min(usize::from(param.size))];
        let _ = param.text_of_bytes(head, |_| Some(-1));
        let _ = param.text_of_bits(u64::MAX, 5, 3, |_| None);
        for constant in [&param.minimum, &param.maximum, &param.default].into_iter().flatten() {
            let _ = param.text_of_constant(constant);
        }
    }
    for assembly in eds.assemblies().iter().take(MOST) {
        let Some(slots) = eds.layout(assembly) else { continue };
        for slot in slots.iter().take(MOST) {
            let value = slot.value_in(data);
            if let (Some(value), Some(bytes)) = (value, slot.bytes_in(data)) {
                let mut whole = [0; 8];
                whole[..bytes.len()].copy_from_slice(bytes);
                assert_eq!(value, u64::from_le_bytes(whole), "bits and bytes agree");
            }
        }
        if !assembly.path.is_empty() {
            assert!(assembly.target().is_none_or(|target| {
                target.class.is_none() || eds.assembly_at(&assembly.path).is_some()
            }));
        }
    }
}

/// What a master gets is what the file has.
fn scan_entry(eds: &Eds) {
    let Ok(entry) = eds.scan_entry() else { return };
    let io = eds.io_info().expect("connections come from it");
    assert!(!entry.default.is_empty());
    assert_eq!(entry.default_connections().count(), entry.default.iter().count());
    assert_eq!(entry.connections.len(), io.connections.len());
    assert!(IoTypes::all().contains(entry.default));
    for connection in &entry.connections {
        let input = io.connection(connection.ty).expect("the same").input;
        let size = input.and_then(|number| io.input(number)).map_or(0, |data| data.size);
        assert_eq!(connection.produced.size, size);
    }
}

/// A file can have more parameters than there is time to look at twice.
const MOST: usize = 256;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_and_pieces_of_it() {
        let file = include_bytes!("../../../tests/eds/block.eds");
        run(file);
        for end in (0..file.len()).step_by(97) {
            run(&file[..end]);
        }
    }

    #[test]
    fn bytes_that_are_no_file() {
        for bytes in
            [&b""[..], b"\xEF\xBB\xBF", b"\xFF\xFE[", b"[\x93a\x94]=\"", b"\r\n\r[", b"\xFE\xFF\xD8\x00;"]
        {
            run(bytes);
        }
    }
}
