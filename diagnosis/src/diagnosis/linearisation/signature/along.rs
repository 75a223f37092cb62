//! Directions of smooth effects on nodes over long records: responses of the network linearised along its course.
//!
//! At fixed temperatures a unit of an amplitude is a heat `q` into some nodes, which is known along the course of the baseline
//! model (`slopes`); `C dT' = J dT + q` tells what it does to the temperatures. Of each step between kept rows
//! `q` is the line with the mean and the first moment that it has over all rows in between. So effects share every
//! factorisation, and cost two solves a step.

use std::collections::BTreeMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::added_node::Added;
use super::adjoint::Phases;
use super::probe::share;
use super::slopes::{Bench, Outputs, Room, Slopes};
use super::variant::{self, Variant};
use super::{Base, Found};
use crate::diagnosis::FitError;
use crate::diagnosis::error::NoDirection;
use crate::diagnosis::linearisation::between_rows::BetweenRows;
use crate::diagnosis::linearisation::linear::Direction;
use crate::inference::likelihood::Course;
use crate::measurement::InputTable;
use crate::thermal::transient::linearised::{AddedNode, EARLY};

/// Amplitudes that respond together.
const TOGETHER: usize = 64;

/// Variants whose outputs are one program: what they are along the courses is held for all of them.
const PROGRAM: usize = 512;

/// The courses of all transients at the fit, and the steady phases.
pub struct Courses {
    courses: Vec<Course>,
    phases: Phases,
    parameters: Vec<f64>,
    /// Where records are long.
    coordinates: Option<Arc<BetweenRows>>,
}

/// What the outputs of a program are along a course.
struct Forcing {
    /// At the start, by output.
    start: Vec<f64>,
    /// At the first stage of each step, `steps x outputs`.
    early: Vec<f64>,
    /// At the end of each step.
    late: Vec<f64>,
    /// Values of those that change readings at fixed temperatures, in all rows.
    direct: BTreeMap<usize, Vec<f64>>,
}

impl Courses {
    /// `None` where a transient cannot be linearised, or its course cannot be had.
    pub fn new(base: &Base<'_>, kept: &[Option<Vec<usize>>]) -> Option<Self> {
        let courses = base.likelihood.courses(base.unknowns, kept).ok().flatten()?;
        let phases = Phases::new(base.likelihood, base.unknowns).ok()?;
        let coordinates = BetweenRows::new(&courses, &base.whitening, base.rows, base.unknowns.len()).map(Arc::new);
        Some(Self { courses, phases, parameters: base.likelihood.full_parameters(base.unknowns), coordinates })
    }

