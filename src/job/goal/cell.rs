//! A cell: some knowledge, a design value, and the probability that all requirements are met.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::Goal;
use super::knowledge::{Known, Sharpened};
use crate::job::Parts;
use crate::job::fault::listed;
use crate::job::propagate::Probability;
use crate::job::stored::{split_numbers, with_numbers};
use crate::math::special::normal_cdf;
use crate::statistics::Interval;
use crate::study::variable::Variable;
use crate::thermal::{LANES, SampleBatch, Start};

/// Samples of the prior between parts that are kept; a multiple of the lanes.
const PART: usize = 128;
/// Confidence of intervals.
const CONFIDENCE: f64 = 0.95;

/// What a cell belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Knowledge of the first so many leading parameters with a share of their prior standard deviations, by the given design.
    Level {
        /// How many parameters.
        set: usize,
        /// Share.
        ratio: f64,
    },
    /// The same along the design variable.
    Curve {
        /// How many parameters; 0 for prior knowledge.
        set: usize,
        /// Share.
        ratio: f64,
    },
    /// What an experiment would leave if this truth held, by the given design.
    Truth {
        /// Position of the truth.
        index: usize,
    },
    /// The same along the design variable.
    TruthCurve {
        /// Position of the truth.
        index: usize,
    },
}

/// What a block is to do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// What it belongs to.
    pub role: Role,
    /// Parameters that are known better.
    pub known: Vec<Known>,
    /// Design value; the given one where nothing.
    pub design: Option<f64>,
    /// Number of samples.
    pub samples: u64,
}

/// A cell's result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The cell.
    pub cell: Cell,
    /// Sum over samples of the probability that all requirements are met: 0 or 1 without discrepancies.
    pub met: f64,
    /// Failed solves.
    pub failed: Failed,
}

/// Solves without a result.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Failed {
    /// How many.
    pub count: u64,
    /// The first of them, in words.
    pub first: Option<String>,
}

impl Outcome {
    /// Probability with its interval.
    pub fn probability(&self) -> Probability {
        probability(self.met, self.cell.samples)
    }
}

/// A share of samples with Wilson's interval. Sums that are no whole numbers (with discrepancies) vary less than counts
/// do: the interval of the count rounded up to the next is an upper bound of theirs.
pub fn probability(met: f64, samples: u64) -> Probability {
    let value = met / samples.max(1) as f64;
    let at = |count: f64| Interval::wilson(count as u64, samples, CONFIDENCE);
    let (below, above) = (at(met.floor()), at(met.ceil()));
    Probability { value, lower: below.lower, upper: above.upper }
}

impl Goal {
    /// Values of the requirements' quantities at a range of samples: calls `take` with environment, sample and the values of a
    /// sample by requirement, all NaN where the solution failed or one of them is no finite number. Returns what failed.
    pub(super) fn solve(
        &self,
        known: &[Known],
        design: Option<f64>,
        samples: Range<usize>,
        mut take: impl FnMut(usize, usize, &[f64]),
    ) -> Failed {
        let mut failed = Failed::default();
        let width = self.uncertain.len();
        let sharpened: Vec<Option<Sharpened>> = self
            .uncertain
            .iter()
            .map(|&parameter| {
                let knowledge = known.iter().find(|reading| reading.parameter == parameter)?;
                Some(Sharpened::new(&self.priors[parameter], knowledge))
            })
            .collect();
        let variable = self.spec.design.as_ref().map(|design| design.variable).zip(design);
        let mut rows = vec![0.5; width * LANES];
        let mut batch: SampleBatch = self.network.sample_batch();
        let mut values = vec![0.0; self.spec.requirements.len()];
        let mut columns = vec![[0.0; LANES]; width];
        let mut done = samples.start;
        while done < samples.end {
            let lanes = LANES.min(samples.end - done);
            self.points.fill_rows(done, &mut rows[..width * lanes]);
            for (position, &parameter) in self.uncertain.iter().enumerate() {
                let mut column: [f64; LANES] = std::array::from_fn(|lane| rows[lane * width + position]);
                match &sharpened[position] {
                    Some(sharpened) => column.iter_mut().for_each(|v| *v = sharpened.quantile(*v)),
                    None => self.priors[parameter].quantiles(&mut column),
                }
                columns[position] = column;
            }
            for (case, environment) in self.spec.environments.iter().enumerate() {
                for lane in 0..LANES {
                    batch.set_parameters(&self.network, lane, &self.nominal);
                    batch.set_inputs(&self.network, lane, &environment.inputs);
                }
                for (&parameter, &column) in self.uncertain.iter().zip(&columns) {
                    batch.set_parameter_lanes(parameter, column);
                }
                match variable {
                    Some((Variable::Parameter(index), value)) => batch.set_parameter_lanes(index, [value; LANES]),
                    Some((Variable::Input(index), value)) => {
                        let mut inputs = environment.inputs.clone();
                        inputs[index] = value;
                        (0..LANES).for_each(|lane| batch.set_inputs(&self.network, lane, &inputs));
                    }
                    None => {}
                }
                if self.network.external().is_some() {
                    batch.use_lanes(lanes);
                }
                self.network.solve_samples(&mut batch, Start::Temperatures(&self.starts[case]));
                for lane in 0..lanes {
                    for (value, requirement) in values.iter_mut().zip(&self.spec.requirements) {
                        *value = batch.quantity(&self.network, lane, requirement.quantity);
                    }
                    let quantities = self.spec.requirements.iter().map(|r| &self.model.quantities[r.quantity]);
                    let fault = match batch.outcome(lane) {
                        Err(error) => Some(error.to_string()),
                        Ok(_) => quantities.zip(&values).find_map(|(quantity, &value)| quantity.fault(value)),
                    };
                    if let Some(fault) = fault {
                        failed.count += 1;
                        failed.first.get_or_insert_with(|| {
                            let name = |index: usize| self.model.parameters[index].name.clone();
                            let coordinates =
                                self.uncertain.iter().zip(&columns).map(|(&i, column)| (name(i), column[lane]));
                            let at = listed(&coordinates.collect::<Vec<_>>());
                            format!("environment `{}`, sample {}: {fault} ({at})", environment.name, done + lane)
                        });
                        values.fill(f64::NAN);
                    }
                    take(case, done + lane, &values);
                }
            }
            done += lanes;
        }
        failed
    }

