//! Tests of `core/src/diagnosis/fits/held_out.rs`.

use bmv::diagnosis::fits::held_out::*;
use bmv::diagnosis::output::HeldOutTest;
use bmv::diagnosis::{Diagnosis, Settings};
use bmv::document::Diagnostics;
use bmv::effect::Catalogue;
use bmv::random::StreamKey;
use bmv::twin::{case, dated};
use std::sync::Arc;

#[test]
fn gains_without_a_number_are_no_test() {
    assert_eq!(mean_gain(&[1.0, 3.0]), Some((2.0, Some(1.0))));
    assert_eq!(mean_gain(&[5.0]), Some((5.0, None)), "one block has no standard error");
    // Errors of 10 K by a noise of 1e-154 K.
    assert_eq!((mean_gain(&[]), mean_gain(&[f64::INFINITY, 1.0]), mean_gain(&[1e200, -1e200])), (None, None, None));
}

#[test]
fn errors_that_double_beyond_the_noise_are_bad() {
    // 1.2 to 7.2 K; 1.3 to 2.4 K is less than twice.
    let (doubled, risen) = ([1.2 * 1.2, 7.2 * 7.2], [1.3 * 1.3, 2.4 * 2.4]);
    assert!(is_bad(Some(1e-9), false, doubled) && !is_bad(Some(1e-9), false, risen));
    assert!(!is_bad(Some(0.01), false, doubled), "what the fitted rows leave open is no fault");
    assert!(!is_bad(None, true, doubled) && is_bad(Some(1e-9), true, risen));
}

fn tested(chi_square: f64, readings: u64, p: f64) -> HeldOutTest {
    HeldOutTest {
        gain: 5.0,
        se: Some(2.0),
        blocks: 14,
        chi_square: Some(chi_square),
        readings,
        p: Some(p),
        veto: false,
    }
}

#[test]
fn a_set_that_held_out_rows_reject_yields_to_one_that_predicts_them_unless_the_fitted_rows_say_more() {
    let rejected = tested(330.0, 216, 1e-6);
    assert!(is_outdone(&rejected, &tested(220.0, 216, 0.4), 50.0));
    assert!(!is_outdone(&rejected, &tested(220.0, 216, 0.4), 60.0));
    // Another one that errs as well, or on fewer readings, is no better.
    assert!(!is_outdone(&rejected, &tested(290.0, 216, 5e-4), 2.0));
    assert!(!is_outdone(&rejected, &tested(200.0, 200, 0.4), 2.0));
    // What they do not reject stays, however much better another one is.
    assert!(!is_outdone(&tested(260.0, 216, 0.02), &tested(200.0, 216, 0.8), 2.0));
}

/// The fitted rows prefer a step of the conductance with an input by a factor of a hundred; the held-out rows, where that is the same
/// as at first, still have what the sensor is off by.
#[test]
fn the_held_out_rows_tell_a_sensor_that_jumped_from_a_step_with_an_input() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let mut problem = case(&catalogue, &dated(119), 157, 119).unwrap().problem;
    Arc::make_mut(&mut problem.candidates).retain(|one| {
        one.place == ["battery to stack"] && one.input.as_deref().is_none_or(|input| input == "S_z")
            || one.place == ["battery"] && one.effect.starts_with("dated-")
    });
    let key = StreamKey::new(1, "test", "held out");
    let output = Diagnosis::new(problem, Settings::default(), key).run().unwrap();
    let bias = output.effects.iter().find(|own| own.id == "dated-bias:battery").expect("listed");
    assert_eq!(bias.group, Some(1), "{:?} {:?}", output.words, output.warnings);
    let against = "the held-out rows speak against conductance-step:battery to stack:S_z";
    assert!(output.warnings.iter().any(|warning| warning == against), "{:?}", output.warnings);
}
