//! The radiator's conventional branch: correlation with the panel's test, and margins put on again, against closed forms.

use std::path::{Path, PathBuf};

use bmv::job::conventional::{self, Basis};
use bmv::job::correlate::{Ended, Output};

use crate::statistics::hand_on::Results;

const SIGMA: f64 = 5.670_374_419e-8;

fn study() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/radiator")
}

fn fourth(t: f64) -> f64 {
    t * t * t * t
}

/// Phases B1, B3 and B5: heater, W; shroud, K; the mean of five sensors and the footprint, K.
const FITTED: [(f64, f64, [f64; 2]); 3] =
    [(60.0, 100.0, [255.658, 267.653]), (120.0, 100.0, [304.778, 328.885]), (100.0, 200.0, [305.749, 326.832])];

/// Measured minus predicted: the panel radiates at one temperature, the footprint is warmer by the heat through `G_s`.
fn deviations(eps: f64, spreading: f64) -> Vec<f64> {
    let of = |(heat, shroud, readings): &(f64, f64, [f64; 2])| {
        let mean = (heat / (eps * 0.3 * SIGMA) + fourth(*shroud)).sqrt().sqrt();
        let footprint = mean + heat / spreading;
        [readings[0] - 0.8 * mean - 0.2 * footprint, readings[1] - footprint]
    };
    FITTED.iter().flat_map(of).collect()
}

fn squares(eps: f64, spreading: f64) -> f64 {
    deviations(eps, spreading).iter().map(|d| d * d).sum()
}

#[test]
fn the_correlations_and_the_margins_put_on_again_are_those_of_closed_forms() {
    let study = study();
    let mut results = Results::of_study(&study);
    let mut correlation =
        |name: &str| -> Output { serde_json::from_value((*results.of("pass-5.json", name)).clone()).unwrap() };
    let (single, all) = (correlation("one at a time"), correlation("least squares"));
    for output in [&single, &all] {
        let [eps, spreading] = [0, 1].map(|place| output.parameters[place].after);
        let rms = (squares(eps, spreading) / 6.0).sqrt();
        assert!((output.after.rmse - rms).abs() < 1e-6, "{} {rms}", output.after.rmse);
        assert_eq!((output.ended, output.after.count), (Ended::Met, 6));
        assert!(output.before.max > 3.0 && output.after.max <= 3.0);
    }
    // No neighbour is better: 1e-4 of a value changes the sum of squares by far more than its last digits.
    let [eps, spreading] = [0, 1].map(|place| all.parameters[place].after);
    for (a, b) in [(1.0001, 1.0), (0.9999, 1.0), (1.0, 1.0001), (1.0, 0.9999)] {
        assert!(squares(a * eps, b * spreading) > squares(eps, spreading));
    }
    assert!(all.after.rmse <= single.after.rmse);
    assert!(single.changes.iter().rev().skip(1).all(|change| !change.met), "it stops where the criteria are met");
    let sizes: conventional::Output =
        serde_json::from_value((*results.of("pass-5.json", "margins least squares")).clone()).unwrap();
    // Nominal inputs, the footprint's limit less the margin: A = Q / (eps sigma (T^4 - 3^4) - absorbed).
    for size in sizes.sizes.iter().filter(|own| own.basis == Basis::Nominal && own.requirement == "electronics") {
        let bmv::study::rule::Margin::TemperatureK(margin) = size.rule.margin else { panic!("{:?}", size.rule) };
        let mean = 308.15 - margin - 100.0 / spreading;
        let sun = 1367.0 * libm::cos(80.0_f64.to_radians()) + 15.0;
        let area = 100.0 / (eps * SIGMA * (fourth(mean) - fourth(3.0)) - 0.2 * sun - eps * 20.0);
        let found = size.size.expect("within the range");
        assert!((found / area - 1.0).abs() < 1e-7, "{}: {found} {area}", size.rule.name);
    }
    // What was correlated is no longer stacked; what was not is, with the prior that it has.
    let stacked: Vec<&str> = sizes.worst_case.iter().map(|end| end.parameter.as_str()).collect();
    assert!(!stacked.contains(&"eps") && !stacked.contains(&"G_s") && stacked.contains(&"alpha"), "{stacked:?}");
}

#[test]
fn sizes_that_look_back_are_those_of_the_earlier_pass() {
    let study = study();
    let mut results = Results::of_study(&study);
    let mut sizes = |file: &str, name: &str| -> conventional::Output {
        serde_json::from_value((*results.of(file, name)).clone()).unwrap()
    };
    let (then, now) = (sizes("pass-1.json", "margins"), sizes("pass-5.json", "isothermal margins"));
    assert_eq!(now.priors_of.as_deref(), Some("pass-1.json"));
    assert_eq!(then.sizes.len(), now.sizes.len());
    for own in &now.sizes {
        let same = |other: &&conventional::Size| other.rule == own.rule && other.basis == own.basis;
        let before = then.sizes.iter().find(same).and_then(|other| other.size).expect("a size");
        // Another model with the same mean: the heat goes through one more conductance.
        assert!((own.size.expect("a size") / before - 1.0).abs() < 1e-6, "{}", own.rule.name);
    }
}
