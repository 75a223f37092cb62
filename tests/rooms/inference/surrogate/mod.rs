//! Tests of `core/src/inference/surrogate/mod.rs`.

use bmv::inference::surrogate::*;
use bmv::random::{PointKind, Points, StreamKey};
use bmv::thermal::external::Point;

/// Runs of `y = 300 + 8 a^2 + 3 sin-like cubic in x`, and of a constant, over `a` in (0, 2) and `x` in (-1, 1).
fn runs(count: usize) -> (Space, Vec<Run>) {
    let space = Space {
        names: vec!["a".into(), "b".into(), "x".into()],
        parameters: 2,
        base: vec![1.0, 7.0, 0.0],
        axes: vec![
            Axis { place: 0, centre: 1.0, scale: 0.5, is_log: false, range: None },
            Axis { place: 2, centre: 0.0, scale: 0.5, is_log: false, range: Some([-1.0, 1.0]) },
        ],
    };
    let points = Points::new(PointKind::Sobol, StreamKey::new(1, "surrogate", "runs"), count, 2).expect("points");
    let mut row = [0.0; 2];
    let run = |index| {
        points.fill_row(index, &mut row);
        let (a, x) = (2.0 * row[0], 2.0 * row[1] - 1.0);
        Run { parameters: vec![a, 7.0], inputs: vec![x], outputs: vec![truth(a, x), 5.0] }
    };
    (space, (0..count).map(run).collect())
}

fn truth(a: f64, x: f64) -> f64 {
    300.0 + 8.0 * a * a + 3.0 * x * (1.0 - x * x) * a
}

#[test]
fn a_surrogate_predicts_runs_that_it_did_not_see_within_the_error_that_it_states() {
    let (space, runs) = runs(40);
    let key = StreamKey::new(1, "surrogate", "fit");
    let emulations = Surrogate::fit(&space, &runs, &key).expect("fitted");
    let left_out = &emulations[0].left_out;
    // The spread is that of 8 a^2 over a uniform a: 8 sqrt(4^2 / 5 - (4 / 3)^2), 9.5.
    assert!((emulations[0].spread - 9.5).abs() < 0.5, "{}", emulations[0].spread);
    assert!(left_out.rms < 0.01 * emulations[0].spread, "{left_out:?}");
    assert_eq!((emulations[1].spread, emulations[1].left_out.rms), (0.0, 0.0));
    let surrogate = Surrogate::new(space, &runs, &emulations).expect("made");
    let (mut square, mut standardised, mut count) = (0.0, 0.0, 0.0);
    for i in 0..20 {
        for j in 0..20 {
            let (a, x) = (0.1 + 0.09 * f64::from(i), -0.9 + 0.09 * f64::from(j));
            let point = Point { parameters: vec![a, 7.0, 0.0, 0.0], inputs: vec![x] };
            let expected = surrogate.at(&surrogate.coordinates(&point).expect("within"));
            assert_eq!(expected[1], Expected { mean: 5.0, sd: 0.0 });
            let error = expected[0].mean - truth(a, x);
            square += error * error;
            standardised += error * error / (expected[0].sd * expected[0].sd);
            count += 1.0;
        }
    }
    // Points between the runs lie nearer to others than a run that was left out.
    let rms = (square / count).sqrt();
    assert!(rms < 2.0 * left_out.rms, "{rms} {left_out:?}");
    assert!((standardised / count).sqrt() < 2.0, "{standardised} {count}");
}

#[test]
fn where_no_run_says_anything_there_is_no_answer_and_the_fault_says_what_to_write() {
    let (mut space, _) = runs(1);
    let logarithmic = Axis { place: 0, centre: 1.5, scale: 0.5, is_log: true, range: None };
    let linear = std::mem::replace(&mut space.axes[0], logarithmic);
    let point = |b: f64, x: f64| Point { parameters: vec![1.5, b], inputs: vec![x] };
    assert_eq!(space.coordinates(&point(7.0, 0.5)), Ok(vec![0.0, 1.0]));
    let negative = Point { parameters: vec![-1.0, 7.0], inputs: vec![0.0] };
    assert!(space.coordinates(&negative).unwrap_err().to_string().contains("no finite number"));
    space.axes[0] = linear;
    let at = |b: f64, x: f64| space.coordinates(&point(b, x));
    assert_eq!(at(7.0, 0.5), Ok(vec![1.0, 1.0]));
    assert!(at(7.0, 1.5).unwrap_err().to_string().contains("`x` is 1.5, and runs reach from -1 to 1"));
    assert!(at(7.5, 0.0).unwrap_err().to_string().contains("`b` is 7.5, and was 7 in all runs"));
}

#[test]
fn further_runs_go_where_the_error_weighs_most_and_not_twice_to_one_place() {
    let (space, runs) = runs(8);
    let key = StreamKey::new(1, "surrogate", "fit");
    let emulations = Surrogate::fit(&space, &runs, &key).expect("fitted");
    let surrogate = Surrogate::new(space, &runs, &emulations).expect("made");
    let candidate = |a: f64, x: f64, weight: f64| choice::Candidate {
        point: Point { parameters: vec![a, 7.0], inputs: vec![x] },
        weights: vec![weight, 0.0],
    };
    let mut candidates: Vec<choice::Candidate> = (0..9).map(|k| candidate(0.2 * f64::from(k), 0.9, 1.0)).collect();
    candidates.push(candidate(1.0, 0.9, 1.0));
    candidates.push(candidate(1.9, -0.9, 1e6));
    let chosen = choice::choose(&surrogate, &candidates, 4);
    assert_eq!(chosen[0], 10, "the heaviest first: {chosen:?}");
    assert!(chosen.len() == 4 && !(chosen.contains(&5) && chosen.contains(&9)), "{chosen:?}");
}

