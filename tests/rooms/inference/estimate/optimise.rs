//! Tests of `core/src/inference/estimate/optimise.rs`.

use bmv::inference::estimate::optimise::*;
use bmv::math::functions::exp;

/// A step of unknown size at an unknown threshold, between two of ten levels: `r = y - a s((level - t) / width)`.
struct StepAtThreshold {
    readings: [f64; 10],
}

impl StepAtThreshold {
    const WIDTH: f64 = 0.01;

    fn share(level: usize, threshold: f64) -> f64 {
        1.0 / (1.0 + exp((threshold - level as f64) / Self::WIDTH))
    }
}

impl Objective for StepAtThreshold {
    fn dimension(&self) -> usize {
        2
    }

    fn rows(&self) -> usize {
        10
    }

    fn value(&mut self, x: &[f64], residuals: &mut [f64]) -> Option<f64> {
        for (level, r) in residuals.iter_mut().enumerate() {
            *r = x[0] * Self::share(level, x[1]) - self.readings[level];
        }
        Some(0.0)
    }

    fn slopes(
        &mut self,
        x: &[f64],
        residuals: &mut [f64],
        jacobian: &mut [f64],
        penalty_gradient: &mut [f64],
    ) -> Option<f64> {
        penalty_gradient.fill(0.0);
        for level in 0..10 {
            let share = Self::share(level, x[1]);
            jacobian[2 * level] = share;
            jacobian[2 * level + 1] = -x[0] * share * (1.0 - share) / Self::WIDTH;
        }
        self.value(x, residuals)
    }
}

/// Between two levels the threshold has a slope of some 1e-11: it must neither run away nor hold the size back. The
/// minimum in the size is the mean of the readings above the threshold; its neighbours pull at it from neither side.
#[test]
fn a_threshold_between_two_levels_leaves_the_step_its_size() {
    let mut objective = StepAtThreshold { readings: [0.1, -0.2, 0.0, -0.1, 3.1, 2.9, 3.0, 3.2, 2.8, 3.0] };
    let bounds = Bounds { lower: vec![-10.0, 0.0], upper: vec![10.0, 9.0] };
    for threshold in [3.3, 3.5, 3.75] {
        let minimum = minimise(
            &mut objective,
            &[0.5, threshold],
            &bounds,
            Effort { most_iterations: 60, least_gain: 0.0, ceiling: f64::INFINITY },
        )
        .unwrap();
        assert!((minimum.x[0] - 3.0).abs() < 1e-6, "from {threshold}: {:?}", minimum.x);
        assert!(minimum.x[1] > 3.0 && minimum.x[1] < 4.0, "from {threshold}: {:?}", minimum.x);
    }
}

/// `r = (x, 50 (y^2 - 1))`: minima at y = 1 and y = -1.
struct TwoMinima {
    slopes: u32,
}

impl Objective for TwoMinima {
    fn dimension(&self) -> usize {
        2
    }

    fn rows(&self) -> usize {
        2
    }

    fn value(&mut self, x: &[f64], residuals: &mut [f64]) -> Option<f64> {
        residuals.copy_from_slice(&[x[0], 50.0 * (x[1] * x[1] - 1.0)]);
        Some(0.0)
    }

    fn slopes(
        &mut self,
        x: &[f64],
        residuals: &mut [f64],
        jacobian: &mut [f64],
        penalty_gradient: &mut [f64],
    ) -> Option<f64> {
        self.slopes += 1;
        penalty_gradient.fill(0.0);
        jacobian.copy_from_slice(&[1.0, 0.0, 0.0, 100.0 * x[1]]);
        self.value(x, residuals)
    }
}

