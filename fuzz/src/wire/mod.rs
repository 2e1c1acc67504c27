//! Byte layouts: what is accepted survives, what is emitted is read back, the rest is refused without a panic.
//!
//! The same bytes are tried in every role: as each wire type, as a request in each body format, as a path in both forms, as
//! fragments, and as a frame; and they feed the generators of structured values. So a vector from a manual is a seed as it
//! stands.

mod bits;
mod bytes;
mod fragments;
mod identifiers;
mod values;

use arbitrary::Unstructured;

/// Checks every law of the byte layouts on `data`.
pub fn run(data: &[u8]) {
    bytes::check(data);
    fragments::check(data);
    identifiers::check(data);
    values::check(&mut Unstructured::new(data)).unwrap_or_default();
    bits::check(&mut Unstructured::new(data)).unwrap_or_default();
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::fs;
    use std::path::Path;

    /// The name behind `for` of every `impl Wire` in the sources of a crate.
    fn implementors(name: &str) -> BTreeSet<String> {
        let mut found = BTreeSet::new();
        search(&Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name).join("src"), &mut found);
        found
    }

    fn search(folder: &Path, found: &mut BTreeSet<String>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                search(&path, found);
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
            ($($Type:ty),*) => { BTreeSet::from([$(bare(stringify!($Type))),*]) };
        }
        assert_eq!(cip_core::for_each_wire_type!(names), implementors("cip-core"));
        assert_eq!(devicenet_core::for_each_wire_type!(names), implementors("devicenet-core"));
        assert_eq!(devicenex_core::for_each_wire_type!(names), implementors("devicenex-core"));
        assert_eq!(powerlink_core::for_each_wire_type!(names), implementors("powerlink-core"));
    }
}
