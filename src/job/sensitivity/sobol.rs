//! Rows of Saltelli's design: what a block of them finds.

use super::Sensitivity;
use super::block::{FAILURES_KEPT, Found, OfScramble};
use super::evaluate::{Evaluator, Lanes};
use super::output::FailedSolve;
use crate::job::JobError;
use crate::statistics::sobol_indices::SobolSums;
use crate::thermal::LANES;

/// Batches whose points are drawn at once.
const BATCHES_DRAWN: usize = 16;
/// Rows of the first scramble whose values are kept for a picture.
pub const SAMPLE: usize = 256;

/// The points of a batch of rows: by coordinate, a row a lane, parameters in SI.
struct Rows {
    a: Vec<Lanes>,
    b: Vec<Lanes>,
}

/// The values of a batch: by quantity then point, a row a lane. Points are `a`, `b`, each `ab_j`, each `ba_j`.
struct Values {
    points: usize,
    of: Vec<Lanes>,
}

impl Sensitivity {
    /// Points of a row of the design.
    pub(super) fn points_of_row(&self) -> usize {
        let k = self.uncertain.len();
        2 + if self.spec.second_order { 2 * k } else { k }
    }

    /// Runs rows `first` to `first + count - 1` of a scramble.
    pub(super) fn rows(&self, case: usize, scramble: u64, first: u64, count: u64) -> Result<Found, JobError> {
        let (k, quantities, points) = (self.uncertain.len(), self.spec.quantities.len(), self.points_of_row());
        let (first, count) = (usize::try_from(first).unwrap_or(0), usize::try_from(count).unwrap_or(0));
        let set = &self.points[usize::try_from(scramble).unwrap_or(0)];
        let mut solved = Found { solves: (points * count) as u64, ..Found::default() };
        let mut sums: Vec<SobolSums> =
            self.centres()?[case].iter().map(|&centre| SobolSums::new(k, self.spec.second_order, centre)).collect();
        let kept = if scramble == 0 && first == 0 { SAMPLE.min(count) } else { 0 };
        solved.sample = vec![None; quantities * kept];
        let mut left_out = 0;
        let mut evaluator = Evaluator::new(self, case);
        let mut rows = Rows { a: vec![[0.5; LANES]; k], b: vec![[0.5; LANES]; k] };
        let mut values = Values { points, of: vec![[f64::NAN; LANES]; quantities * points] };
        // Lanes beyond the last row keep a middle value and are not read.
        let mut drawn = vec![0.5; 2 * k * LANES * BATCHES_DRAWN];
        let mut column = vec![0.0; points];
        let (mut done, mut ready) = (0, 0);
        while done < count {
            let lanes = LANES.min(count - done);
            if done == ready {
                ready = count.min(done + LANES * BATCHES_DRAWN);
                set.fill_rows(first + done, &mut drawn[..2 * k * (ready - done)]);
            }
            let offset = done % (LANES * BATCHES_DRAWN);
            // A coordinate of `a` and the same one of `b` stand side by side in the point set: for both estimators the
            // projections of such pairs matter most, and those of neighbouring dimensions are the best.
            for (coordinate, &parameter) in self.uncertain.iter().enumerate() {
                for (half, column) in [(0, &mut rows.a[coordinate]), (1, &mut rows.b[coordinate])] {
                    *column = std::array::from_fn(|lane| drawn[(offset + lane) * 2 * k + 2 * coordinate + half]);
                    self.priors[parameter].quantiles(column);
                }
            }
            evaluator.use_lanes(lanes);
            let context = Context { scramble, row: first + done, lanes };
            self.solve_rows(&context, &mut evaluator, &rows, &mut values, &mut solved);
            for lane in 0..lanes {
                let is_whole = (0..quantities * points).all(|place| values.of[place][lane].is_finite());
                left_out += u64::from(!is_whole);
                for (position, sums) in sums.iter_mut().enumerate() {
                    if !is_whole {
                        continue;
                    }
                    for (place, value) in column.iter_mut().enumerate() {
                        *value = values.of[position * points + place][lane];
                    }
                    let (ab, ba) = column[2..].split_at(k);
                    sums.add(column[0], column[1], ab, ba);
                    if done + lane < kept {
                        solved.sample[position * kept + done + lane] = Some(column[0]);
                    }
                }
            }
            done += lanes;
        }
        solved.scrambles = vec![OfScramble { sums, left_out }];
        Ok(solved)
    }

    /// Solves all points of a batch of rows.
    fn solve_rows(
        &self,
        context: &Context,
        evaluator: &mut Evaluator<'_>,
        rows: &Rows,
        values: &mut Values,
        found: &mut Found,
    ) {
        let k = self.uncertain.len();
        for (base, base_rows, other) in [(0, &rows.a, &rows.b), (1, &rows.b, &rows.a)] {
            for (coordinate, &column) in base_rows.iter().enumerate() {
                evaluator.set(coordinate, column);
            }
            evaluator.solve(None);
            self.take(context, evaluator, base, values, found, rows);
            if base == 1 && !self.spec.second_order {
                continue;
            }
            // A mixed point is close to the one it differs from in a coordinate.
            let start = evaluator.temperatures().to_vec();
            for coordinate in 0..k {
                evaluator.set(coordinate, other[coordinate]);
                evaluator.solve(Some(&start));
                self.take(context, evaluator, 2 + base * k + coordinate, values, found, rows);
                evaluator.set(coordinate, base_rows[coordinate]);
            }
        }
    }

    /// Keeps the values of the last solve as those of a point, and what failed.
    fn take(
        &self,
        context: &Context,
        evaluator: &Evaluator<'_>,
        point: usize,
        values: &mut Values,
        found: &mut Found,
        rows: &Rows,
    ) {
        let mut is_good = [true; LANES];
        for position in 0..self.spec.quantities.len() {
            let column = evaluator.quantity(position);
            is_good.iter_mut().zip(&column).for_each(|(good, value)| *good &= value.is_finite());
            values.of[position * values.points + point] = column;
        }
        for lane in (0..context.lanes).filter(|&lane| !is_good[lane]) {
            found.failed += 1;
            if found.failures.len() < FAILURES_KEPT {
                let place = self.point_in_words(point);
                found.failures.push(FailedSolve {
                    place: format!("row {} of scramble {}, {place}", context.row + lane, context.scramble),
                    parameters: self.named(&self.parameters_of(point, rows, lane)),
                    reason: evaluator.fault(lane),
                });
            }
        }
    }

    fn point_in_words(&self, point: usize) -> String {
        let k = self.uncertain.len();
        let name = |coordinate: usize| &self.model.parameters[self.uncertain[coordinate]].name;
        match point {
            0 => "first point".to_owned(),
            1 => "second point".to_owned(),
            mixed if mixed < 2 + k => format!("first point with {} of the second", name(mixed - 2)),
            mixed => format!("second point with {} of the first", name(mixed - 2 - k)),
        }
    }

    /// The uncertain parameters of a point.
    fn parameters_of(&self, point: usize, rows: &Rows, lane: usize) -> Vec<f64> {
        let k = self.uncertain.len();
        let (base_rows, other) = if point == 1 || point >= 2 + k { (&rows.b, &rows.a) } else { (&rows.a, &rows.b) };
        let changed = point.checked_sub(2).map(|mixed| mixed % k);
        (0..k).map(|j| if changed == Some(j) { other[j][lane] } else { base_rows[j][lane] }).collect()
    }
}

/// Where a batch of rows stands.
struct Context {
    scramble: u64,
    row: usize,
    lanes: usize,
}
