//! pcapng files by hand.

/// A file with these interfaces, by link type and options, and packets, by interface and bytes. All have the time 0.
pub(super) fn file(interfaces: &[(u8, &[u8])], packets: &[(u8, &[u8])]) -> Vec<u8> {
    let section = [0x4D, 0x3C, 0x2B, 0x1A, 1, 0, 0, 0, 255, 255, 255, 255, 255, 255, 255, 255];
    let mut bytes = block(0x0A0D_0D0A, &section);
    for (link_type, options) in interfaces {
        bytes.extend(block(1, &[&[*link_type, 0, 0, 0, 0, 0, 0, 0], *options].concat()));
    }
    for (interface, packet) in packets {
        let length = u32::try_from(packet.len()).unwrap().to_le_bytes();
        let fields = [&[*interface, 0, 0, 0][..], &[0; 8], &length, &length].concat();
        bytes.extend(block(6, &[&fields, *packet].concat()));
    }
    bytes
}

fn block(kind: u32, body: &[u8]) -> Vec<u8> {
    let length = u32::try_from(12 + body.len()).unwrap().to_le_bytes();
    [&kind.to_le_bytes(), &length, body, &length].concat()
}
