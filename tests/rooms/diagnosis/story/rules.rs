//! Tests of `diagnosis/src/diagnosis/story/rules.rs`.

use bmv::diagnosis::story::rules::AskedOfUnseen::{Fall, FallUnlessClear};
use bmv::diagnosis::story::rules::{
    Gain, LawOfStep, Weighed, curve_goes_first, explains_as_much, explains_nearly_as_much, explains_on_both, falls,
    first_likely, least_lead, pays_by, rises, serves_as_well, surface_explains_alike, whole_surface_first,
    with_plainer_ones,
};

/// 95 % of what the other explains, and no larger error on unseen rows; 80 % with a clearly smaller one.
#[test]
fn an_effect_of_plausible_size_has_to_explain_nearly_as_much_and_to_predict_no_worse() {
    assert!(serves_as_well([100.0, 5.9, 1.0], [Some(0.51), Some(0.5)], 5.0));
    assert!(!serves_as_well([100.0, 6.0, 1.0], [Some(0.51), Some(0.5)], 5.0), "94 of 99");
    assert!(serves_as_well([100.0, 20.0, 1.0], [Some(0.6), Some(0.5)], 5.0), "it predicts clearly better");
    assert!(!serves_as_well([100.0, 20.0, 1.0], [Some(0.6), Some(0.5)], 11.0), "but is clearly less probable");
    assert!(!serves_as_well([100.0, 21.0, 1.0], [Some(0.6), Some(0.5)], 5.0), "79 of 99");
    assert!(!serves_as_well([100.0, 20.0, 1.0], [None, None], 5.0));
    assert!(!serves_as_well([100.0, 5.9, 1.0], [Some(0.5), Some(0.6)], 5.0), "it predicts worse");
    assert!(serves_as_well([100.0, 5.9, 1.0], [None, None], 5.0), "nothing is held out");
}

/// By more than 5 % either way; without unseen rows nothing rises, and every step may be taken.
#[test]
fn errors_on_unseen_rows_rise_and_fall_by_more_than_a_twentieth() {
    let of = |after: f64| [Some(1.0), Some(after)];
    assert!(rises(of(1.06)) && !rises(of(1.04)) && !rises(of(0.5)));
    assert!(falls(of(0.95)) && !falls(of(0.96)) && !falls(of(1.2)));
    for none in [[None, Some(1.0)], [Some(1.0), None], [None, None]] {
        assert!(!rises(none) && falls(none), "{none:?}");
    }
    assert!(!falls(of(f64::NAN)));
}

/// The error has to fall, unless the gain is above ten in log odds: then it may stay, of further effects where no other beginning leads further.
#[test]
fn an_effect_pays_where_the_unseen_error_falls_or_its_gain_is_clear() {
    let [same, lower, higher] = [1.01, 0.9, 1.06].map(|after| [Some(1.0), Some(after)]);
    let pays = |log_odds: f64, unseen: [Option<f64>; 2], is_first, asked| {
        pays_by(Gain { log_odds, fitted: 0.0, unseen }, is_first, asked)
    };
    assert!(pays(0.1, lower, true, Fall) && !pays(9.0, same, true, Fall) && pays(11.0, same, true, Fall));
    assert!(!pays(11.0, higher, true, Fall) && !pays(-0.1, lower, true, Fall));
    assert!(pays(0.1, [None, None], true, Fall), "nothing is held out");
    assert!(!pays(11.0, same, false, Fall) && pays(0.1, lower, false, Fall));
    assert!(pays(11.0, same, false, FallUnlessClear) && !pays(9.0, same, false, FallUnlessClear));
    assert!(!pays(11.0, higher, false, FallUnlessClear) && pays(0.1, lower, false, FallUnlessClear));
}

