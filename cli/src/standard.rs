//! `-` in the place of a file: standard input or output.

use std::path::Path;

use crate::exit::Failure;

/// Whether a path means standard input or output.
pub(crate) fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// A path in messages; `standard` where it is none.
pub(crate) fn shown(path: &Path, standard: &str) -> String {
    match is_standard(path) {
        true => standard.to_owned(),
        false => path.display().to_string(),
    }
}

/// Refuses files of which several are standard input: the first would leave nothing for the others.
pub(crate) fn at_most_one<'a>(inputs: impl IntoIterator<Item = &'a Path>) -> Result<(), Failure> {
    match inputs.into_iter().filter(|path| is_standard(path)).count() {
        0 | 1 => Ok(()),
        times => Err(Failure::Usage(format!(
            "`-` is given {times} times: standard input can be read once, name files for the others"
        ))),
    }
}