    /// Adds the directions of variants to what was found of their candidates, in coordinates where these stand for the rows.
    pub fn directions(&self, base: &Base<'_>, variants: &[Variant<'_>], directions: &mut [Found]) {
        for block in variants.chunks(PROGRAM) {
            self.directions_of(base, block, directions);
        }
    }

    /// The directions of added nodes, a share of each, in coordinates where these stand for the rows. There are no steady phases.
    pub fn directions_of_nodes(&self, base: &Base<'_>, added: &[Added]) -> Vec<Found> {
        let nodes: Vec<AddedNode> = added.iter().flat_map(|own| &own.probes).map(|(_, node)| node.clone()).collect();
        let changes: Vec<Vec<Vec<f64>>> = (self.courses.iter())
            .map(|course| {
                let lines = lines(course);
                nodes.par_chunks(TOGETHER).map(|some| changes_by_nodes(course, &lines, some)).collect()
            })
            .collect();
        let shares: Vec<Vec<f64>> = self.courses.iter().map(shares).collect();
        let column = |position: usize| -> Result<Vec<f64>, FitError> {
            if let Some(coordinates) = &self.coordinates {
                return Ok(self.in_coordinates(coordinates, &changes, nodes.len(), position));
            }
            let mut column = Vec::with_capacity(base.rows);
            column.resize(base.residuals.len(), 0.0);
            for ((course, shares), changes) in self.courses.iter().zip(&shares).zip(&changes) {
                let own = OwnChanges::new(changes, nodes.len(), position);
                draw((course, shares), Some(&own), &|_| None, &mut column);
            }
            base.whitening.apply(&mut column)?;
            column.resize(base.rows, 0.0);
            Ok(column)
        };
        let ends: Vec<usize> = added
            .iter()
            .scan(0, |end, own| {
                *end += own.probes.len();
                Some(*end)
            })
            .collect();
        let of_candidate = |(own, &end): (&Added, &usize)| {
            let mut found: Vec<Direction> = Vec::new();
            for (position, (values, _)) in (end - own.probes.len()..end).zip(&own.probes) {
                let columns: Vec<f64> = column(position)?;
                if columns.iter().all(|value| value.is_finite()) && columns.iter().any(|value| *value != 0.0) {
                    let direction = share(own.candidate, columns, values.clone());
                    found.push(Direction { coordinates: self.coordinates.clone(), ..direction });
                }
            }
            if found.is_empty() { Err(NoDirection::NoReading.into()) } else { Ok(found) }
        };
        added.par_iter().zip(&ends).map(of_candidate).collect()
    }

    /// What an amplitude of some, by transient, does to the readings of the transients.
    fn in_coordinates(
        &self,
        coordinates: &BetweenRows,
        changes: &[Vec<Vec<f64>>],
        all: usize,
        position: usize,
    ) -> Vec<f64> {
        let mut column = vec![0.0; coordinates.dimensions()];
        for (transient, (course, changes)) in self.courses.iter().zip(changes).enumerate() {
            let own = OwnChanges::new(changes, all, position);
            for sensor in 0..course.sensors.len() {
                coordinates.of_changes(transient, sensor, |place| own.of(course, sensor, place), &mut column);
            }
        }
        column
    }

    fn directions_of(&self, base: &Base<'_>, variants: &[Variant<'_>], directions: &mut [Found]) {
        let mut bench = Bench::new(&base.problem.model);
        let slopes: Vec<Result<Vec<Slopes>, FitError>> =
            variants.iter().map(|variant| bench.slopes(base, variant)).collect();
        let outputs = bench.outputs();
        let program = bench.into_outputs(&self.parameters);
        let all: Vec<&Slopes> = slopes.iter().flatten().flatten().collect();
        let stored: BTreeMap<usize, usize> =
            all.iter().flat_map(|own| own.capacities.iter().map(|&(node, output)| (output, node))).collect();
        let direct: Vec<usize> = (all.iter())
            .flat_map(|own| own.quantities.iter().map(|one| one.1).chain(own.readings.iter().map(|one| one.1)))
            .collect();
        let forcings: Vec<Forcing> =
            self.courses.iter().map(|course| forcing(course, &program, outputs, &stored, &direct)).collect();
        let steady = self.phases.values(&program, outputs);
        // Of what adds no heat the temperatures know nothing.
        let adds_heat = |own: &&&Slopes| !own.heats.is_empty() || !own.capacities.is_empty();
        let heating: Vec<&Slopes> = all.iter().filter(adds_heat).copied().collect();
        let mut next = 0;
        let places: Vec<Option<usize>> = (all.iter())
            .map(|own| {
                let place = adds_heat(&own).then_some(next);
                next += usize::from(place.is_some());
                place
            })
            .collect();
        // On kept rows alone: all rows of all amplitudes at once would be many times what is kept of them.
        let changes: Vec<Vec<Vec<f64>>> = (self.courses.iter().zip(&forcings))
            .map(|(course, forcing)| heating.par_chunks(TOGETHER).map(|some| changes(course, forcing, some)).collect())
            .collect();
        let shares: Vec<Vec<f64>> = self.courses.iter().map(shares).collect();
        let column = |position: usize| {
            let mut column = Vec::with_capacity(base.rows);
            column.resize(base.residuals.len(), 0.0);
            self.phases.column(base, all[position], &steady, &mut column);
            for (((course, shares), forcing), changes) in self.courses.iter().zip(&shares).zip(&forcings).zip(&changes)
            {
                let at_fixed_temperatures = |sensor: usize| {
                    // The course knows the quantities of its network alone, the slopes those of the model.
                    let of_model = &base.problem.measurements[course.measurement].sensors[sensor];
                    let output = all[position].of_sensor(&of_model.name, of_model.quantity)?;
                    forcing.direct.get(&output).map(Vec::as_slice)
                };
                let own = places[position].map(|place| OwnChanges::new(changes, heating.len(), place));
                draw((course, shares), own.as_ref(), &at_fixed_temperatures, &mut column);
            }
            base.whitening.apply(&mut column)?;
            Ok(column)
        };
        let in_coordinates = |coordinates: &BetweenRows, position: usize| {
            let mut column = match places[position] {
                Some(place) => self.in_coordinates(coordinates, &changes, heating.len(), place),
                None => vec![0.0; coordinates.dimensions()],
            };
            if coordinates.has_own_readings(base.residuals.len()) {
                let mut readings = vec![0.0; base.residuals.len()];
                self.phases.column(base, all[position], &steady, &mut readings);
                base.whitening.apply(&mut readings)?;
                coordinates.of_own_rows(&readings, &mut column);
            }
            Ok(column)
        };
        let mut first = 0;
        let firsts: Vec<usize> = (slopes.iter())
            .map(|own| {
                let own_first = first;
                first += own.as_ref().map_or(0, Vec::len);
                own_first
            })
            .collect();
        let found: Vec<Result<Option<Direction>, FitError>> = (variants.par_iter().zip(&slopes).zip(&firsts))
            .map(|((variant, own), &first)| {
                let own = own.as_ref().map_err(Clone::clone)?;
                // What changes readings at fixed temperatures changes them in every row.
                let is_drawn = own.iter().all(|slopes| slopes.quantities.is_empty() && slopes.readings.is_empty());
                let coordinates = self.coordinates.as_ref().filter(|_| is_drawn);
                let of_position = |position: usize| match coordinates {
                    Some(coordinates) => in_coordinates(coordinates, position),
                    None => column(position),
                };
                let columns = (first..first + own.len()).map(of_position).collect::<Result<Vec<Vec<f64>>, FitError>>();
                let rows = coordinates.map_or(base.rows, |coordinates| coordinates.dimensions());
                let direction = variant.direction(rows, columns?.into_iter())?;
                Ok(direction.map(|direction| Direction { coordinates: coordinates.cloned(), ..direction }))
            })
            .collect();
        for (variant, direction) in variants.iter().zip(found) {
            variant::put(&mut directions[variant.asked], direction);
        }
    }
}

