//! `model.json`, format `bmv-network/1`: as written, and resolved to SI, indices and parsed expressions.

pub mod form;
pub mod group;
pub mod implied_groups;
mod outside;
pub mod quantity;
pub mod resolve;
pub mod surrogate;
pub mod tabulated;

pub use form::{FORMAT, InputForm, ModelForm, ParameterForm};
pub use group::{Group, GroupForm, Members};
pub use quantity::{QuantityForm, QuantityOrName};
pub use resolve::{InputError, ResolvedModel, Scale, resolve};

use crate::document::written::{check_format, read_document};
use crate::document::{Diagnostics, Node, Schemas, Written, read_file};
pub use crate::document::{Formulas, Prior, PriorForm, name};
use crate::study::folder::Folder;

/// Reads a model file's bytes to its written form, with the tables of couplings that it names in the folder; `name` is
/// what messages show. The tree has their rows as entries.
pub fn read(name: &str, bytes: &[u8], folder: &Folder, diagnostics: &mut Diagnostics) -> Option<(ModelForm, Node)> {
    let tree = read_document(name, bytes, diagnostics)?;
    if !check_format(&tree, FORMAT, diagnostics) {
        return None;
    }
    let tree = tabulated::expanded(tree, folder, diagnostics);
    Some((ModelForm::read(&tree, diagnostics)?, tree))
}

/// The JSON Schema of model files.
pub fn schema() -> serde_json::Value {
    Schemas::document::<ModelForm>("bmv model, bmv-network/1")
}

/// Reads and resolves a model file that stands alone: it names no tables. `None` where there is an error; warnings may
/// stand beside a model.
pub fn load(name: &str, bytes: &[u8], diagnostics: &mut Diagnostics) -> Option<ResolvedModel> {
    let (form, _): (ModelForm, Node) = read_file(name, bytes, FORMAT, diagnostics)?;
    if diagnostics.has_errors() {
        // Fields were misspelt: what follows from them would only repeat it.
        return None;
    }
    resolve(&form, None, diagnostics)
}
