//! Tests of `diagnosis/src/diagnosis/linearisation/between_rows.rs`.

use crate::rooms::diagnosis::screening::fixture::{columns, direction, stream};
use bmv::diagnosis::Problem;
use bmv::diagnosis::linearisation::between_rows::BetweenRows;
use bmv::diagnosis::linearisation::signature::linearise;
use bmv::diagnosis::screening::score::Prepared;
use bmv::document::Diagnostics;
use bmv::effect::Catalogue;
use bmv::inference::likelihood::Course;
use bmv::inference::target::Target;
use bmv::math::dense::dot_of_columns as dot;
use bmv::measurement::{Rows, Uncertain};
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};
use std::sync::Arc;

/// An orbit of which one sensor is white, the second has correlated noise, the third both, the fourth a lag with correlated noise, and the
/// first lacks readings.
fn orbit() -> Problem {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let recipe = Recipe::of(Topology::Star, TestKind::Orbit, InjectionRequest::default());
    let mut problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
    let own = &mut problem.measurements[0];
    let (sensors, rows) = (own.sensors.len(), own.len());
    assert!(sensors >= 4, "{sensors}");
    for (position, sensor) in own.sensors.iter_mut().enumerate() {
        sensor.sigma = Some(Uncertain::Known(0.3));
        sensor.white = (position == 2).then_some(Uncertain::Known(0.2));
        sensor.correlation_time_s = (position > 0).then_some(Uncertain::Known(500.0));
        sensor.lag_s = (position == 3).then_some(Uncertain::Known(90.0));
    }
    for row in [0, 1, 2, 40, 41, rows / 2] {
        own.readings[row * sensors] = None;
    }
    problem
}

/// Kept rows, one in nineteen and the last with a reading.
fn kept(problem: &Problem) -> Vec<usize> {
    let own = &problem.measurements[0];
    let last = (0..own.len())
        .rev()
        .find(|&row| {
            !own.held_out(row)
                && !own.ignored(row)
                && (0..own.sensors.len()).any(|sensor| own.reading(row, sensor).is_some())
        })
        .unwrap();
    (0..last).step_by(19).chain([last]).collect()
}

/// Columns with arbitrary changes at the kept rows: drawn, lagged and whitened row by row, and in coordinates.
#[test]
fn coordinates_are_those_of_columns_drawn_lagged_and_whitened() {
    let problem = orbit();
    assert!(matches!(problem.measurements[0].rows, Rows::Transient { .. }));
    let likelihood = problem.hypothesis(&[], 1.0).unwrap().likelihood(&problem).unwrap();
    let unknowns: Vec<f64> = likelihood.priors().iter().map(|prior| prior.quantile(0.5)).collect();
    let courses: Vec<Course> = likelihood.courses(&unknowns, &[Some(kept(&problem))]).unwrap().unwrap();
    let linear = linearise(&likelihood, &unknowns).unwrap();
    let whitening = likelihood.whitening(&unknowns).unwrap();
    let between = BetweenRows::new(&courses, &whitening, linear.rows, unknowns.len()).unwrap();
    assert!(2 * between.dimensions() < linear.rows, "{} of {}", between.dimensions(), linear.rows);
    let in_coordinates = between.linear(&linear);
    let (whole, small) = (Prepared::new(&linear), Prepared::new(&in_coordinates));
    // What the model's own slopes and residuals have beside the basis is kept.
    for (one, other) in columns(&linear).iter().zip(&columns(&in_coordinates)) {
        assert!((dot(one, one) / dot(other, other) - 1.0).abs() < 1e-12);
        let products = [dot(one, &linear.residuals), dot(other, &in_coordinates.residuals)];
        assert!((products[0] - products[1]).abs() < 1e-9 * products[0].abs().max(1.0), "{products:?}");
    }
    assert!((whole.chi_square() / small.chi_square() - 1.0).abs() < 1e-9);

    let course = &courses[0];
    let times_s = &course.inputs.times_s[..course.rows];
    let mut random = stream("between rows", 0);
    for _ in 0..20 {
        let mut column = vec![0.0; linear.readings];
        let mut coordinates = vec![0.0; between.dimensions()];
        for (position, sensor) in course.sensors.iter().enumerate() {
            let changes: Vec<f64> = course.kept.iter().map(|_| random.normal()).collect();
            between.of_changes(0, position, |place| changes[place], &mut coordinates);
            let mut values: Vec<f64> = (0..course.rows)
                .map(|row| {
                    let after = course.kept.partition_point(|&kept| kept < row);
                    if course.kept[after] == row {
                        return changes[after];
                    }
                    let ends = [course.kept[after - 1], course.kept[after]].map(|kept| times_s[kept]);
                    let share = (times_s[row] - ends[0]) / (ends[1] - ends[0]);
                    changes[after - 1] + share * (changes[after] - changes[after - 1])
                })
                .collect();
            sensor.timing.apply(times_s, &mut values, None);
            for (place, &row) in sensor.rows.iter().enumerate() {
                column[sensor.first + place] = values[row];
            }
        }
        whitening.apply(&mut column).unwrap();
        column.resize(linear.rows, 0.0);
        let rows = between.rows_of(&coordinates);
        let off = rows.iter().zip(&column).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
        assert!(off < 1e-9 * dot(&column, &column).sqrt(), "{off}");
        // So is what the data say of a direction.
        let square = dot(&column, &column);
        assert_eq!(coordinates.len(), in_coordinates.rows);
        let scores = [whole.score(&direction(0, column, 1)), small.score(&direction(0, coordinates.clone(), 1))];
        assert!((dot(&coordinates, &coordinates) / square - 1.0).abs() < 1e-11);
        assert!(scores[0].seen && scores[1].seen);
        assert!((scores[0].z - scores[1].z).abs() < 1e-9, "{} {}", scores[0].z, scores[1].z);
        assert!((scores[0].share - scores[1].share).abs() < 1e-9);
    }
}

#[test]
fn where_every_row_is_kept_coordinates_are_no_gain() {
    let problem = orbit();
    let likelihood = problem.hypothesis(&[], 1.0).unwrap().likelihood(&problem).unwrap();
    let unknowns: Vec<f64> = likelihood.priors().iter().map(|prior| prior.quantile(0.5)).collect();
    let courses = likelihood.courses(&unknowns, &[]).unwrap().unwrap();
    let rows = linearise(&likelihood, &unknowns).unwrap().rows;
    let whitening = likelihood.whitening(&unknowns).unwrap();
    assert_eq!(BetweenRows::new(&courses, &whitening, rows, unknowns.len()), None);
}