/// Held-out rows may choose a further effect where the fitted rows are indifferent, by less than 1 in their log Bayes factor, not
/// against them, unless they outweigh them clearly; the first effect may be what they show alone.
#[test]
fn a_further_effect_does_not_pay_where_the_fitted_rows_speak_against_it() {
    let by = |fitted: f64| Gain { log_odds: 5.0, fitted, unseen: [Some(1.0), Some(0.7)] };
    assert!(pays_by(by(-0.9), false, Fall) && !pays_by(by(-1.1), false, Fall));
    assert!(!pays_by(by(-1.1), false, FallUnlessClear) && pays_by(by(-1.1), true, Fall));
    let outweighed = |fitted: f64| Gain { log_odds: 11.0, ..by(fitted) };
    assert!(pays_by(outweighed(-2.9), false, Fall) && pays_by(outweighed(-2.9), false, FallUnlessClear));
    assert!(!pays_by(outweighed(-3.1), false, Fall), "nothing outweighs strong evidence");
}

/// Ten times as probable, and the unseen rows speak against it.
#[test]
fn a_step_ends_where_the_unseen_rows_contradict_what_is_far_more_probable() {
    let of = |probability: f64, is_curve: bool, pays: bool| Weighed { probability, is_curve, pays };
    let contradicts = |own: Weighed, other: Weighed| own.is_contradicted([own, other].into_iter());
    let law = of(0.05, false, true);
    assert!(contradicts(law, of(0.6, false, false)));
    assert!(!contradicts(law, of(0.4, false, false)), "it is not far more probable");
    assert!(!contradicts(law, of(0.6, false, true)), "the unseen rows do not speak against it");
    assert!(!contradicts(law, of(0.6, true, false)), "a curve says nothing of a law");
    assert!(contradicts(Weighed { is_curve: true, ..law }, of(0.6, true, false)));
}

/// Half of the squares, of the fitted and of the unseen rows alike.
#[test]
fn what_explains_most_on_fitted_and_unseen_rows_follows_no_errors_of_the_model() {
    // The conductance of a balloon's box by the air's flow, the lag of a thermometer behind a water heater, the same with less on either.
    assert!(explains_on_both([Some(5.54), Some(1.31)], [Some(8.52), Some(2.58)]));
    assert!(explains_on_both([Some(0.68), Some(0.36)], [Some(0.71), Some(0.43)]));
    assert!(!explains_on_both([Some(0.68), Some(0.36)], [Some(0.71), Some(0.51)]));
    assert!(!explains_on_both([Some(0.68), Some(0.49)], [Some(0.71), Some(0.43)]));
    assert!(!explains_on_both([Some(0.68), Some(0.36)], [None, None]), "no unseen rows");
}

/// Nine tenths of the squares on either kind of rows where a temperature is held, 95 % where another takes several inputs.
#[test]
fn a_plain_law_goes_before_what_holds_a_temperature_or_takes_several_inputs() {
    // A printer's bed while it prints: 98 and 94 % of what a conductance does that opens at the level under control.
    let fitted = [Some(5.16), Some(1.05), Some(0.76)];
    assert!(explains_nearly_as_much(fitted, [Some(5.53), Some(1.57), Some(0.83)]));
    assert!(!explains_nearly_as_much(fitted, [Some(5.53), Some(1.95), Some(0.83)]), "89.6 % on the unseen rows");
    assert!(!explains_nearly_as_much([Some(14.6), Some(5.0), Some(1.3)], [None; 3]), "89 % of what a thermostat does");
    assert!(explains_nearly_as_much(fitted, [None; 3]), "no unseen rows");
    assert!(!explains_nearly_as_much([None; 3], [None; 3]));
    assert!(!explains_nearly_as_much([Some(1.0), Some(1.1), Some(1.2)], [None; 3]), "neither explains anything");
    // The same beside a product of the heater's duty and the print.
    assert!(explains_as_much([Some(5.16), Some(1.05), Some(0.83)], [Some(5.53), Some(1.57), Some(1.28)]));
    assert!(!explains_as_much([Some(5.16), Some(1.05), Some(0.83)], [Some(5.53), Some(1.80), Some(1.28)]));
}

