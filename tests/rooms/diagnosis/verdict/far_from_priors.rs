//! Tests of `diagnosis/src/diagnosis/verdict/far_from_priors.rs`.

use std::sync::Arc;

use bmv::diagnosis::fits::refit::Begin;
use bmv::diagnosis::verdict::far_from_priors::{end_of_prior, in_words};
use bmv::document::Diagnostics;
use bmv::effect::Catalogue;
use bmv::random::{Distribution, StreamKey};
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};

#[test]
fn a_parameter_far_from_its_prior_is_named_with_its_distance() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let request = InjectionRequest { effects: 0, size: None, ..InjectionRequest::default() };
    let recipe = Recipe::of(Topology::Star, TestKind::Steady, request);
    let mut problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
    let begin = Begin { from_prior: 1, scale: 1.0, ..Begin::default() };
    let refit = problem.refit(&[], &begin, &StreamKey::new(1, "job", "fit")).unwrap();
    assert_eq!(in_words(&problem, &refit), None);
    let index = problem.parameters[0];
    let name = problem.model.parameters[index].name.clone();
    let fitted = refit.by_name()[&name];
    // Twice its median, by a prior that knows it to 7 %: ln 2 / ln 1.07 = 10.2 standard deviations.
    problem.priors[index] = Distribution::LogNormal { median: 0.5 * fitted, factor: 1.07 };
    let words = in_words(&problem, &refit).unwrap();
    assert!(words.contains(&format!("leads `{name}` to ")) && words.contains("10 standard deviations"), "{words}");
    problem.priors[index] = Distribution::LogNormal { median: 0.8 * fitted, factor: 1.07 };
    assert_eq!(in_words(&problem, &refit), None, "ln 1.25 / ln 1.07 = 3.3 standard deviations");

    let unit = problem.model.parameters[index].unit.clone();
    problem.priors[index] = Distribution::Uniform { lower: 0.0, upper: fitted };
    let upper = end_of_prior(&problem, &refit, &name);
    assert!(upper.starts_with("the upper end of its prior, ") && upper.ends_with(&unit), "{upper}");
    problem.priors[index] = Distribution::Uniform { lower: fitted, upper: 9.0 * fitted };
    assert!(end_of_prior(&problem, &refit, &name).starts_with("the lower end of its prior, "));
    problem.priors[index] = Distribution::LogNormal { median: fitted, factor: 1.07 };
    assert_eq!(end_of_prior(&problem, &refit, "another"), "an end of its prior");
}
