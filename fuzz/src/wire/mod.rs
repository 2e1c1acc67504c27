//! Byte layouts: what is accepted survives, what is emitted is read back, the rest is refused without a panic.
//!
//! The same bytes are tried in every role: as each wire type, as a request in each body format, as a path in both forms, as
//! fragments, and as a frame; and they feed the generators of structured values. So a vector from a manual is a seed as it
//! stands.

mod bits;
mod bytes;
mod fragments;
mod values;

use arbitrary::Unstructured;

/// Checks every law of the byte layouts on `data`.
pub fn run(data: &[u8]) {
    bytes::check(data);
    fragments::check(data);
    values::check(&mut Unstructured::new(data)).unwrap_or_default();
    bits::check(&mut Unstructured::new(data)).unwrap_or_default();
}

/// Calls `$each! { Type }` for every type that implements [`Wire`](cip_core::codec::Wire).
macro_rules! for_each_wire_type {
    ($each:ident) => {
        $each! {
            cip_core::message::AllocateRequest
            cip_core::message::AllocateResponse
            cip_core::message::AttributeReplies<'_>
            cip_core::message::AttributeStatusList<'_>
            cip_core::message::CreateResponse<'_>
            cip_core::message::FindNextRequest
            cip_core::message::InstanceList<'_>
            cip_core::message::MemberId
            cip_core::message::MemberRequest<'_>
            cip_core::message::MultipleServicePacket<'_>
            cip_core::message::ReleaseRequest
            cip_core::message::ResetRequest
            cip_core::message::Response<'_>
            cip_core::message::UintList<'_>
        }
    };
}
use for_each_wire_type;

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::fs;
    use std::path::Path;

    /// The name behind `for` of every `impl Wire` in the sources of a crate.
    fn implementors(folder: &Path, found: &mut BTreeSet<String>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                implementors(&path, found);
                continue;
            }
            let source = fs::read_to_string(&path).unwrap();
            found.extend(source.lines().filter_map(|line| {
                let (head, name) = line.split_once(" for ")?;
                (head.starts_with("impl") && head.contains("Wire<'")).then(|| bare(name))
            }));
        }
    }

    /// `cip_core::message::Response<'_>` and `Response<'a> {` are both `Response`.
    fn bare(name: &str) -> String {
        let path = name.split(['<', '{']).next().unwrap();
        path.rsplit("::").next().unwrap().trim().to_owned()
    }

    #[test]
    fn no_wire_type_is_forgotten() {
        macro_rules! names {
            ($($Type:ty)*) => { [$(bare(stringify!($Type))),*] };
        }
        let listed = BTreeSet::from(for_each_wire_type!(names));
        let mut found = BTreeSet::new();
        for name in ["cip-core", "devicenet-core"] {
            implementors(
                &Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name).join("src"),
                &mut found,
            );
        }
        assert_eq!(listed, found);
    }
}