/// What some added nodes do to the quantities of the sensors of a transient, `sensors x kept rows x nodes`, SI.
fn changes_by_nodes(course: &Course, lines: &[Vec<[f64; 2]>], nodes: &[AddedNode]) -> Vec<f64> {
    let (count, kept) = (nodes.len(), course.kept.len());
    let mut changes = vec![0.0; course.sensors.len() * kept * count];
    course.linearised.respond_to_nodes(
        nodes,
        &|node| course.temperatures[node],
        &|step, node| lines[step][node],
        &mut |place, field| observe(course, place, (count, field), &mut changes),
    );
    changes
}

/// By step between kept rows and node the temperatures at the first stage and at the end, K, of the line with the mean and the first
/// moment over all rows in between.
fn lines(course: &Course) -> Vec<Vec<[f64; 2]>> {
    let nodes = course.temperatures.len() / course.rows.max(1);
    let times_s = &course.inputs.times_s;
    let of_step = |ends: &[usize]| -> Vec<[f64; 2]> {
        let mut line = Line::new(nodes, times_s[ends[0]], times_s[ends[1]]);
        for row in ends[0]..ends[1] {
            let (left, right) = course.temperatures[row * nodes..(row + 2) * nodes].split_at(nodes);
            line.add([times_s[row], times_s[row + 1]], left, right);
        }
        let (early, late) = line.ends();
        early.into_iter().zip(late).map(|(early, late)| [early, late]).collect()
    };
    course.kept.windows(2).map(of_step).collect()
}

/// Lines with the mean and the first moment that values have over a step.
struct Line {
    from_s: f64,
    to_s: f64,
    mean: Vec<f64>,
    moment: Vec<f64>,
}

impl Line {
    fn new(count: usize, from_s: f64, to_s: f64) -> Self {
        Self { from_s, to_s, mean: vec![0.0; count], moment: vec![0.0; count] }
    }

