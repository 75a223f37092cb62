//! Tests of `core/src/thermal/transient/tableau.rs`.

use bmv::thermal::transient::tableau::*;

fn full() -> [[f64; STAGES]; STAGES] {
    let mut a = COEFFICIENTS;
    for i in 1..STAGES {
        a[i][i] = GAMMA;
    }
    a
}

fn conditions(b: &[f64; STAGES]) -> Vec<(usize, f64)> {
    let a = full();
    let c = NODES;
    let sum = |f: &dyn Fn(usize) -> f64| (0..STAGES).map(|i| b[i] * f(i)).sum::<f64>();
    let apply = |x: &dyn Fn(usize) -> f64, i: usize| (0..STAGES).map(|j| a[i][j] * x(j)).sum::<f64>();
    vec![
        (1, sum(&|_| 1.0) - 1.0),
        (2, sum(&|i| c[i]) - 0.5),
        (3, sum(&|i| c[i] * c[i]) - 1.0 / 3.0),
        (3, sum(&|i| apply(&|j| c[j], i)) - 1.0 / 6.0),
        (4, sum(&|i| c[i] * c[i] * c[i]) - 0.25),
        (4, sum(&|i| c[i] * apply(&|j| c[j], i)) - 0.125),
        (4, sum(&|i| apply(&|j| c[j] * c[j], i)) - 1.0 / 12.0),
        (4, sum(&|i| apply(&|j| apply(&|k| c[k], j), i)) - 1.0 / 24.0),
    ]
}

#[test]
fn order_conditions_hold() {
    // Exact rationals of magnitude below 1: only rounding is left.
    for (order, defect) in conditions(&full()[STAGES - 1]) {
        assert!(defect.abs() < 1e-14, "order {order}: {defect}");
    }
    for (order, defect) in conditions(&EMBEDDED) {
        assert_eq!(defect.abs() < 1e-14, order <= 3, "embedded, order {order}: {defect}");
    }
}

#[test]
fn stages_have_order_two_and_the_scheme_is_stiffly_accurate() {
    let a = full();
    for i in 0..STAGES {
        assert!((a[i].iter().sum::<f64>() - NODES[i]).abs() < 1e-14);
        let second: f64 = (0..STAGES).map(|j| a[i][j] * NODES[j]).sum();
        assert!((second - 0.5 * NODES[i] * NODES[i]).abs() < 1e-14);
    }
    assert_eq!(NODES[STAGES - 1], 1.0);
}

#[test]
fn the_scheme_is_l_stable() {
    // On y' = l y the result over the step is the last stage; |R| <= 1 on the imaginary axis, -> 0 at infinity.
    let magnitude = |re: f64, im: f64| {
        let a = full();
        let mut stage = [(1.0, 0.0); STAGES];
        for i in 1..STAGES {
            let (mut x, mut y) = (1.0, 0.0);
            for j in 0..i {
                let (p, q) = stage[j];
                x += a[i][j] * (re * p - im * q);
                y += a[i][j] * (re * q + im * p);
            }
            let (d, e) = (1.0 - GAMMA * re, -GAMMA * im);
            let n = d * d + e * e;
            stage[i] = ((x * d + y * e) / n, (y * d - x * e) / n);
        }
        let (x, y) = stage[STAGES - 1];
        (x * x + y * y).sqrt()
    };
    for i in 0..2000 {
        assert!(magnitude(0.0, 0.01 * f64::from(i)) <= 1.0 + 1e-12);
        assert!(magnitude(-0.01 * f64::from(i), 0.0) <= 1.0 + 1e-12);
    }
    assert!(magnitude(-1e8, 0.0) < 1e-6);
}
