//! `model.json`, format `bmv-network/1`: as written, and resolved to SI, indices and parsed expressions.

pub mod element;
pub mod form;
pub mod group;
mod implied_groups;
pub mod quantity;
pub mod resolve;

pub use form::{FORMAT, InputForm, ModelForm, ParameterForm};
pub use group::{Group, GroupForm, Members};
pub use quantity::{QuantityForm, QuantityOrName};
pub use resolve::{InputError, ResolvedModel, Scale, resolve};

use crate::document::{Diagnostics, Node, Schemas, read_file};
pub use crate::document::{Formulas, Prior, PriorForm, name};

/// Reads a model file's bytes to its written form; `name` is what messages show.
pub fn read(name: &str, bytes: &[u8], diagnostics: &mut Diagnostics) -> Option<(ModelForm, Node)> {
    read_file(name, bytes, FORMAT, diagnostics)
}

/// The JSON Schema of model files.
pub fn schema() -> serde_json::Value {
    Schemas::document::<ModelForm>("bmv model, bmv-network/1")
}

/// Reads and resolves a model file. `None` where there is an error; warnings may stand beside a model.
pub fn load(name: &str, bytes: &[u8], diagnostics: &mut Diagnostics) -> Option<ResolvedModel> {
    let (form, _) = read(name, bytes, diagnostics)?;
    if diagnostics.has_errors() {
        // Fields were misspelt: what follows from them would only repeat it.
        return None;
    }
    resolve(&form, diagnostics)
}
