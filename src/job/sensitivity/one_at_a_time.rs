//! Derivatives at the nominal parameters, mean squared derivatives, elementary effects.

use super::block::{FAILURES_KEPT, Found, Squares};
use super::evaluate::{Evaluator, Lanes};
use super::output::{FailedSolve, Local};
use super::{JobError, Sensitivity};
use crate::statistics::Moments;
use crate::statistics::elementary_effects::Trajectory;
use crate::statistics::poincare::Poincare;
use crate::thermal::LANES;
use crate::thermal::{Start, Workspace};

impl Sensitivity {
    /// Derivatives of the settings' quantities at parameters, by quantity then uncertain parameter.
    fn derivatives(
        &self,
        case: usize,
        workspace: &mut Workspace,
        parameters: &[f64],
        out: &mut [f64],
    ) -> Result<(), String> {
        let network = &self.differentiated;
        network.set_parameters(workspace, parameters);
        network.set_inputs(workspace, &self.spec.environments[case].inputs);
        network.solve_steady(workspace, Start::Temperatures(&self.starts[case])).map_err(|e| e.to_string())?;
        network.quantity_tangent(workspace, out).map_err(|e| e.to_string())
    }

    /// Exact derivatives at the nominal parameters.
    pub(super) fn local(&self, case: usize) -> Result<Found, JobError> {
        let k = self.uncertain.len();
        let mut workspace = self.differentiated.workspace();
        let mut tangent = vec![0.0; self.differentiated.quantities() * k];
        self.derivatives(case, &mut workspace, &self.nominal, &mut tangent).map_err(JobError::Failed)?;
        let centres = self.centres()?;
        let finite = |value: f64| Some(value).filter(|value| value.is_finite());
        let mut local = Vec::new();
        for (position, &quantity) in self.spec.quantities.iter().enumerate() {
            let value = centres[case][position];
            for (coordinate, &parameter) in self.uncertain.iter().enumerate() {
                let derivative = tangent[quantity * k + coordinate];
                local.push(Local {
                    derivative: finite(derivative),
                    scaled_by_value: finite(derivative * self.nominal[parameter] / value),
                    scaled_by_sd: finite(derivative * self.priors[parameter].sd()),
                });
            }
        }
        Ok(Found { solves: 1, local, ..Found::default() })
    }

    /// Sums of squared derivatives at the first points of a scramble.
    pub(super) fn squares(&self, case: usize, scramble: u64, count: u64) -> Found {
        let (k, quantities) = (self.uncertain.len(), self.spec.quantities.len());
        let set = &self.points[usize::try_from(scramble).unwrap_or(0)];
        let constants: Vec<Poincare> = self.uncertain.iter().map(|&p| Poincare::of(&self.priors[p])).collect();
        let mut workspace = self.differentiated.workspace();
        let mut tangent = vec![0.0; self.differentiated.quantities() * k];
        let mut row = vec![0.0; 2 * k];
        let mut parameters = self.nominal.clone();
        let mut squares =
            Squares { weighted: vec![0.0; quantities * k], plain: vec![0.0; quantities * k], ..Squares::default() };
        let mut values = vec![Vec::new(); quantities];
        let mut derivatives = Found { solves: count, ..Found::default() };
        for index in 0..count {
            set.fill_row(usize::try_from(index).unwrap_or(0), &mut row);
            for (coordinate, &parameter) in self.uncertain.iter().enumerate() {
                parameters[parameter] = self.priors[parameter].quantile(row[2 * coordinate]);
            }
            let solved = self.derivatives(case, &mut workspace, &parameters, &mut tangent);
            let of = |quantity: usize| self.differentiated.quantity(&workspace, quantity);
            let is_finite = |&quantity: &usize| {
                of(quantity).is_finite() && tangent[quantity * k..(quantity + 1) * k].iter().all(|d| d.is_finite())
            };
            let fault = match solved {
                Err(reason) => Some(reason),
                Ok(()) if self.spec.quantities.iter().all(is_finite) => None,
                Ok(()) => Some("a derivative is not a finite number".to_owned()),
            };
            if let Some(reason) = fault {
                derivatives.failed += 1;
                if derivatives.failures.len() < FAILURES_KEPT {
                    let place = format!("derivatives at point {index} of scramble {scramble}");
                    let values_at_point: Vec<f64> = self.uncertain.iter().map(|&p| parameters[p]).collect();
                    derivatives.failures.push(FailedSolve { place, parameters: self.named(&values_at_point), reason });
                }
                continue;
            }
            squares.points += 1;
            for (position, &quantity) in self.spec.quantities.iter().enumerate() {
                values[position].push(of(quantity));
                for (coordinate, &parameter) in self.uncertain.iter().enumerate() {
                    let derivative = tangent[quantity * k + coordinate];
                    let place = position * k + coordinate;
                    squares.weighted[place] += constants[coordinate].weighted_square(parameters[parameter], derivative);
                    squares.plain[place] += derivative * derivative;
                }
            }
        }
        squares.moments = values
            .iter()
            .map(|values| {
                let moments = Moments::of(values);
                // Fewer than two points are not used; not a number could not be stored.
                if values.len() < 2 { [0.0; 2] } else { [moments.mean(), moments.variance()] }
            })
            .collect();
        derivatives.squares = vec![squares];
        derivatives
    }

