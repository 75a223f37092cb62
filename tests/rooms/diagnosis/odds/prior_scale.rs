//! Tests of `diagnosis/src/diagnosis/odds/prior_scale.rs`.

use bmv::diagnosis::odds::prior_scale::*;
use bmv::math::cholesky;
use bmv::math::functions::ln;

/// Two amplitudes with unit normal priors, each read once with noise and once together: the covariance and mode are those
/// of the normal equations, and the evidences are the readings' normal densities.
#[test]
fn the_gain_is_the_ratio_of_normal_densities() {
    use nalgebra::{Matrix2, Matrix3, Matrix3x2, Vector2, Vector3};
    let x = Matrix3x2::new(30.0, 0.0, 0.0, 20.0, 10.0, 10.0);
    let read = Vector3::new(0.9, 0.4, 0.1);
    let density = |widths: [f64; 2]| {
        let widths = Matrix2::from_diagonal(&Vector2::from(widths));
        let spread = widths * widths;
        let covariance = Matrix3::identity() + x * spread * x.transpose();
        let inverse = covariance.try_inverse().expect("positive");
        -0.5 * ((read.transpose() * inverse * read)[0] + ln(covariance.determinant()))
    };
    let covariance = (Matrix2::identity() + x.transpose() * x).try_inverse().expect("positive");
    let mode = covariance * x.transpose() * read;
    let mut factor: Vec<f64> = covariance.as_slice().to_vec();
    cholesky::factor(&mut factor, 2).expect("positive");
    let amplitudes = Amplitudes { effects: vec![0, 1], away: mode.as_slice().to_vec(), factor: Some(factor) };
    for widths in [[0.1, 1.0], [0.1, 0.01], [10.0, 1.0], [10.0, 0.1], [100.0, 10.0], [1.0, 1.0]] {
        let (own, exact) = (amplitudes.gain(&widths), density(widths) - density([1.0, 1.0]));
        assert!((own - exact).abs() < 1e-10, "{widths:?}: {own} {exact}");
    }
    let best = [1.0, 0.1, 0.01].into_iter().zip([1.0, 0.3, 0.09]);
    let pairs = best.clone().flat_map(|a| best.clone().map(move |b| (a, b)));
    let most = pairs.map(|(a, b)| density([a.0, b.0]) - density([1.0, 1.0]) + ln(a.1 * b.1)).fold(0.0, f64::max);
    assert!(most > 0.5 && (amplitudes.narrower(&[0, 0]) - most).abs() < 1e-10, "{most}");
    assert_eq!(amplitudes.narrower(&[1, 1]), 0.0, "what is wider is not narrower");
}

#[test]
fn a_large_fault_of_a_sensor_is_less_probable_than_a_large_effect_on_hardware() {
    let (written, implausible) = (WIDTHS[0], WIDTHS[IMPLAUSIBLE]);
    assert_eq!([written.log_odds(true), written.log_odds(false)], [0.0; 2]);
    let [of_sensors, of_hardware] = [implausible.log_odds(true), implausible.log_odds(false)];
    assert!((of_sensors - ln(1e-4)).abs() < 1e-12 && (of_hardware - ln(0.01)).abs() < 1e-12);
}

/// A change of 5 that is known within 1, where the written standard deviation is 1: ten times that pays most.
#[test]
fn a_prior_that_began_too_wide_narrows_to_what_is_found() {
    let at = |scale: f64| {
        let prior = scale * scale;
        let (mean, variance) = (5.0 * prior / (prior + 1.0), prior / (prior + 1.0));
        Amplitudes { effects: vec![0], away: vec![mean / scale], factor: Some(vec![variance.sqrt() / scale]) }
    };
    let mut place = WIDTHS.len() - 1;
    loop {
        let next = at(WIDTHS[place].factor).less_wide(&[place])[0];
        if next == place {
            break;
        }
        place = next;
    }
    assert_eq!(WIDTHS[place].factor, 10.0);
    assert_eq!(at(1.0).less_wide(&[0]), [0], "the written width is the least");
}

/// A load of 350 W that is known within 20 W, where the catalogue's scale is 1 W: a hundred times that is still too narrow.
#[test]
fn a_prior_widens_until_it_holds_what_is_found() {
    // The posterior of normal data and a normal prior, in the prior's standard deviations.
    let at = |scale: f64| {
        let (data, prior) = (20.0 * 20.0, scale * scale);
        let (mean, variance) = (350.0 * prior / (prior + data), data * prior / (prior + data));
        Amplitudes { effects: vec![0], away: vec![mean / scale], factor: Some(vec![variance.sqrt() / scale]) }
    };
    let mut place = 0;
    loop {
        let next = at(WIDTHS[place].factor).wider(&[place], 0.0)[0];
        if next == place {
            break;
        }
        place = next;
    }
    assert_eq!(WIDTHS[place].factor, 1000.0);
    assert_eq!(at(1.0).wider(&[WIDTHS.len() - 1], 0.0), [WIDTHS.len() - 1], "there is none beyond the widest");
}

#[test]
fn what_no_data_see_has_no_width() {
    let unseen = Amplitudes { effects: vec![0], away: vec![0.0], factor: Some(vec![1.0]) };
    assert!(unseen.gain(&[10.0]).abs() < 1e-12 && unseen.gain(&[0.1]).abs() < 1e-12);
    assert_eq!((unseen.wider(&[0], 0.0), unseen.narrower(&[0])), (vec![0], 0.0));
    let none = Amplitudes { effects: Vec::new(), away: Vec::new(), factor: Some(Vec::new()) };
    assert_eq!((none.wider(&[0], 0.0), none.narrower(&[0])), (vec![0], 0.0));
}
