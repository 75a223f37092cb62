//! Tests of `diagnosis/src/diagnosis/fits/exchange.rs`.

use bmv::diagnosis::fits::exchange::*;
use bmv::diagnosis::{Diagnosis, FitError, Settings};
use bmv::document::Diagnostics;
use bmv::effect::{Catalogue, Site};
use bmv::random::StreamKey;
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};
use std::sync::Arc;

#[test]
#[ignore = "thorough"]
fn an_exchange_of_which_no_model_can_be_made_is_reported_with_its_reason() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let request =
        InjectionRequest { only: Some("heat-load".to_owned()), size: Some(5.0), ..InjectionRequest::default() };
    let recipe = Recipe::of(Topology::Star, TestKind::Steady, request);
    let mut problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
    let is_swap = |candidate: &bmv::effect::Candidate| candidate.effect == "swapped-channels";
    let broken = problem.candidates.iter().position(is_swap).unwrap();
    Arc::make_mut(&mut problem.candidates)[broken].site = Site::Nodes([(0, 1.0)].into());
    let diagnosis = Diagnosis::new(problem.clone(), Settings::default(), StreamKey::new(1, "test", "exchange"));
    let state = diagnosis.screen().unwrap();
    let exchange_search = exchanges(&problem, &state.refits[0], usize::MAX).unwrap();
    assert!(!exchange_search.likeliest.contains(&broken));
    let [(position, why)] = exchange_search.impossible.as_slice() else { panic!("{:?}", exchange_search.impossible) };
    assert!(*position == broken && matches!(why, FitError::Apply(_)), "{why}");
    assert!(state.failed.contains(&(broken, why.to_string())), "{:?}", state.failed);
}