    /// Probability that a value stays within the limits of the requirements of its quantity when a normal discrepancy of
    /// standard deviation `sd` is added; `position` is the quantity's first requirement.
    fn within(&self, position: usize, value: f64, sd: f64) -> f64 {
        let quantity = self.spec.requirements[position].quantity;
        let same = || self.spec.requirements.iter().filter(|requirement| requirement.quantity == quantity);
        if sd <= 0.0 || value.is_nan() {
            return f64::from(u8::from(same().all(|requirement| requirement.met(value))));
        }
        let below = same().filter_map(|requirement| requirement.below).reduce(f64::min);
        let above = same().filter_map(|requirement| requirement.above).reduce(f64::max);
        let below = below.map_or(1.0, |limit| normal_cdf((limit - value) / sd));
        let above = above.map_or(0.0, |limit| normal_cdf((limit - value) / sd));
        (below - above).max(0.0)
    }

    /// Probability that a value meets one requirement when a normal discrepancy is added.
    pub(super) fn meets_alone(&self, position: usize, value: f64, sd: f64) -> f64 {
        let requirement = &self.spec.requirements[position];
        if sd <= 0.0 || value.is_nan() {
            return f64::from(u8::from(requirement.met(value)));
        }
        let below = requirement.below.map_or(1.0, |limit| normal_cdf((limit - value) / sd));
        let above = requirement.above.map_or(0.0, |limit| normal_cdf((limit - value) / sd));
        (below - above).max(0.0)
    }

    /// Standard deviation of the discrepancy of a requirement's quantity.
    pub(super) fn discrepancy_of(&self, position: usize) -> f64 {
        let quantity = self.spec.requirements[position].quantity;
        self.spec
            .discrepancy
            .iter()
            .find(|discrepancy| discrepancy.quantity == quantity)
            .map_or(0.0, |discrepancy| discrepancy.sd)
    }

    /// Probability that all requirements are met by a sample's values; discrepancies of different quantities are independent.
    /// `extra` replaces the discrepancy of one requirement's quantity.
    pub(super) fn meets_all(&self, values: &[f64], extra: Option<(usize, f64)>) -> f64 {
        let requirements = &self.spec.requirements;
        let mut all = 1.0;
        for (position, &value) in values.iter().enumerate() {
            let quantity = requirements[position].quantity;
            if requirements[..position].iter().any(|earlier| earlier.quantity == quantity) {
                continue;
            }
            let replaced = extra.filter(|&(other, _)| requirements[other].quantity == quantity);
            let sd = replaced.map_or_else(|| self.discrepancy_of(position), |(_, sd)| sd);
            all *= self.within(position, value, sd);
        }
        all
    }

    /// Runs a cell.
    pub(super) fn run(&self, cell: &Cell) -> Outcome {
        let samples = usize::try_from(cell.samples).unwrap_or(0);
        // A sample must meet the requirements in every environment.
        let mut met = vec![1.0; samples];
        let failed = self.solve(&cell.known, cell.design, 0..samples, |_, sample, values| {
            met[sample] *= self.meets_all(values, None);
        });
        Outcome { cell: cell.clone(), met: met.iter().sum(), failed }
    }

    /// Values of the given design with prior knowledge, by environment, requirement, sample; and what failed. So many samples
    /// are a part that a kill does not lose.
    pub(super) fn prior_values(&self, parts: &dyn Parts) -> (Vec<Vec<Vec<f64>>>, Failed) {
        let samples = usize::try_from(self.spec.samples).unwrap_or(0);
        let columns = self.spec.environments.len() * self.spec.requirements.len();
        let mut done = 0;
        // Sample after sample, each by environment, then requirement.
        let mut rows: Vec<f64> = Vec::new();
        let mut failed = Failed::default();
        for end in (PART..samples).step_by(PART).rev() {
            let part = parts.find(end as u64).and_then(|bytes| split_numbers::<Failed>(&bytes, "prior").ok());
            if let Some((kept, solved)) = part.filter(|(_, solved)| solved.len() == end * columns) {
                (done, rows, failed) = (end, solved, kept);
                break;
            }
        }
        while done < samples {
            let end = samples.min(done + PART);
            let first = rows.len();
            rows.resize(end * columns, f64::NAN);
            let more = self.solve(&[], None, done..end, |case, sample, values| {
                let at = first + (sample - done) * columns + case * values.len();
                rows[at..at + values.len()].copy_from_slice(values);
            });
            failed.count += more.count;
            failed.first = failed.first.or(more.first);
            done = end;
            if done < samples
                && parts.is_due()
                && let Ok(bytes) = with_numbers(&failed, &rows)
            {
                parts.keep(done as u64, &bytes);
            }
        }
        let requirements = self.spec.requirements.len();
        let column = |place: usize| rows.iter().skip(place).step_by(columns).copied().collect();
        let case = |case: usize| (0..requirements).map(|place| column(case * requirements + place)).collect();
        ((0..self.spec.environments.len()).map(case).collect(), failed)
    }
}
