//! Tests of `src/report/known.rs`.

use bmv::random::Distribution;
use bmv::report::known::{Known, Posterior, Rate, stated};

/// A drift that passes know better and better.
fn drift(nominal: f64, posterior: Option<f64>) -> Known {
    let prior = Distribution::Normal { mean: nominal, sd: 1e-6, lower: None, upper: None };
    Known {
        name: "drift".to_owned(),
        unit: "K/s".to_owned(),
        nominal,
        prior: "normal, 0 \u{b1} 1e-6".to_owned(),
        prior_interval: Some([nominal - 2e-6, nominal + 2e-6]),
        posterior: posterior.map(|mean| Posterior {
            job: "tuned".to_owned(),
            mean,
            sd: 1e-8,
            interval: [mean - 2e-8, mean + 2e-8],
        }),
        source: String::new(),
        rate: Some(Rate { unit: "K/s".to_owned(), prior: Some(prior) }),
    }
}

#[test]
fn a_slow_change_is_stated_in_one_unit_in_all_passes() {
    let (first, last) = (drift(0.0, None), drift(4e-6, Some(4e-6)));
    let both = stated(&[&first, &last]);
    assert!(both.iter().all(|own| own.unit == "K/d"), "{both:?}");
    assert_eq!(both[0].prior, "normal, 0 \u{b1} 0.0864");
    assert_eq!(both[1].nominal_text(), "0.3456");
    assert_eq!(both[1].posterior_text(), "0.3456 \u{b1} 0.00086 (0.3439 to 0.3473; tuned)");
    let [low, high] = both[1].prior_interval.expect("a prior");
    assert!((low - 0.1728).abs() < 1e-12 && (high - 0.5184).abs() < 1e-12, "{low} {high}");
    // Alone, the first is smaller.
    assert_eq!(stated(&[&first])[0].unit, "K/yr");
}

#[test]
fn what_is_no_slow_change_stays_as_written() {
    let conductance = Known { unit: "W/K".to_owned(), rate: None, ..drift(4e-6, None) };
    assert_eq!(stated(&[&conductance]), vec![conductance]);
    let fast = drift(0.02, None);
    assert_eq!(stated(&[&fast]), vec![fast]);
}
