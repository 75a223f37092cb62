//! Estimates and their stated errors against the scatter over repeated samples.

use bmv::random::StreamKey;
use bmv::statistics::Moments;
use bmv::statistics::autocorrelation::effective_size_lag_one;
use bmv::statistics::kolmogorov::{p_value, statistic_sorted};
use bmv::statistics::quantile::{quantile_sorted, quantile_standard_error_sorted, sorted};
use bmv::statistics::regression::Line;
fn autoregressive(r: f64, n: usize) -> Vec<f64> {
    let mut stream = StreamKey::new(6, "t", "ar").stream((r * 100.0) as u64);
    let mut x = stream.normal();
    let scale = (1.0 - r * r).sqrt();
    let step = |_| {
        x = r * x + scale * stream.normal();
        x
    };
    (0..n).map(step).collect()
}

#[test]
fn standard_errors_are_the_scatter_over_repetitions() {
    // 400 samples of 50 uniform numbers: scatter of mean and sd against the mean stated error. The scatter itself is known to
    // 1 / sqrt(800) = 3.5 %; four of these.
    let mut stream = StreamKey::new(4, "t", "errors").stream(0);
    let (mut means, mut sds, mut stated) = (vec![], vec![], [0.0; 2]);
    for _ in 0..400 {
        let values: Vec<f64> = (0..50).map(|_| stream.uniform()).collect();
        let m = Moments::of(&values);
        means.push(m.mean());
        sds.push(m.sd());
        stated[0] += m.mean_standard_error() / 400.0;
        stated[1] += m.sd_standard_error() / 400.0;
    }
    assert!((Moments::of(&means).sd() / stated[0] - 1.0).abs() < 0.14);
    assert!((Moments::of(&sds).sd() / stated[1] - 1.0).abs() < 0.14, "{} {}", Moments::of(&sds).sd(), stated[1]);
}

#[test]
fn standard_errors_hold_over_repetitions() {
    let mut stream = StreamKey::new(5, "t", "quantile").stream(0);
    let p = 0.9;
    let (mut found, mut stated) = (vec![], 0.0);
    for _ in 0..400 {
        let values = sorted(&(0..200).map(|_| stream.normal()).collect::<Vec<_>>());
        found.push(quantile_sorted(&values, p));
        stated += quantile_standard_error_sorted(&values, p) / 400.0;
    }
    // Theory: sqrt(p q / n) / density = 0.1209; scatter over 400 repetitions is known to 3.5 %, four of these.
    assert!((stated / 0.1209 - 1.0).abs() < 0.14, "{stated}");
    assert!((Moments::of(&found).sd() / stated - 1.0).abs() < 0.14);
}

#[test]
fn autocorrelated_residuals_widen_the_error_to_the_true_scatter() {
    let mut stream = StreamKey::new(8, "t", "line").stream(0);
    let x: Vec<f64> = (0..400).map(f64::from).collect();
    let (mut slopes, mut plain, mut widened) = (vec![], 0.0, 0.0);
    for _ in 0..300 {
        let mut noise = stream.normal();
        let y: Vec<f64> = x
            .iter()
            .map(|x| {
                noise = 0.7 * noise + stream.normal();
                0.01 * x + noise
            })
            .collect();
        let line = Line::fit(&x, &y).unwrap();
        slopes.push(line.slope);
        plain += line.slope_standard_error / 300.0;
        widened += line.slope_standard_error_autocorrelated(&line.residuals(&x, &y)) / 300.0;
    }
    let scatter = Moments::of(&slopes).sd();
    // The scatter is known to 4 %; the plain error is too small by sqrt(1.7 / 0.3) = 2.4.
    assert!((widened / scatter - 1.0).abs() < 0.17, "{widened} against {scatter}");
    assert!(plain < 0.55 * scatter);
}

#[test]
fn rejects_as_often_as_stated() {
    let mut stream = StreamKey::new(9, "t", "ks").stream(0);
    let rejected = (0..2000)
        .filter(|_| {
            let values = sorted(&(0..40).map(|_| stream.uniform()).collect::<Vec<_>>());
            p_value(statistic_sorted(&values, |x| x), 40) < 0.1
        })
        .count();
    // 200 expected, standard deviation 13.4; four of these and the formula's own error.
    assert!((140..260).contains(&rejected), "{rejected}");
}

#[test]
fn effective_sizes_of_autoregressive_series() {
    // Truth: n (1 - r) / (1 + r). The estimate scatters by some per cent at this length; 20 % is over four deviations.
    for r in [0.0, 0.5, 0.8] {
        let values = autoregressive(r, 20_000);
        let truth = 20_000.0 * (1.0 - r) / (1.0 + r);
        assert!((effective_size_lag_one(&values) / truth - 1.0).abs() < 0.2, "{r}");
    }
}
