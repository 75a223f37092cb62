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

/// Readings that scatter widely about a line, with slopes that are stated wrongly from row to row and from place to place, as those
/// of a long record that are found on fewer rows: near the minimum a step along them does not descend.
struct RoughSlopes {
    evaluations: usize,
}

impl RoughSlopes {
    const ROWS: usize = 40;

    fn design(row: usize) -> [f64; 2] {
        let place = row as f64 / Self::ROWS as f64;
        [10.0 * (1.0 - place), 10.0 * place]
    }

    fn sum(x: &[f64], residuals: &mut [f64]) -> f64 {
        for (row, r) in residuals.iter_mut().enumerate() {
            let [a, b] = Self::design(row);
            *r = a * x[0] + b * x[1] + 0.3 * x[0] * x[1] - if row % 3 == 0 { 14.0 } else { -1.0 };
        }
        0.5 * residuals.iter().map(|r| r * r).sum::<f64>()
    }
}

impl Objective for RoughSlopes {
    fn dimension(&self) -> usize {
        2
    }

    fn rows(&self) -> usize {
        Self::ROWS
    }

    fn value(&mut self, x: &[f64], residuals: &mut [f64]) -> Option<f64> {
        self.evaluations += 1;
        Self::sum(x, residuals);
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
        for row in 0..Self::ROWS {
            let [a, b] = Self::design(row);
            // As irregular as the steps of an integrator.
            let wrong = 0.9 + 0.2 * (0.618 * row as f64 + 1e4 * x[0].abs()).fract();
            jacobian[2 * row] = wrong * (a + 0.3 * x[1]);
            jacobian[2 * row + 1] = wrong * (b + 0.3 * x[0]);
        }
        self.value(x, residuals)
    }
}

#[test]
fn rough_slopes_end_a_descent_where_steps_gain_nothing() {
    let bounds = Bounds { lower: vec![-10.0; 2], upper: vec![10.0; 2] };
    // Mean height of the ends, and evaluations, of descents from many starts.
    let descents = |least_gain: f64| {
        let mut objective = RoughSlopes { evaluations: 0 };
        let effort = Effort { most_iterations: 60, least_gain, ceiling: f64::INFINITY };
        let mut end = |start: u32| {
            let start = [-1.0 + 0.01 * f64::from(start), 2.0];
            let minimum = minimise(&mut objective, &start, &bounds, effort).expect("a value");
            assert!(minimum.converged);
            minimum.value
        };
        let heights: f64 = (0..100).map(&mut end).sum();
        (heights / 100.0, objective.evaluations)
    };
    let (height, evaluations) = descents(2.0 * ROUGH);
    let (as_if_exact, of_exact) = descents(ROUGH);
    assert!(height < as_if_exact + ROUGH, "{height}, {as_if_exact} as if slopes were exact");
    assert!(10 * evaluations < 8 * of_exact, "{evaluations} evaluations, {of_exact} as if slopes were exact");
}

/// Where a step has no value it is shortened, also with rough slopes.
#[test]
fn a_step_without_a_value_ends_no_descent() {
    struct Wall;
    impl Objective for Wall {
        fn dimension(&self) -> usize {
            1
        }

        fn rows(&self) -> usize {
            1
        }

        fn value(&mut self, x: &[f64], residuals: &mut [f64]) -> Option<f64> {
            residuals[0] = 100.0 * (x[0] * x[0] - 0.36);
            (x[0] < 0.62).then_some(0.0)
        }

        fn slopes(&mut self, x: &[f64], residuals: &mut [f64], jacobian: &mut [f64], pull: &mut [f64]) -> Option<f64> {
            pull.fill(0.0);
            jacobian[0] = 200.0 * x[0];
            self.value(x, residuals)
        }
    }
    let effort = Effort { most_iterations: 60, least_gain: 2.0 * ROUGH, ceiling: f64::INFINITY };
    let bounds = Bounds { lower: vec![0.0], upper: vec![10.0] };
    let minimum = minimise(&mut Wall, &[0.05], &bounds, effort).expect("a value");
    assert!(minimum.value < 2.0 * ROUGH && minimum.x[0] > 0.05, "{} at {}", minimum.value, minimum.x[0]);
}

/// So many rows that they are made triangular block by block, the last block shorter than there are columns: a polynomial through
/// scattered points, against the solution by all rows at once.
#[test]
fn a_long_least_squares_problem_has_the_solution_of_all_its_rows() {
    const ROWS: usize = 40 * 512 + 3;
    const COLUMNS: usize = 6;
    struct Polynomial;
    impl Polynomial {
        fn design(row: usize) -> [f64; COLUMNS] {
            let place = row as f64 / ROWS as f64;
            let mut power = 1.0;
            std::array::from_fn(|_| {
                let own = power;
                power *= place;
                own
            })
        }

        fn reading(row: usize) -> f64 {
            // Scattered evenly between -0.5 and 0.5 about a wave.
            exp(-(row as f64) / 9000.0) + (0.618 * row as f64).fract() - 0.5
        }
    }
    impl Objective for Polynomial {
        fn dimension(&self) -> usize {
            COLUMNS
        }

        fn rows(&self) -> usize {
            ROWS
        }

        fn value(&mut self, x: &[f64], residuals: &mut [f64]) -> Option<f64> {
            for (row, r) in residuals.iter_mut().enumerate() {
                *r = Self::design(row).iter().zip(x).map(|(a, x)| a * x).sum::<f64>() - Self::reading(row);
            }
            Some(0.0)
        }

        fn slopes(&mut self, x: &[f64], residuals: &mut [f64], jacobian: &mut [f64], pull: &mut [f64]) -> Option<f64> {
            pull.fill(0.0);
            for (row, slopes) in jacobian.chunks_exact_mut(COLUMNS).enumerate() {
                slopes.copy_from_slice(&Self::design(row));
            }
            self.value(x, residuals)
        }
    }
    let bounds = Bounds { lower: vec![-1e3; COLUMNS], upper: vec![1e3; COLUMNS] };
    let effort = Effort { most_iterations: 60, least_gain: 0.0, ceiling: f64::INFINITY };
    let minimum = minimise(&mut Polynomial, &[0.0; COLUMNS], &bounds, effort).expect("a value");
    let design = nalgebra::DMatrix::from_fn(ROWS, COLUMNS, |row, column| Polynomial::design(row)[column]);
    let readings = nalgebra::DVector::from_fn(ROWS, |row, _| Polynomial::reading(row));
    let solution = design.svd(true, true).solve(&readings, 1e-14).expect("a solution");
    for (own, other) in minimum.x.iter().zip(solution.iter()) {
        // The columns' condition is some 5e3.
        assert!((own - other).abs() < 1e-8, "{:?} {solution}", minimum.x);
    }
}