/// Ten in log odds, and at most a twentieth more on the unseen rows.
#[test]
fn a_curve_goes_before_laws_that_it_beats_clearly_unless_it_predicts_worse() {
    assert!(curve_goes_first(10.1, [Some(0.5), Some(0.52)]) && curve_goes_first(10.1, [None, None]));
    assert!(!curve_goes_first(9.9, [Some(0.5), Some(0.1)]), "it leads by too little");
    assert!(!curve_goes_first(100.0, [Some(0.5), Some(0.53)]), "the law predicts the unseen rows better");
}

#[test]
fn a_whole_surface_goes_before_a_single_place_and_not_before_another_surface() {
    let law = |log: f64, is_of_group: bool, is_elsewhere: bool| LawOfStep {
        log,
        is_of_group,
        is_elsewhere,
        has_rival_elsewhere: false,
    };
    let single = law(50.0, false, false);
    assert_eq!(whole_surface_first(&[single, law(49.0, false, false), law(45.0, true, false)]), 2);
    assert_eq!(whole_surface_first(&[single, law(45.0, true, true)]), 0, "it lies elsewhere");
    assert_eq!(whole_surface_first(&[single, law(39.0, true, false)]), 0, "it is clearly less probable");
    // Conductors to the air before heat in all panels: neither is a part of the other.
    assert_eq!(whole_surface_first(&[law(50.0, true, true), law(45.0, true, false)]), 0);
    let outdone = LawOfStep { has_rival_elsewhere: true, ..law(45.0, true, false) };
    assert_eq!(whole_surface_first(&[single, outdone]), 0, "what acts elsewhere is far more probable");
    assert_eq!(whole_surface_first(&[single, outdone, law(44.0, true, false)]), 2);
    assert_eq!(whole_surface_first(&[]), 0);
}

#[test]
fn a_set_with_a_whole_surface_displaces_where_one_with_a_place_of_it_would() {
    // A tube bundle: the first pass alone, or all four, beside the lag of the thermometers.
    let errors = [Some(0.1503), Some(0.1575)];
    assert!(surface_explains_alike([4.5, 3.4], errors));
    assert!(!surface_explains_alike([14.5, 3.4], errors), "the place is clearly more probable");
    assert!(!surface_explains_alike([4.5, 3.4], [Some(0.15), Some(0.19)]), "it errs clearly more on unseen rows");
    assert!(surface_explains_alike([4.5, 3.4], [None, None]));
}

/// As a single place goes first at ten in log odds only.
#[test]
fn a_single_place_displaces_a_whole_surface_only_where_it_is_clearly_more_probable() {
    let of_probable =
        [[false, true], [true, false], [true, true], [false, false]].map(|[a, b]| least_lead(a, b, false));
    assert_eq!(of_probable, [10.0, 10.0, 10.0, 0.0]);
    assert_eq!(least_lead(false, true, true), 20.0, "logged heat that was the more probable holds its place longer");
}

#[test]
fn an_unlikely_surface_gives_way_to_the_law_that_is_likely() {
    // A surface that another surface leads by more than ten, and the law that leads all: it goes first, not nothing.
    assert_eq!(first_likely(&[[0.0002, 0.0023], [0.73, 0.73]]), Some(1));
    assert_eq!(first_likely(&[[0.0023, 0.0023], [0.73, 0.73]]), Some(0));
    // Laws far behind what fails on unseen rows give way to what is as probable as that.
    assert_eq!(first_likely(&[[1e-9, 0.2], [1e-9, 0.2], [0.8, 0.8]]), Some(2));
    assert_eq!(first_likely(&[[1e-9, 0.2]]), None);
}

/// Law 3 gives way to 1, that to 2; what would go round ends.
#[test]
fn what_goes_before_a_law_gives_way_in_turn() {
    let before = |law: usize| [None, Some(2), None, Some(1)][law];
    assert_eq!(with_plainer_ones(3, before), [3, 1, 2]);
    assert_eq!(with_plainer_ones(2, before), [2]);
    assert_eq!(with_plainer_ones(0, |law| Some(1 - law)), [0, 1]);
}
