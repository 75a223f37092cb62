//! Tests of `diagnosis/src/diagnosis/odds/sampling.rs`.

use bmv::diagnosis::odds::sampling::{odds_by_chance, standard_error};

/// Differences of 1, 2, 3 and 6: a sum of 12; scatter 14 about the mean of 3, times 4/3.
#[test]
fn the_scatter_between_blocks_tells_how_far_chance_decides() {
    let (se, freedom) = standard_error(&[1.0, 2.0, 3.0, 6.0], &[0.0; 4]).unwrap();
    assert!((se - (14.0_f64 * 4.0 / 3.0).sqrt()).abs() < 1e-12 && freedom == 3.0);
    for none in [[0.5; 4], [f64::NAN; 4], [f64::INFINITY; 4]] {
        assert!(standard_error(&none, &[0.0; 4]).is_none(), "{none:?}");
    }
    assert!(standard_error(&[1.0], &[0.0]).is_none() && standard_error(&[], &[]).is_none());
}

/// Student's t of 1 degree of freedom is Cauchy's: a lag of one standard error has a tail of a quarter.
#[test]
fn a_lag_of_a_standard_error_is_no_certainty() {
    assert!((odds_by_chance(2.0, (2.0, 1.0)) - 1.0 / 3.0).abs() < 1e-9);
    // Of many blocks the normal distribution's: 0.1587 and 1.3e-3.
    assert!((odds_by_chance(5.0, (5.0, 1e6)) - 0.1587 / 0.8413).abs() < 1e-3);
    assert!((odds_by_chance(15.0, (5.0, 1e6)) - 1.35e-3).abs() < 1e-4);
    assert!((odds_by_chance(-4.0, (5.0, 9.0)) - 1.0).abs() < 1e-9, "what is ahead is not behind");
}
