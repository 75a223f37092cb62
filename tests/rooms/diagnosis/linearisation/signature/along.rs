//! Tests of `diagnosis/src/diagnosis/linearisation/signature/along.rs`.

use bmv::diagnosis::linearisation::signature::along::*;
use bmv::diagnosis::linearisation::signature::form::{Form, Forms};
use bmv::diagnosis::linearisation::signature::{Base, Found, extended, variant};
use bmv::document::Diagnostics;
use bmv::effect::{Catalogue, Site};
use bmv::inference::target::Target;
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};
use std::sync::Arc;

/// Steps at the rows jump between two of them; the others are within 0.3 %.
const MOST_OFF: f64 = 0.03;

/// The responses along the course are those of a model that holds the effects: steps of the rows' length tell them to a few
/// per cent.
#[test]
#[ignore = "thorough"]
fn responses_are_the_sensitivities_of_a_model_with_the_effects() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let recipe = Recipe::of(Topology::Star, TestKind::Orbit, InjectionRequest::default());
    let problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
    let likelihood = problem.hypothesis(&[], 1.0).unwrap().likelihood(&problem).unwrap();
    let unknowns: Vec<f64> = likelihood.priors().iter().map(|prior| prior.quantile(0.5)).collect();
    let base = Base::new(&problem, &likelihood, &unknowns).unwrap();
    let forms = Forms::new(&problem);
    let forms: Vec<(usize, Form<'_>)> = (0..problem.candidates.len())
        .filter(|&position| {
            matches!(problem.candidates[position].site, Site::Nodes(_) | Site::Pair(_) | Site::Elements(_))
        })
        .map(|position| (position, forms.of(&problem, position)))
        .filter(|(_, form)| matches!(form, Form::Smooth { .. }))
        .collect();
    let asked: Vec<(usize, &Form<'_>)> = forms.iter().map(|(position, form)| (*position, form)).collect();
    let variants = variant::variants(&base, &asked);
    let none = || -> Vec<Found> { asked.iter().map(|_| Ok(Vec::new())).collect() };
    let (mut along, mut exact) = (none(), none());
    Courses::new(&base, &[]).unwrap().directions(&base, &variants, &mut along);
    extended::solve(&base, &variants, &mut exact);
    let mut compared = 0;
    for ((along, exact), (position, _)) in along.iter().zip(&exact).zip(&asked) {
        let id = &problem.candidates[*position].id;
        let (Ok(along), Ok(exact)) = (along, exact) else {
            assert_eq!(along.is_ok(), exact.is_ok(), "{id}");
            continue;
        };
        assert_eq!(along.len(), exact.len(), "{id}");
        for (along, exact) in along.iter().zip(exact) {
            assert_eq!(along.parameters, exact.parameters, "{id}");
            let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>().sqrt();
            let size = norm(&mut exact.columns.iter().copied());
            let off = norm(&mut along.columns.iter().zip(&exact.columns).map(|(a, b)| a - b));
            assert!(off < MOST_OFF * size, "{id} {:?}: {off} of {size}", along.shape);
            compared += 1;
        }
    }
    assert!(compared > 1000, "{compared}");
}
