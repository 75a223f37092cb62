//! Scores, pairs and bounds against dense least squares and the enumeration of active bounds.

use nalgebra::{DMatrix, DVector};

use super::fixture::{columns, direction, enumerated, problem, products, random_direction, stream};
use bmv::diagnosis::screening::pairs::{best_pairs, screen};
use bmv::diagnosis::{Direction, Linear, Prepared, Score};
use bmv::inference::null_maximum::Side;
use bmv::math::dense::dot_of_columns as dot;
use bmv::math::special::normal_cdf;

/// Sum of squares of the free fit on some columns.
fn left(columns: &[Vec<f64>], r: &[f64]) -> f64 {
    if columns.is_empty() {
        return dot(r, r);
    }
    let j = DMatrix::from_fn(r.len(), columns.len(), |row, k| columns[k][row]);
    let r = DVector::from_column_slice(r);
    let solved = j.clone().svd(true, true).solve(&r, 1e-13).unwrap();
    (r - j * solved).norm_squared()
}

#[test]
fn a_free_score_is_the_fall_of_dense_least_squares() {
    let mut stream = stream("free", 0);
    for case in 0..20 {
        let (rows, p) = (12 + case, case % 6);
        let linear = problem(rows, p, &mut stream);
        let g = random_direction(case, rows, 1, &mut stream);
        let score = Prepared::new(&linear).score(&g);
        let mut all = columns(&linear);
        let without = left(&all, &linear.residuals);
        all.push(g.columns.clone());
        let expected = without - left(&all, &linear.residuals);
        assert!((score.likelihood_ratio - expected).abs() < 1e-9 * (1.0 + without), "{case}");
        assert!((score.z * score.z - expected).abs() < 1e-9 * (1.0 + without));
        // The last row of the inverse of the products.
        let (h, b) = products(&all, &linear.residuals);
        let inverse = DMatrix::from_row_slice(p + 1, p + 1, &h).try_inverse().unwrap();
        let amplitude: f64 = (0..=p).map(|k| inverse[(p, k)] * b[k]).sum();
        assert!((score.amplitudes[0] - amplitude).abs() < 1e-9 && (score.sds[0] - inverse[(p, p)].sqrt()).abs() < 1e-9);
        assert!((score.p - 2.0 * normal_cdf(-score.z.abs())).abs() < 1e-12);
        assert!((normal_cdf(-score.equivalent) - score.p).abs() < 1e-12);
    }
}

fn bounds(linear: &mut Linear, g: &mut Direction, stream: &mut bmv::random::Stream) {
    for k in 0..linear.parameters() {
        let mut bound = || {
            let (u, v) = (stream.uniform(), stream.uniform());
            if u < 0.35 {
                0.0
            } else if u < 0.6 {
                f64::INFINITY
            } else {
                v
            }
        };
        (linear.lower[k], linear.upper[k]) = (-bound(), bound());
    }
    if stream.uniform() < 0.6 {
        g.lower[0] = 0.0;
    }
    if stream.uniform() < 0.3 {
        g.upper[0] = 0.5;
    }
}

/// Parameters at bounds, amplitudes of one sign or small: the difference of two minima, each by enumeration.
#[test]
fn a_bounded_score_is_the_difference_of_enumerated_minima() {
    let mut stream = stream("bounded", 0);
    let mut differs = 0;
    for case in 0..300 {
        let p = case % 5;
        let mut linear = problem(p + 4, p, &mut stream);
        linear.residuals.iter_mut().for_each(|r| *r *= 2.0);
        let mut g = random_direction(0, p + 4, 1, &mut stream);
        bounds(&mut linear, &mut g, &mut stream);
        let prepared = Prepared::new(&linear);
        let score = prepared.score(&g);
        let mut all = columns(&linear);
        let (h, b) = products(&all, &linear.residuals);
        let without = enumerated(&h, &b, &linear.lower, &linear.upper);
        assert!((prepared.fall() - without).abs() < 1e-7 * (1.0 + without), "{case}");
        all.push(g.columns.clone());
        let (h, b) = products(&all, &linear.residuals);
        let lower = [linear.lower.clone(), g.lower.clone()].concat();
        let upper = [linear.upper.clone(), g.upper.clone()].concat();
        let expected = enumerated(&h, &b, &lower, &upper) - without;
        let sum: f64 = linear.residuals.iter().map(|r| r * r).sum();
        // The ridge of 1e-12 and the conditions of normal matrices.
        assert!((score.likelihood_ratio - expected).abs() < 1e-6 * (1.0 + sum), "{case}: {score:?} {expected}");
        differs += usize::from((score.likelihood_ratio - score.free_ratio).abs() > 0.01);
    }
    assert!(differs > 60, "bounds came into play in {differs} cases");
}