    /// Adds a part of the step, over which values are linear.
    fn add(&mut self, [from_s, to_s]: [f64; 2], left: &[f64], right: &[f64]) {
        let middle = 0.5 * (self.to_s + self.from_s);
        let (span, before, after) = (to_s - from_s, from_s - middle, to_s - middle);
        let sums = self.mean.iter_mut().zip(&mut self.moment);
        for ((mean, moment), (left, right)) in sums.zip(left.iter().zip(right)) {
            *mean += 0.5 * span * (left + right);
            *moment += span * ((before * left + after * right) / 3.0 + (before * right + after * left) / 6.0);
        }
    }

    /// Their values at the first stage and at the end of the step.
    fn ends(self) -> (Vec<f64>, Vec<f64>) {
        let length = self.to_s - self.from_s;
        let (mut early, mut late) = (self.mean, self.moment);
        for (mean, moment) in early.iter_mut().zip(&mut late) {
            // The line with this mean and this moment about the middle rises by so much over the step.
            let (level, rise) = (*mean / length, 12.0 * *moment / (length * length));
            (*mean, *moment) = (level + (EARLY - 0.5) * rise, level + 0.5 * rise);
        }
        (early, late)
    }
}

/// Writes what temperatures at a kept row, `unknowns x columns`, do to the quantities of the sensors there.
fn observe(course: &Course, place: usize, (count, field): (usize, &[f64]), changes: &mut [f64]) {
    for (sensor, own) in course.sensors.iter().enumerate() {
        let first = (sensor * course.kept.len() + place) * count;
        course.linearised.observe(place, own.quantity, count, field, &mut changes[first..first + count]);
    }
}

/// What some amplitudes do to the quantities of the sensors of a transient, `sensors x kept rows x amplitudes`, SI.
fn changes(course: &Course, forcing: &Forcing, some: &[&Slopes]) -> Vec<f64> {
    let (count, linearised) = (some.len(), &course.linearised);
    let outputs = forcing.start.len();
    let add = |field: &mut [f64], values: &[f64]| {
        for (column, slopes) in some.iter().enumerate() {
            for &(node, output) in slopes.heats.iter().chain(&slopes.capacities) {
                if let Some(unknown) = linearised.unknown(node) {
                    field[unknown * count + column] += values[output];
                }
            }
        }
    };
    let kept = course.kept.len();
    let mut changes = vec![0.0; course.sensors.len() * kept * count];
    linearised.respond(
        count,
        &mut |field| add(field, &forcing.start),
        &mut |step, early, late| {
            let own = step * outputs..(step + 1) * outputs;
            add(early, &forcing.early[own.clone()]);
            add(late, &forcing.late[own]);
        },
        &mut |place, field| observe(course, place, (count, field), &mut changes),
    );
    changes
}

/// What an amplitude does to the quantities of the sensors of a transient on kept rows.
struct OwnChanges<'a> {
    /// The same of some amplitudes.
    of_some: &'a [f64],
    /// How many these are.
    count: usize,
    /// Its place among them.
    position: usize,
}

impl<'a> OwnChanges<'a> {
    /// Of the amplitude at a position among `all`.
    fn new(changes: &'a [Vec<f64>], all: usize, position: usize) -> Self {
        let block = position / TOGETHER;
        Self { of_some: &changes[block], count: TOGETHER.min(all - block * TOGETHER), position: position % TOGETHER }
    }

    fn of(&self, course: &Course, sensor: usize, place: usize) -> f64 {
        self.of_some[(sensor * course.kept.len() + place) * self.count + self.position]
    }
}

/// Draws what an amplitude does to the readings of a transient: straight between its changes on kept rows, where there are any, with what
/// it does to those of a sensor at fixed temperatures, by row. `shares` says how far each row lies on the way to the next kept one.
fn draw<'a>(
    (course, shares): (&Course, &[f64]),
    changes: Option<&OwnChanges<'_>>,
    at_fixed_temperatures: &dyn Fn(usize) -> Option<&'a [f64]>,
    column: &mut [f64],
) {
    let times_s = &course.inputs.times_s[..course.rows];
    let mut values = vec![0.0; course.rows];
    for (sensor, own) in course.sensors.iter().enumerate() {
        let direct = at_fixed_temperatures(sensor);
        match changes {
            Some(changes) => {
                let change = |place: usize| changes.of(course, sensor, place);
                for (place, ends) in course.kept.windows(2).enumerate() {
                    let (from, to) = (change(place), change(place + 1));
                    let (first, last) = (ends[0], ends[1]);
                    for (value, share) in values[first..last].iter_mut().zip(&shares[first..last]) {
                        *value = from + (to - from) * share;
                    }
                    values[last] = to;
                }
            }
            None if direct.is_none() => continue,
            None => values.fill(0.0),
        }
        for (value, direct) in values.iter_mut().zip(direct.into_iter().flatten()) {
            *value += direct;
        }
        own.timing.apply(times_s, &mut values, None);
        for (place, &row) in own.rows.iter().enumerate() {
            column[own.first + place] = values[row];
        }
    }
}

