//! Tests of `diagnosis/src/diagnosis/verdict/few_readings.rs`.

use bmv::diagnosis::Problem;
use bmv::diagnosis::verdict::few_readings::*;
use bmv::document::Diagnostics;
use bmv::effect::Catalogue;
use bmv::measurement::Rows;
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};
use std::sync::Arc;

fn problem() -> Problem {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let request =
        InjectionRequest { only: Some("heat-load".to_owned()), size: Some(5.0), ..InjectionRequest::default() };
    case(&catalogue, &Recipe::of(Topology::Star, TestKind::Steady, request), 1, 0).unwrap().problem
}

fn phases(problem: &mut Problem) -> &mut Vec<bmv::measurement::Phase> {
    match &mut problem.measurements[0].rows {
        Rows::Steady(phases) => phases,
        Rows::Transient { .. } => unreachable!("the recipe is steady"),
    }
}

#[test]
fn data_that_test_little_are_said_to() {
    let whole = problem();
    assert_eq!(warnings(&whole, 5), Vec::<String>::new());
    let count = whole.fitted_readings().len();
    assert!(warnings(&whole, count)[0].starts_with(&format!("{count} readings are fitted with {count} free")));

    let mut one_phase = problem();
    let fitted = one_phase.fitted_readings()[0].row;
    for (row, phase) in phases(&mut one_phase).iter_mut().enumerate() {
        phase.held_out = row != fitted;
    }
    let said = warnings(&one_phase, 0);
    assert!(said.len() == 1 && said[0].starts_with("only one phase is fitted"), "{said:?}");

    let mut still = problem();
    let input = still.model.inputs.iter().position(|input| input.name.starts_with('Q')).unwrap();
    let name = still.model.inputs[input].name.clone();
    let level = phases(&mut still)[0].inputs[input];
    phases(&mut still).iter_mut().for_each(|phase| phase.inputs[input] = level);
    let said = warnings(&still, 0);
    assert!(said.len() == 1 && said[0].contains(&format!("`{name}`")), "{said:?}");
}