#[test]
fn the_parts_of_an_error_are_its_variance_at_each_point_and_go_together_at_near_ones() {
    let (space, runs) = runs(14);
    let key = StreamKey::new(1, "surrogate", "fit");
    let mut emulations = Surrogate::fit(&space, &runs, &key).expect("fitted");
    let plain = Surrogate::new(space.clone(), &runs, &emulations).expect("made");
    let points: Vec<Vec<f64>> = (0..12).map(|k| vec![0.3 * f64::from(k) - 1.7, 1.3 - 0.2 * f64::from(k)]).collect();
    let anchors = plain.anchors(&points, 4);
    assert_eq!((anchors[0].len(), anchors[1].len()), (4, 0), "a constant has no error");
    emulations[0].anchors.clone_from(&anchors[0]);
    let surrogate = Surrogate::new(space, &runs, &emulations).expect("made");
    let predicted = surrogate.predicted(&points);
    let covariance = plain.covariance(0, &points);
    let largest = (0..12).map(|k| covariance[k * 12 + k]).fold(0.0, f64::max);
    for (point, own) in points.iter().zip(&predicted[0]) {
        let expected = plain.at(point)[0];
        // The squares of the parts add up to the variance, but for rounding of the factors.
        let square = own.parts.iter().map(|part| part * part).sum::<f64>() + own.rest * own.rest;
        assert!((own.mean - expected.mean).abs() < 1e-9, "{own:?} {expected:?}");
        assert!((square - expected.sd * expected.sd).abs() < 1e-8 * largest, "{own:?} {expected:?}");
        // As it is alone, to the bit.
        assert_eq!(surrogate.predicted(std::slice::from_ref(point))[0][0], *own);
        assert_eq!(surrogate.predicted(std::slice::from_ref(point))[1][0].mean, 5.0);
    }
    // Between anchors and any other point the errors have the covariance of the process.
    for anchor in &anchors[0] {
        let i = points.iter().position(|point| point == anchor).expect("one of them");
        for j in 0..12 {
            let parts = predicted[0][i].parts.iter().zip(&predicted[0][j].parts);
            let together: f64 = parts.map(|(a, b)| a * b).sum();
            assert!((together - covariance[i * 12 + j]).abs() < 1e-8 * largest, "{i} {j} {together}");
        }
    }
    // The greedy choice leaves less than it takes: of twelve points four carry most of the variance.
    let (rest, all): (f64, f64) =
        (predicted[0].iter().map(|own| own.rest * own.rest).sum(), (0..12).map(|k| covariance[k * 12 + k]).sum());
    assert!(rest < 0.5 * all, "{rest} {all}");
}

#[test]
fn slopes_of_a_surrogate_are_those_of_its_differences() {
    use bmv::inference::surrogate::Answers;
    use bmv::thermal::{Evaluator, SlopesAt};
    let (mut space, runs) = runs(14);
    space.axes[0] = Axis { place: 0, centre: 1.0, scale: 0.5, is_log: true, range: None };
    let key = StreamKey::new(1, "surrogate", "fit");
    let mut emulations = Surrogate::fit(&space, &runs, &key).expect("fitted");
    emulations[0].anchors = vec![vec![0.4, 0.7], vec![-0.6, -1.1]];
    let answers = Answers::of(Surrogate::new(space, &runs, &emulations).expect("made"), 3);
    // Two outputs of a mean, three parts (of which the surrogate has two) and a rest; the last parameter is an error.
    let point = |a: f64, x: f64| Point { parameters: vec![a, 7.0, 0.3], inputs: vec![x] };
    let asked = |weights| SlopesAt { point: point(0.83, 0.31), by: vec![0, 2, 3], weights };
    let slopes = answers.slopes(&[asked(None)]).remove(0).expect("an answer");
    assert_eq!(slopes.len(), 30);
    let h = 1e-4;
    let of = |a: f64, x: f64| answers.evaluate(&[point(a, x)]).remove(0).expect("an answer");
    let differences = [(0, of(0.83 - h, 0.31), of(0.83 + h, 0.31)), (2, of(0.83, 0.31 - h), of(0.83, 0.31 + h))];
    for (column, low, high) in differences {
        let scale = slopes.iter().fold(0.0_f64, |most, slope| most.max(slope.abs()));
        for row in 0..10 {
            let difference = (high[row] - low[row]) / (2.0 * h);
            // A central difference errs by h^2 and by the rounding of 300 K over h.
            assert!(
                (slopes[3 * row + column] - difference).abs() < 1e-6 * scale,
                "{row} {column} {difference} {slopes:?}"
            );
        }
    }
    assert!((0..10).all(|row| slopes[3 * row + 1] == 0.0), "errors are no coordinates");
    let weights: Vec<f64> = (0..10).map(|k| 0.5 - 0.1 * f64::from(k)).collect();
    let sum = answers.slopes(&[asked(Some(weights.clone()))]).remove(0).expect("an answer");
    let expected: f64 = weights.iter().enumerate().map(|(row, weight)| weight * slopes[3 * row]).sum();
    assert!((sum[0] - expected).abs() < 1e-12 * expected.abs().max(1.0), "{sum:?} {expected}");
}