#[test]
fn a_parameter_held_at_its_bound_is_not_free() {
    // One parameter that wants to fall below its bound, and a direction that points the same way as it.
    let linear = Linear {
        rows: 3,
        readings: 3,
        residuals: vec![-3.0, 0.5, 1.0],
        jacobian: vec![1.0, 0.0, 0.0],
        lower: vec![0.0],
        upper: vec![f64::INFINITY],
    };
    let prepared = Prepared::new(&linear);
    let pinned = prepared.pinned();
    assert!(pinned.len() == 1 && pinned[0].at_lower && (pinned[0].pressure - 3.0).abs() < 1e-12);
    assert_eq!(prepared.freedom(), 3);
    let score = prepared.score(&direction(0, vec![-1.0, 1.0, 0.0], 1));
    // By hand: z = (3 + 0.5) / sqrt 2; at the amplitude 1.75 the parameter stays pressed: -3 + 1.75 < 0.
    assert!((score.z - 3.5 / 2_f64.sqrt()).abs() < 1e-12 && (score.likelihood_ratio - 6.125).abs() < 1e-10);
    // Where it is released: g = (-1, 0, 1): amplitude (3 + 1) / 2 = 2 still pressed; (-0.2, 0, 1) leaves it pressed too.
    let score = prepared.score(&direction(0, vec![-4.0, 4.0, 4.0], 1));
    // Free of the bound: amplitude (0.5 + 1) / 8 = 0.1875 would leave -3 + 0.75 on it: pressed; z = (12 + 2 + 4) / sqrt 48.
    assert!((score.likelihood_ratio - 18.0 * 18.0 / 48.0).abs() < 1e-9, "{score:?}");
}

#[test]
fn what_the_data_cannot_see_is_said() {
    let mut stream = stream("unseen", 0);
    let linear = problem(10, 3, &mut stream);
    let prepared = Prepared::new(&linear);
    let j = columns(&linear);
    let mixed: Vec<f64> = (0..10).map(|row| 2.0 * j[0][row] - j[2][row]).collect();
    let score = prepared.score(&direction(4, mixed, 1));
    assert!(!score.seen && score.share < 1e-20 && score.p == 1.0 && score.candidate == 4);
    let mut faint = random_direction(0, 10, 1, &mut stream);
    faint.plausible[0] = 1e-3;
    assert!(!prepared.score(&faint).seen);
    assert!(!prepared.score(&direction(0, vec![0.0; 10], 1)).seen);
    assert!(!prepared.score(&direction(0, vec![f64::NAN; 10], 1)).seen);
    assert!(!prepared.score(&direction(0, vec![0.0; 20], 2)).seen);
}

#[test]
fn columns_of_parameters_that_depend_on_each_other_are_one() {
    let mut stream = stream("dependent", 0);
    let mut linear = problem(10, 2, &mut stream);
    let doubled: Vec<f64> = linear.jacobian.chunks(2).flat_map(|row| [row[0], row[1], 3.0 * row[0]]).collect();
    let g = random_direction(0, 10, 1, &mut stream);
    let expected = Prepared::new(&linear).score(&g);
    linear.jacobian = doubled;
    linear.lower.push(-1.0);
    linear.upper.push(1.0);
    let prepared = Prepared::new(&linear);
    assert_eq!(prepared.freedom(), 8);
    let score = prepared.score(&g);
    assert!((score.z - expected.z).abs() < 1e-9 && (score.likelihood_ratio - expected.likelihood_ratio).abs() < 1e-7);
}

/// `r' r - r' (I + G T^2 G')^-1 r` on residuals and columns that were projected, by a dense inverse.
#[test]
fn several_columns_have_the_ratio_of_a_variance_component() {
    let mut stream = stream("several", 0);
    let (rows, k) = (15, 4);
    let linear = problem(rows, 2, &mut stream);
    let mut g = random_direction(0, rows, k, &mut stream);
    g.plausible = vec![0.3, 1.0, 2.0, 0.05];
    let prepared = Prepared::new(&linear);
    let score = prepared.score(&g);
    let columns: Vec<Vec<f64>> = (0..k).map(|a| prepared.project(g.column(a))).collect();
    let covariance = DMatrix::from_fn(rows, rows, |i, j| {
        f64::from(u8::from(i == j))
            + (0..k).map(|a| g.plausible[a] * g.plausible[a] * columns[a][i] * columns[a][j]).sum::<f64>()
    });
    let r = DVector::from_column_slice(prepared.residuals());
    let inverse = covariance.try_inverse().unwrap();
    let expected = r.norm_squared() - r.dot(&(&inverse * &r));
    assert!((score.free_ratio - expected).abs() < 1e-9 && (score.likelihood_ratio - expected).abs() < 1e-7);
    let freedom = rows as f64 - inverse.trace();
    assert!((score.freedom - freedom).abs() < 1e-9);
    // Posterior means of the amplitudes: T^2 G' (I + G T^2 G')^-1 r, and their variances.
    for a in 0..k {
        let t = g.plausible[a];
        let column = DVector::from_column_slice(&columns[a]);
        let mean = t * t * column.dot(&(&inverse * &r));
        let variance = t * t - t * t * t * t * column.dot(&(&inverse * &column));
        assert!((score.amplitudes[a] - mean).abs() < 1e-9 && (score.sds[a] - variance.sqrt()).abs() < 1e-9);
    }
}

