//! The coefficients of the implicit scheme: ESDIRK of six stages, order 4 with an embedded order 3, L-stable and
//! stiffly accurate (Kennedy & Carpenter 2003, Appl. Numer. Math. 44, 139: implicit part of `ARK4(3)6L[2]SA`).

use crate::math::sort::sort_by;

/// Number of stages, the first of which is explicit.
pub const STAGES: usize = 6;

/// Diagonal coefficient of the implicit stages.
pub const GAMMA: f64 = 0.25;

/// Instants of the stages within a step.
pub const NODES: [f64; STAGES] = [0.0, 0.5, 83.0 / 250.0, 31.0 / 50.0, 17.0 / 20.0, 1.0];

/// Coefficients below the diagonal; the last row is that of the result.
pub const COEFFICIENTS: [[f64; STAGES]; STAGES] = [
    [0.0; STAGES],
    [0.25, 0.0, 0.0, 0.0, 0.0, 0.0],
    [8611.0 / 62500.0, -1743.0 / 31250.0, 0.0, 0.0, 0.0, 0.0],
    [5012029.0 / 34652500.0, -654441.0 / 2922500.0, 174375.0 / 388108.0, 0.0, 0.0, 0.0],
    [
        15267082809.0 / 155376265600.0,
        -71443401.0 / 120774400.0,
        730878875.0 / 902184768.0,
        2285395.0 / 8070912.0,
        0.0,
        0.0,
    ],
    [82889.0 / 524892.0, 0.0, 15625.0 / 83664.0, 69875.0 / 102672.0, -2260.0 / 8211.0, 0.0],
];

/// Weights of the embedded result of order 3.
pub const EMBEDDED: [f64; STAGES] = [
    4586570599.0 / 29645900160.0,
    0.0,
    178811875.0 / 945068544.0,
    814220225.0 / 1159782912.0,
    -3700637.0 / 11593932.0,
    61727.0 / 225920.0,
];

/// Weight of a stage's slope in the error estimate.
pub fn error_weight(stage: usize) -> f64 {
    let weight = if stage == STAGES - 1 { GAMMA } else { COEFFICIENTS[STAGES - 1][stage] };
    weight - EMBEDDED[stage]
}

/// Weights with which the slopes of the earlier stages, up to four nearest in time, extrapolate to a stage.
pub fn predictor(stage: usize) -> [f64; STAGES] {
    let mut near: Vec<usize> = (0..stage).collect();
    sort_by(&mut near, |&a, &b| (NODES[a] - NODES[stage]).abs().total_cmp(&(NODES[b] - NODES[stage]).abs()));
    near.truncate(4);
    let mut weights = [0.0; STAGES];
    for &i in &near {
        weights[i] =
            near.iter().filter(|&&j| j != i).map(|&j| (NODES[stage] - NODES[j]) / (NODES[i] - NODES[j])).product();
    }
    weights
}
