//! Tests of `diagnosis/src/diagnosis/verdict/collinear.rs`.

use bmv::diagnosis::verdict::collinear::*;
use bmv::math::functions::{cos, sin};

#[test]
fn inputs_that_move_together_are_found_closest_first() {
    let rows: Vec<f64> = (0..40).map(f64::from).collect();
    let of = |own: &dyn Fn(f64) -> f64| rows.iter().map(|row| own(*row)).collect::<Vec<f64>>();
    let own = of(&|t| sin(0.3 * t));
    let opposite = of(&|t| 5.0 - 2.0 * sin(0.3 * t));
    let near = of(&|t| sin(0.3 * t) + 0.2 * cos(2.1 * t));
    let other = of(&|t| cos(1.1 * t));
    let held = of(&|_| 3.0);
    let absent = of(&|_| f64::NAN);
    let all = [own, opposite, near, other, held, absent];
    let found = together(&all, 0);
    assert_eq!(found.iter().map(|one| one.0).collect::<Vec<_>>(), [1, 2], "{found:?}");
    assert!((found[0].1 + 1.0).abs() < 1e-12 && (0.9..1.0).contains(&found[1].1), "{found:?}");
    assert!(together(&all, 4).is_empty(), "what never moves moves with nothing");
    let short: Vec<Vec<f64>> = all.iter().map(|values| values[..7].to_vec()).collect();
    assert!(together(&short, 0).is_empty(), "few rows say nothing");
}
