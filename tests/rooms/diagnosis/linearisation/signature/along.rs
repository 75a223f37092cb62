//! Tests of `diagnosis/src/diagnosis/linearisation/signature/along.rs`.

use bmv::diagnosis::linearisation::linear::Direction;
use bmv::diagnosis::linearisation::signature::added_node::added;
use bmv::diagnosis::linearisation::signature::along::*;
use bmv::diagnosis::linearisation::signature::form::{Form, Forms};
use bmv::diagnosis::linearisation::signature::{Base, Found, extended, for_each_direction, variant};
use bmv::document::Diagnostics;
use bmv::effect::{Catalogue, Site};
use bmv::inference::target::Target;
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};
use std::sync::Arc;

/// Steps at the rows jump between two of them; the others are within 0.3 %.
const MOST_OFF: f64 = 0.03;
/// A part of some hundred J/K moves the network by kelvins, over which radiation is curved.
const MOST_OFF_OF_NODES: f64 = 0.05;

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

/// What added nodes do along the course is what a model with them does at finite values, but for the network's own curvature.
#[test]
#[ignore = "thorough"]
fn responses_of_added_nodes_are_those_of_a_model_with_them() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let recipe = Recipe::of(Topology::Star, TestKind::Orbit, InjectionRequest::default());
    let problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
    let likelihood = problem.hypothesis(&[], 1.0).unwrap().likelihood(&problem).unwrap();
    let unknowns: Vec<f64> = likelihood.priors().iter().map(|prior| prior.quantile(0.5)).collect();
    let base = Base::new(&problem, &likelihood, &unknowns).unwrap();
    let forms = Forms::new(&problem);
    let courses = Courses::new(&base, &[]).unwrap();
    let last = problem.measurements[0].fitted_rows().next_back().unwrap();
    let fewer: Vec<usize> = (0..last).step_by(3).chain([last]).collect();
    let on_fewer = Courses::new(&base, &[Some(fewer)]).unwrap();
    let (mut singles, mut pairs, mut walls) = (0, 0, 0);
    for position in 0..problem.candidates.len() {
        let Form::Probe { effect } = forms.of(&problem, position) else { continue };
        let Some(added) = added(&base, position, effect) else { continue };
        let id = &problem.candidates[position].id;
        let added = [added];
        let along = courses.directions_of_nodes(&base, &added).remove(0).unwrap();
        let on_fewer = on_fewer.directions_of_nodes(&base, &added).remove(0).unwrap();
        let mut exact: Vec<Direction> = Vec::new();
        for_each_direction(&problem, &likelihood, &unknowns, &[position], &mut |block| exact.extend(block)).unwrap();
        for (rows, along) in [("all", along), ("a third of the", on_fewer)] {
            assert_eq!(along.len(), exact.len(), "{id}");
            for (along, exact) in along.into_iter().map(Direction::on_all_rows).zip(&exact) {
                assert_eq!(along.probe, exact.probe, "{id}");
                let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>().sqrt();
                let size = norm(&mut exact.columns.iter().copied());
                let off = norm(&mut along.columns.iter().zip(&exact.columns).map(|(a, b)| a - b));
                assert!(off < MOST_OFF_OF_NODES * size, "{rows} rows, {id} {:?}: {off} of {size}", along.probe);
            }
        }
        match (&problem.candidates[position].site, effect.name.as_str()) {
            (Site::Nodes(_), _) => singles += 1,
            (Site::Pair(_), _) => pairs += 1,
            (_, "path-capacity") => walls += 1,
            _ => {}
        }
    }
    assert!(singles > 3 && pairs > 3 && walls > 3, "{singles} {pairs} {walls}");
}
