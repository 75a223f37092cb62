//! Wrong input: the message, at its place.

use bmv::document::Diagnostics;
use bmv::study::model;

mod docs;
mod effects;
mod expression;
mod figures;
mod model_form;
mod properties;
mod schema;
mod shared;
mod syntax;
mod tabulated;

/// What a model file's text is stated, plain, at most five findings.
fn rendered(text: &str) -> String {
    let mut diagnostics = Diagnostics::new();
    let model = model::load("model.json", text.as_bytes(), &mut diagnostics);
    assert_eq!(model.is_none(), diagnostics.has_errors(), "a model, or an error");
    diagnostics.render(false, 5)
}
mod next_pass;
mod pass_adopt;
mod pass_data;
mod pass_discrepancy;
mod pass_entries;
mod pass_hand_on;
mod pass_inputs;
mod pass_limits;
mod pass_load;
mod pass_physical;
mod pass_plans;
mod pass_sensitivity;
mod pass_study;