/// From another side of the same minimum a descent is left early; one that leads to another minimum is not.
#[test]
fn a_descent_to_a_known_minimum_is_left_early_and_one_to_another_is_not() {
    let bounds = Bounds { lower: vec![-10.0; 2], upper: vec![10.0; 2] };
    let effort = Effort { most_iterations: 60, least_gain: 1.01 * COSTLY, ceiling: f64::INFINITY };
    let descend = |start: [f64; 2], known: Option<&Minimum>| {
        let mut objective = TwoMinima { slopes: 0 };
        let minimum = minimise_beside(&mut objective, &start, &bounds, effort, known).unwrap();
        (minimum, objective.slopes)
    };
    let (known, _) = descend([1.0, 2.0], None);
    let (alone, slopes_alone) = descend([4.0, 3.0], None);
    assert!((alone.x[1] - 1.0).abs() < 1e-3 && (known.x[1] - 1.0).abs() < 1e-3);
    let (beside, slopes) = descend([4.0, 3.0], Some(&known));
    assert!(slopes < slopes_alone, "{slopes} of {slopes_alone}");
    assert!(beside.value >= known.value);
    // A minimum that is taken for a worse one than it is.
    let worse = Minimum { value: known.value + 3.0, ..known.clone() };
    let (other, _) = descend([4.0, -3.0], Some(&worse));
    assert!((other.x[1] + 1.0).abs() < 1e-3, "{:?}", other.x);
}

/// `r = (x - y^2, 1 - y, 1000)` scaled as Rosenbrock's valley: a long way of many small gains, far above a ceiling of 1.
struct Valley {
    slopes: u32,
}

impl Objective for Valley {
    fn dimension(&self) -> usize {
        2
    }

    fn rows(&self) -> usize {
        3
    }

    fn value(&mut self, x: &[f64], residuals: &mut [f64]) -> Option<f64> {
        residuals.copy_from_slice(&[30.0 * (x[1] - x[0] * x[0]), 1.0 - x[0], 1000.0]);
        Some(0.0)
    }

    fn slopes(
        &mut self,
        x: &[f64],
        residuals: &mut [f64],
        jacobian: &mut [f64],
        penalty_gradient: &mut [f64],
    ) -> Option<f64> {
        self.slopes += 1;
        penalty_gradient.fill(0.0);
        jacobian.copy_from_slice(&[-60.0 * x[0], 30.0, -1.0, 0.0, 0.0, 0.0]);
        self.value(x, residuals)
    }
}

/// The valley's end is at 500,000.
#[test]
fn a_descent_far_above_the_ceiling_is_left_early() {
    let bounds = Bounds { lower: vec![-10.0; 2], upper: vec![10.0; 2] };
    let descend = |ceiling: f64| {
        let effort = Effort { most_iterations: 60, least_gain: 1.01 * COSTLY, ceiling };
        let mut objective = Valley { slopes: 0 };
        let minimum = minimise(&mut objective, &[-1.2, 1.0], &bounds, effort).unwrap();
        (minimum.value, objective.slopes)
    };
    let (to_its_end, to_the_ceiling) = (descend(f64::INFINITY), descend(1.0));
    assert!((to_its_end.0 - 500_000.0).abs() < 1e-3, "{to_its_end:?}");
    assert!(to_the_ceiling.1 < to_its_end.1, "{to_the_ceiling:?} of {to_its_end:?}");
    // One that leads below the ceiling goes to its end.
    assert_eq!(descend(to_its_end.0 + 1.0), to_its_end);
}

/// `r = (x, 0.65 + x^2 / 2)`: near 0 the objective curves 1.65 times as much as the Jacobian tells, so that its steps end
/// 0.65 times as far on the other side.
struct LargeResidual;

impl Objective for LargeResidual {
    fn dimension(&self) -> usize {
        1
    }

    fn rows(&self) -> usize {
        2
    }

    fn value(&mut self, x: &[f64], residuals: &mut [f64]) -> Option<f64> {
        residuals.copy_from_slice(&[x[0], 0.65 + 0.5 * x[0] * x[0]]);
        Some(0.0)
    }