/// Of each row the share of the way from the kept row before it to the one after.
fn shares(course: &Course) -> Vec<f64> {
    let times_s = &course.inputs.times_s[..course.rows];
    let mut shares = vec![0.0; course.rows];
    for ends in course.kept.windows(2) {
        let (from, span) = (times_s[ends[0]], times_s[ends[1]] - times_s[ends[0]]);
        for row in ends[0]..ends[1] {
            shares[row] = (times_s[row] - from) / span;
        }
    }
    shares
}

/// Inputs of a row, as they hold at the start of the interval after it, or at the end of the one before.
fn inputs_at(table: &InputTable, row: usize, ends_interval: bool, out: &mut Vec<f64>) {
    out.clone_from(&table.base);
    for column in &table.columns {
        let of = if column.hold && ends_interval { row.saturating_sub(1) } else { row };
        if let (Some(slot), Some(&value)) = (out.get_mut(column.input), column.values.get(of)) {
            *slot = value;
        }
    }
}

/// The outputs of a program along a course. Those `stored` are capacities of nodes, which take heat as the node gets warmer;
/// those `direct` are wanted in all rows.
fn forcing(
    course: &Course,
    program: &Outputs,
    outputs: usize,
    stored: &BTreeMap<usize, usize>,
    direct: &[usize],
) -> Forcing {
    let times_s = &course.inputs.times_s;
    let nodes = course.temperatures.len() / course.rows.max(1);
    let temperatures = |row: usize| &course.temperatures[row * nodes..(row + 1) * nodes];
    let value = |room: &mut Room, row: usize, ends_interval: bool, out: &mut [f64]| {
        let mut inputs = Vec::new();
        inputs_at(&course.inputs, row, ends_interval, &mut inputs);
        program.evaluate(room, &inputs, times_s[row], temperatures(row), &mut |output, value| out[output] = value);
    };
    let of_step = |room: &mut Room, ends: &[usize]| {
        let (from, to) = (ends[0], ends[1]);
        let mut line = Line::new(outputs, times_s[from], times_s[to]);
        let (mut left, mut right) = (vec![0.0; outputs], vec![0.0; outputs]);
        for row in from..to {
            value(room, row, false, &mut left);
            value(room, row + 1, true, &mut right);
            let span = times_s[row + 1] - times_s[row];
            for (&output, &node) in stored {
                let rate = (temperatures(row + 1)[node] - temperatures(row)[node]) / span;
                left[output] *= -rate;
                right[output] *= -rate;
            }
            line.add([times_s[row], times_s[row + 1]], &left, &right);
        }
        line.ends()
    };
    let steps: Vec<(Vec<f64>, Vec<f64>)> = course
        .kept
        .windows(2)
        .collect::<Vec<&[usize]>>()
        .into_par_iter()
        .map_init(|| program.room(), |room, ends| of_step(room, ends))
        .collect();
    let mut room = program.room();
    let mut start = vec![0.0; outputs];
    value(&mut room, 0, false, &mut start);
    stored.keys().for_each(|&output| start[output] = 0.0);
    let mut rows: BTreeMap<usize, Vec<f64>> = direct.iter().map(|&output| (output, vec![0.0; course.rows])).collect();
    if !rows.is_empty() {
        let mut at = vec![0.0; outputs];
        for row in 0..course.rows {
            // A reading at the instant at which a held input steps belongs to the interval that ends there.
            value(&mut room, row, true, &mut at);
            rows.iter_mut().for_each(|(&output, values)| values[row] = at[output]);
        }
    }
    let (early, late): (Vec<Vec<f64>>, Vec<Vec<f64>>) = steps.into_iter().unzip();
    Forcing { start, early: early.concat(), late: late.concat(), direct: rows }
}
