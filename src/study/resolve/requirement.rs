//! Requirements and environments.

use crate::document::{Amount, Map, code};
use crate::study::pass::RequirementForm;
use crate::study::requirement::{ALL, Environment, Requirement, Statement};

use super::scope::Scope;

/// The requirements in SI.
pub fn requirements(scope: &mut Scope, forms: &Map<RequirementForm>) -> Vec<Requirement> {
    let mut requirements = Vec::new();
    for entry in forms {
        let form = &entry.value;
        if entry.name == ALL {
            let message = "a requirement cannot be called `all`: results call all of them together so";
            scope.error(&code::NAME_UNUSABLE, &entry.name_place, message, "another name");
        }
        let quantity = scope.quantity(&form.quantity);
        let probability = form.probability.value;
        if !(probability > 0.0 && probability <= 1.0) {
            let message = format!("a required probability of {probability}");
            scope.error(&code::REQUIREMENT, &form.probability.place, message, "above 0 and at most 1");
        }
        if form.below.is_none() && form.above.is_none() {
            let message = format!("the requirement `{}` has no limit", entry.name);
            scope.error(&code::REQUIREMENT, &entry.name_place, message, "`below`, `above` or both");
        }
        let Some(quantity) = quantity else { continue };
        let (dimension, sense) = scope.quantity_form(quantity);
        let mut limit = |amount: &Option<Amount>| {
            amount.as_ref().and_then(|amount| amount.si(dimension, None, sense, scope.diagnostics))
        };
        let (below, above) = (limit(&form.below), limit(&form.above));
        if let (Some(below), Some(above), Some(amount)) = (below, above, &form.above)
            && above >= below
        {
            let message = "the quantity would have to lie above its upper limit";
            scope.error(&code::REQUIREMENT, &amount.place, message, "`above` smaller than `below`");
        }
        requirements.push(Requirement { name: entry.name.clone(), quantity, below, above, probability });
    }
    requirements
}

/// What the requirements say.
pub fn statements(forms: &Map<RequirementForm>) -> Vec<Statement> {
    let statement = |name: &String, form: &RequirementForm| Statement {
        requirement: name.clone(),
        text: form.description.clone().unwrap_or_default(),
        source: form.source.clone().unwrap_or_default(),
    };
    forms.iter().map(|entry| statement(&entry.name, &entry.value)).collect()
}

/// The environments, each with a value of every input.
pub fn environments(scope: &mut Scope, forms: &Map<Map<Amount>>) -> Vec<Environment> {
    let mut environments = Vec::new();
    for entry in forms {
        let inputs = super::measurement::base_inputs(scope, &entry.value);
        environments.push(Environment { name: entry.name.clone(), inputs });
    }
    environments
}