    /// Elementary effects of trajectories `first` to `first + count - 1`.
    pub(super) fn trajectories(&self, case: usize, first: u64, count: u64) -> Found {
        let (k, quantities) = (self.uncertain.len(), self.spec.quantities.len());
        let mut trajectories = Found { solves: count * (k as u64 + 1), ..Found::default() };
        let mut next = first;
        while next < first + count {
            let lanes = usize::try_from(first + count - next).unwrap_or(LANES).min(LANES);
            let paths: Vec<Trajectory> =
                (0..LANES as u64).map(|lane| Trajectory::new(&self.trajectory_key, next + lane, k)).collect();
            let mut evaluator = Evaluator::new(self, case);
            evaluator.use_lanes(lanes);
            let mut at: Vec<Lanes> = (0..k).map(|j| std::array::from_fn(|lane| paths[lane].start[j])).collect();
            let mut effects = vec![[f64::NAN; LANES]; quantities * k];
            let mut before: Vec<Lanes> = Vec::new();
            let mut is_good = [true; LANES];
            for step in 0..=k {
                if let Some(step) = step.checked_sub(1) {
                    for (lane, path) in paths.iter().enumerate() {
                        let coordinate = path.order[step];
                        at[coordinate][lane] += path.step(coordinate);
                    }
                }
                for (coordinate, probabilities) in at.iter().enumerate() {
                    let mut values = *probabilities;
                    self.priors[self.uncertain[coordinate]].quantiles(&mut values);
                    evaluator.set(coordinate, values);
                }
                evaluator.solve(None);
                let now: Vec<Lanes> = (0..quantities).map(|position| evaluator.quantity(position)).collect();
                for lane in 0..lanes {
                    if now.iter().all(|values| values[lane].is_finite()) {
                        continue;
                    }
                    trajectories.failed += 1;
                    is_good[lane] = false;
                    if trajectories.failures.len() < FAILURES_KEPT {
                        let values_at_point: Vec<f64> =
                            (0..k).map(|j| self.priors[self.uncertain[j]].quantile(at[j][lane])).collect();
                        trajectories.failures.push(FailedSolve {
                            place: format!("trajectory {}, step {step}", next + lane as u64),
                            parameters: self.named(&values_at_point),
                            reason: evaluator.fault(lane),
                        });
                    }
                }
                if let Some(step) = step.checked_sub(1) {
                    for (lane, path) in paths.iter().enumerate() {
                        let coordinate = path.order[step];
                        for position in 0..quantities {
                            effects[position * k + coordinate][lane] =
                                (now[position][lane] - before[position][lane]) / path.step(coordinate);
                        }
                    }
                }
                before = now;
            }
            for lane in 0..lanes {
                if is_good[lane] {
                    trajectories.morris.extend(effects.iter().map(|effect| effect[lane]));
                } else {
                    trajectories.trajectories_left_out += 1;
                }
            }
            next += lanes as u64;
        }
        trajectories
    }
}