    fn slopes(
        &mut self,
        x: &[f64],
        residuals: &mut [f64],
        jacobian: &mut [f64],
        penalty_gradient: &mut [f64],
    ) -> Option<f64> {
        penalty_gradient.fill(0.0);
        jacobian.copy_from_slice(&[1.0, x[0]]);
        self.value(x, residuals)
    }
}

/// A foreseen gain below 1e-4 beside a curvature of 1.65 is a step below 0.012.
#[test]
fn the_curvature_of_large_residuals_is_learned_where_slopes_are_costly() {
    let bounds = Bounds { lower: vec![-10.0], upper: vec![10.0] };
    let descend = |least_gain: f64| {
        let effort = Effort { most_iterations: 60, least_gain, ceiling: f64::INFINITY };
        let minimum = minimise(&mut LargeResidual, &[4.0], &bounds, effort).unwrap();
        assert!(minimum.x[0].abs() < 0.012, "{minimum:?}");
        minimum.iterations
    };
    let (costly, cheap) = (descend(1.01 * COSTLY), descend(COSTLY));
    assert!(3 * costly <= 2 * cheap, "{costly} and {cheap}");
}

/// Ten readings on a line whose stated slopes are wrong by a few per cent, as those found on fewer rows of a record.
struct RoughSlopes {
    evaluations: usize,
}

impl RoughSlopes {
    const ERROR: [f64; 2] = [1.04, 0.97];

    fn at(x: &[f64], residuals: &mut [f64]) {
        for (row, r) in residuals.iter_mut().enumerate() {
            let place = row as f64 / 10.0;
            *r = 100.0 * (x[0] * (1.0 - place) + x[1] * place + 0.1 * x[0] * x[1])
                - if row % 2 == 0 { 80.0 } else { 20.0 };
        }
    }
}

impl Objective for RoughSlopes {
    fn dimension(&self) -> usize {
        2
    }

    fn rows(&self) -> usize {
        10
    }

    fn value(&mut self, x: &[f64], residuals: &mut [f64]) -> Option<f64> {
        self.evaluations += 1;
        Self::at(x, residuals);
        Some(0.0)
    }

    fn slopes(
        &mut self,
        x: &[f64],
        residuals: &mut [f64],
        jacobian: &mut [f64],
        penalty_gradient: &mut [f64],
    ) -> Option<f64> {
        penalty_gradient.fill(0.0);
        for row in 0..10 {
            let place = row as f64 / 10.0;
            jacobian[2 * row] = 100.0 * Self::ERROR[0] * (1.0 - place + 0.1 * x[1]);
            jacobian[2 * row + 1] = 100.0 * Self::ERROR[1] * (place + 0.1 * x[0]);
        }
        self.value(x, residuals)
    }
}

/// With wrong slopes the steps near the minimum do not descend. Their parabola says that there is nothing to gain any more.
#[test]
fn rough_slopes_end_a_descent_where_steps_gain_nothing() {
    let mut objective = RoughSlopes { evaluations: 0 };
    let bounds = Bounds { lower: vec![-10.0; 2], upper: vec![10.0; 2] };
    let effort = Effort { most_iterations: 60, least_gain: 2e-2, ceiling: f64::INFINITY };
    let minimum = minimise(&mut objective, &[0.1, 1.5], &bounds, effort).expect("a value");
    // The minimum by a fine grid about it.
    let value = |x: [f64; 2]| {
        let mut residuals = [0.0; 10];
        RoughSlopes::at(&x, &mut residuals);
        0.5 * residuals.iter().map(|r| r * r).sum::<f64>()
    };
    let offsets = || (-200..=200).map(|step| f64::from(step) * 1e-4);
    let near = offsets().flat_map(|a| offsets().map(move |b| (a, b)));
    let least = near.map(|(a, b)| value([minimum.x[0] + a, minimum.x[1] + b])).fold(f64::INFINITY, f64::min);
    assert!(minimum.converged && minimum.value - least < 0.2, "{} above", minimum.value - least);
    assert!(objective.evaluations <= 14, "{} evaluations", objective.evaluations);
}