#[test]
fn one_column_of_a_wide_prior_scores_as_a_free_one() {
    // With an amplitude as free as 1e4, the penalised ratio is z^2.
    let mut stream = stream("wide", 0);
    let linear = problem(12, 2, &mut stream);
    let g = random_direction(0, 12, 1, &mut stream);
    let mut two = direction(0, [g.columns.clone(), vec![0.0; 12]].concat(), 2);
    two.plausible = vec![1e4; 2];
    let prepared = Prepared::new(&linear);
    let (one, two) = (prepared.score(&g), prepared.score(&two));
    assert!((one.p - two.p).abs() < 1e-6 && (one.likelihood_ratio - two.likelihood_ratio).abs() < 1e-6);
}

#[test]
fn pairs_are_those_of_a_double_loop() {
    let mut stream = stream("pairs", 0);
    let (rows, n) = (20, 45);
    let mut linear = problem(rows, 3, &mut stream);
    linear.residuals.iter_mut().for_each(|r| *r *= 2.0);
    let mut directions: Vec<Direction> = (0..n).map(|k| random_direction(k, rows, 1, &mut stream)).collect();
    for g in directions.iter_mut().step_by(2) {
        g.lower[0] = 0.0;
    }
    // Two that are one.
    directions[7].columns = directions[3].columns.iter().map(|x| -2.0 * x).collect();
    let prepared = Prepared::new(&linear);
    let scores: Vec<Score> = directions.iter().map(|g| prepared.score(g)).collect();
    let base = columns(&linear);
    let without = left(&base, &linear.residuals);
    let mut expected = Vec::new();
    for j in 0..n {
        for k in j + 1..n {
            if (j, k) == (3, 7) {
                continue;
            }
            let mut all = base.clone();
            all.push(directions[j].columns.clone());
            all.push(directions[k].columns.clone());
            let (h, b) = products(&all, &linear.residuals);
            let lower: Vec<f64> =
                [vec![f64::NEG_INFINITY; 3], vec![directions[j].lower[0], directions[k].lower[0]]].concat();
            let fall =
                enumerated(&h, &b, &lower, &[f64::INFINITY; 5]) - (dot(&linear.residuals, &linear.residuals) - without);
            let single = scores[j].likelihood_ratio.max(scores[k].likelihood_ratio);
            if fall > single + 1e-9 {
                expected.push((fall, j, k));
            }
        }
    }
    expected.sort_by(|a, b| b.0.total_cmp(&a.0));
    let found = best_pairs(&prepared, &directions, &scores, 30);
    assert_eq!(found.len(), 30);
    for (pair, (fall, j, k)) in found.iter().zip(expected) {
        assert_eq!((pair.first, pair.second), (j, k));
        assert!((pair.likelihood_ratio - fall).abs() < 1e-7 * (1.0 + fall));
        assert!(directions[j].lower[0] <= pair.amplitudes[0] && directions[k].lower[0] <= pair.amplitudes[1]);
    }
}

#[test]
fn tied_pairs_come_in_the_order_of_their_positions() {
    let mut units = vec![0.0; 36];
    (0..6).for_each(|k| units[7 * k] = 1.0);
    let pairs = screen(&units, 6, &[2.0; 6], &[Side::Two; 6], 4);
    let found: Vec<(usize, usize)> = pairs.iter().map(|pair| (pair.first, pair.second)).collect();
    assert_eq!(found, [(0, 1), (0, 2), (0, 3), (0, 4)]);
    assert!(pairs.iter().all(|pair| pair.likelihood_ratio == 8.0));
    assert!(screen(&units, 6, &[-2.0; 6], &[Side::Positive; 6], 4).is_empty());
}
