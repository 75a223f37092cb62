//! Tests of `diagnosis/src/diagnosis/search.rs`.

use bmv::diagnosis::Settings;
use bmv::diagnosis::engine::{Diagnosis, Remainder, State};
use bmv::document::Diagnostics;
use bmv::effect::Catalogue;
use bmv::random::StreamKey;
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};
use std::sync::Arc;

/// A leader of two effects, one of another place that explains most alone, and a curve.
struct Fixture {
    diagnosis: Diagnosis,
    state: State,
    members: [usize; 2],
    seed: usize,
    curve: usize,
}

fn fixture() -> Fixture {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let request =
        InjectionRequest { only: Some("heat-load".to_owned()), size: Some(5.0), ..InjectionRequest::default() };
    let recipe = Recipe::of(Topology::Star, TestKind::Steady, request);
    let problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
    let of = |effect: &str| problem.candidates.iter().position(|own| own.effect == effect).unwrap();
    let members = [of("heat-load"), of("conductive-path")];
    let seed = of("swapped-channels");
    let curve = of("input-function-load");
    let diagnosis = Diagnosis::new(problem, Settings::default(), StreamKey::new(1, "test", "search"));
    let mut state = diagnosis.screen().unwrap();
    state.refits.truncate(1);
    state.pending.clear();
    Fixture { diagnosis, state, members, seed, curve }
}

impl Fixture {
    /// Adds a fit of a set, whose evidence lies so much above that of nothing.
    fn add(&mut self, effects: &[usize], gain: f64) -> usize {
        let mut refit = self.state.refits[0].clone();
        refit.effects = effects.to_vec();
        refit.log_evidence += gain;
        self.state.refits.push(refit);
        self.state.refits.len() - 1
    }

    fn done(&mut self, place: usize, p: f64) {
        let effects = self.state.refits[place].effects.clone();
        self.state.remainders.push(Remainder { effects, p, leads: Vec::new() });
    }
}

#[test]
#[ignore = "thorough"]
fn a_leader_that_leaves_something_is_set_aside_for_other_beginnings() {
    let mut own = fixture();
    let [first, second] = own.members;
    own.add(&[first], 400.0);
    let alone = own.add(&[own.seed], 100.0);
    let leader = own.add(&[first, second], 500.0);
    own.done(leader, 0.3);
    assert_eq!(own.diagnosis.aside(&own.state, leader), None, "it explains all");
    own.state.remainders.clear();
    own.done(leader, 1e-6);
    assert_eq!(own.diagnosis.aside(&own.state, leader), Some(alone));
    own.done(alone, 1e-6);
    assert_eq!(own.diagnosis.aside(&own.state, leader), None, "what is as large as the leader goes no further");
    own.add(&[own.seed, second], 450.0);
    assert_eq!(own.diagnosis.aside(&own.state, leader), None);
}

#[test]
#[ignore = "thorough"]
fn beside_a_curve_the_best_effects_with_names_are_gone_on_from() {
    let mut own = fixture();
    let [first, second] = own.members;
    let named = own.add(&[first], 100.0);
    let leader = own.add(&[own.curve, second], 500.0);
    own.done(leader, 0.3);
    assert_eq!(own.diagnosis.aside(&own.state, leader), Some(named));
    own.done(named, 1e-6);
    let both = own.add(&[first, second], 300.0);
    assert_eq!(own.diagnosis.aside(&own.state, leader), Some(both));
    own.done(both, 1e-6);
    assert_eq!(own.diagnosis.aside(&own.state, leader), None);
}

#[test]
#[ignore = "thorough"]
fn probable_sets_are_fitted_without_each_of_their_members() {
    let mut own = fixture();
    let [first, second] = own.members;
    let mut pair = [first, second];
    pair.sort_unstable();
    own.add(&[first], 100.0);
    own.add(&pair, 500.0);
    own.add(&[own.seed, second], 300.0);
    own.diagnosis.order_without_members(&mut own.state);
    // The first is there, and the third set is improbable.
    let ordered: Vec<&[usize]> = own.state.pending.iter().map(|request| request.effects.as_slice()).collect();
    assert_eq!(ordered, [[second]]);
}
