//! The solar monitor's flight prediction: how warm the deck may be, before and after calibration.
//!
//! Expected probabilities were computed apart (numpy, 8192 samples, standard error up to 0.006) with one noise draw of
//! another set of readings: 43 phases and three sensors where the study fits 32 phases and five. Another noise draw moves
//! the joints by up to two of their standard deviations, which moves the curve by 0.2 K of deck temperature or up to 0.03
//! in its steepest part. All numbers of the case, the narrower priors of the cooler among them, are reconstructed.

use std::path::Path;

use bmv::job::predict::Output;
use bmv::job::propagate;

use crate::statistics::hand_on::Results;

const ZERO_C: f64 = 273.15;

/// Deck temperature, degC, with the joints' posterior alone, then with the narrower priors of the cooler too.
const EXPECTED: [(f64, f64, f64); 8] = [
    (36.0, 1.000, 1.000),
    (38.0, 0.989, 1.000),
    (39.0, 0.969, 1.000),
    (40.0, 0.930, 1.000),
    (41.0, 0.859, 0.998),
    (42.0, 0.759, 0.968),
    (43.0, 0.642, 0.824),
    (44.0, 0.515, 0.539),
];

fn case(output: &propagate::Output, deck_c: f64) -> &propagate::Case {
    let at = |own: &&propagate::Case| own.design_value.is_some_and(|value| (value - ZERO_C - deck_c).abs() < 1e-6);
    output.cases.iter().find(at).expect("a value of the sweep")
}

fn detector(output: &propagate::Output, deck_c: f64) -> f64 {
    let met = case(output, deck_c).requirements.iter().find(|met| met.requirement == "detector");
    met.expect("the requirement").probability.value
}

fn warmest(output: &propagate::Output) -> f64 {
    let reached = output.reached.iter().find(|own| own.requirement == "detector").expect("the requirement");
    reached.design_value.expect("reached within the sweep") - ZERO_C
}

/// The warmest deck with a normal discrepancy of 1 K on the detector added, to a tenth of a kelvin: the distribution is
/// known at a hundred equally probable values.
fn warmest_with_discrepancy(output: &propagate::Output) -> f64 {
    let met = |deck_c: f64| {
        let quantities = &case(output, deck_c).quantities;
        let cdf = &quantities.iter().find(|q| q.name == "detector temperature").expect("asked for").cdf;
        let share = |value: &f64| bmv::math::special::normal_cdf(ZERO_C - 30.0 - value);
        cdf.iter().map(share).sum::<f64>() / cdf.len() as f64
    };
    let first =
        (20..50).rev().find(|deck_c| met(f64::from(*deck_c)) >= 0.99).map(f64::from).expect("a cold deck passes");
    first + (met(first) - 0.99) / (met(first) - met(first + 1.0))
}

mod nightly {
    use super::*;

    #[test]
    #[ignore = "calibrates the solar monitor, a minute without optimisation"]
    fn calibration_lets_the_deck_be_ten_kelvins_warmer() {
        let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/sxm");
        let mut results = Results::of_study(&study);
        let mut flight =
            |file: &str| -> Output { serde_json::from_value((*results.of(file, "flight")).clone()).unwrap() };
        let (joints, cooler) = (flight("pass-3.json"), flight("pass-4.json"));
        assert!(joints.converged && cooler.converged);
        for (deck_c, with_joints, with_cooler) in EXPECTED {
            for (output, expected) in [(&joints, with_joints), (&cooler, with_cooler)] {
                let found = detector(&output.posterior, deck_c);
                assert!((found - expected).abs() < 0.03, "{deck_c}: {found} {expected}");
            }
        }
        // Tolerances of the case's acceptance check: 30 +/- 1 before, 39 +/- 1.5 with everything.
        let (before, after, known) = (warmest(&joints.prior), warmest(&joints.posterior), warmest(&cooler.posterior));
        assert!((before - 30.0).abs() < 1.0, "{before}");
        assert!((after - 37.5).abs() < 1.0, "{after}");
        assert!((known - 41.0).abs() < 1.0, "{known}");
        let discrepant = warmest_with_discrepancy(&cooler.posterior);
        assert!((discrepant - 39.0).abs() < 1.5, "{discrepant}");
    }

    /// The whole way: a test with discrepancy in its data, the joints calibrated, what is left described sensor by sensor, both
    /// carried to the hot case with the better known cooler. Case study 4.11 expects 39 C with 1 K of scatter in the detector.
    #[test]
    #[ignore = "calibrates the solar monitor, a minute without optimisation"]
    fn the_validated_deck_is_that_of_the_case_with_its_discrepancy() {
        let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/sxm");
        let mut results = Results::of_study(&study);
        let output: bmv::job::discrepancy::Output =
            serde_json::from_value((*results.of("pass-5.json", "unexplained")).clone()).unwrap();
        let find = |name: &str| output.sensors.iter().find(|own| own.sensor == name).expect("a sensor");
        assert_eq!(find("sdd").law, bmv::job::discrepancy::Law::ResidualLaw);
        let scatter = find("sdd").hyperparameters.iter().find(|own| own.name == "scatter").expect("named");
        assert!(scatter.interval.is_some_and(|[lower, upper]| lower < 1.0 && 1.0 < upper), "{scatter:?}");
        let flight: Output = serde_json::from_value((*results.of("pass-5.json", "flight")).clone()).unwrap();
        assert!(flight.converged);
        let validated = flight.validated.as_ref().expect("a discrepancy");
        let (before, calibrated, after) =
            (warmest(&flight.prior), warmest(&validated.without), warmest(&flight.posterior));
        // The priors of the cooler are the narrower ones before, too.
        assert!((before - 30.0).abs() < 1.5 && (calibrated - 41.0).abs() < 1.0, "{before} {calibrated}");
        assert!((after - 39.0).abs() < 1.5, "{after}");
        // The calibration is too sure of two joints; inferred together with the discrepancies all three hold the truth.
        let together: bmv::job::discrepancy::Output =
            serde_json::from_value((*results.of("pass-5.json", "together")).clone()).unwrap();
        assert!(together.converged, "{:?}", together.findings);
        for ((name, truth), (own, mean)) in
            crate::verification::monitor_campaign::TRUTH.iter().zip(together.parameters.iter().zip(&together.means))
        {
            let alone = (mean - own.shift - truth).abs() / own.sd;
            assert!(
                own.name == *name && (mean - truth).abs() < 1.96 * own.free_sd && own.is_confounded,
                "{own:?} {mean}"
            );
            assert_eq!(alone > 1.96, *name != "Gh", "{name}: {alone}");
        }
        // The chamber had neither sun nor cold space: every case is an extrapolation, in these two.
        for term in &validated.terms {
            let outside: Vec<&str> = term.outside.iter().map(|own| own.input.as_str()).collect();
            assert_eq!(outside, ["q_sun", "T_sky"]);
        }
    }
}
