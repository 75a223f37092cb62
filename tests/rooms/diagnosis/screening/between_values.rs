//! Tests of `diagnosis/src/diagnosis/screening/between_values.rs`.

use bmv::diagnosis::{Diagnosis, Settings};
use bmv::document::Diagnostics;
use bmv::effect::Catalogue;
use bmv::measurement::Rows;
use bmv::random::StreamKey;
use bmv::twin::{case, dated};
use std::sync::Arc;

/// All effects are tried at dates 24 minutes apart, in 6 hours of rows to fit. The parameters take up what the jump of a sensor does,
/// but for the rows near it: twelve minutes off, it explains less than many other effects do.
#[test]
#[ignore = "thorough"]
fn a_jump_that_the_parameters_nearly_take_up_leads_with_its_date() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let drawn = case(&catalogue, &dated(227), 157, 227).unwrap();
    let hidden = &drawn.truth.effects[0];
    let date_s = hidden.parameters.iter().find(|one| one.name == "date").unwrap().value;
    let Rows::Transient { inputs, .. } = &drawn.problem.measurements[0].rows else { panic!("a transient") };
    let row_s = inputs.times_s[1] - inputs.times_s[0];
    let diagnosis = Diagnosis::new(drawn.problem.clone(), Settings::default(), StreamKey::new(1, "test", "dates"));
    let state = diagnosis.screen().unwrap();
    let lead = &state.screening.leads[0];
    assert_eq!(drawn.problem.candidates[lead.candidate].id, hidden.id);
    let found_s = lead.starts[0][&format!("{}.date", hidden.id)];
    assert!((found_s - date_s).abs() < 2.0 * row_s, "{found_s} {date_s}");
}
