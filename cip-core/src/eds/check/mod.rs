//! What a file must be beyond its fields: characters, structure, and the sections as they refer to one another.

mod assemblies;
mod characters;
mod device;
mod io;
mod params;
pub(super) mod structure;

use super::diagnostic::Findings;
use super::document::Document;
use super::model::Model;

pub(super) fn run(document: &Document, model: &Model, findings: &mut Findings) {
    characters::check(document, findings);
    structure::check(document, findings);
    device::check(document, model, findings);
    io::check(model, findings);
    params::check(model, findings);
    assemblies::check(model, findings);
}
