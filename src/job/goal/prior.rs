//! The given design with prior knowledge: how often each requirement is met, which one drives, which parameters lead.

use serde::{Deserialize, Serialize};

use super::Goal;
use super::cell::{Failed, probability};
use super::output::{Driving, Leading, Met};
use crate::job::Parts;
use crate::job::propagate::Probability;
use crate::math::sort::sort_by;
use crate::statistics::Moments;
use crate::statistics::given_data::main_effect;

/// Halvings of the bracket of the tolerable discrepancy.
const HALVINGS: u32 = 60;

/// What was found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Prior {
    /// All requirements together.
    pub probability: Probability,
    /// Each requirement in each environment.
    pub requirements: Vec<Met>,
    /// The one that is met least often.
    pub driving: Driving,
    /// Parameters by main effect, with their positions in the model.
    pub leading: Vec<(usize, Leading)>,
    /// Tolerable standard deviation of a discrepancy in the driving quantity.
    pub tolerable: Option<f64>,
    /// Failed solves.
    pub failed: Failed,
}

impl Goal {
    /// Solves the prior's samples and looks at them.
    pub(super) fn prior(&self, parts: &dyn Parts) -> Prior {
        let (values, failed) = self.prior_values(parts);
        let samples = usize::try_from(self.spec.samples).unwrap_or(0);
        let at =
            |case: usize, sample: usize| -> Vec<f64> { values[case].iter().map(|column| column[sample]).collect() };
        let met = |extra: Option<(usize, usize, f64)>| -> f64 {
            (0..samples)
                .map(|sample| {
                    (0..values.len())
                        .map(|case| {
                            let extra = extra.filter(|&(c, _, _)| c == case).map(|(_, r, sd)| (r, sd));
                            self.meets_all(&at(case, sample), extra)
                        })
                        .product::<f64>()
                })
                .sum()
        };
        let all = probability(met(None), self.spec.samples);
        let (mut requirements, mut worst) = (Vec::new(), (0, 0, f64::INFINITY, f64::INFINITY));
        for (case, environment) in self.spec.environments.iter().enumerate() {
            for (position, requirement) in self.spec.requirements.iter().enumerate() {
                let sd = self.discrepancy_of(position);
                let column = &values[case][position];
                let count: f64 = column.iter().map(|&value| self.meets_alone(position, value, sd)).sum();
                let finite: Vec<f64> = column.iter().copied().filter(|value| value.is_finite()).collect();
                let moments = Moments::of(&finite);
                let met_probability = probability(count, self.spec.samples);
                // Where two are met equally often, the one with fewer standard deviations to its limit drives.
                let distance = |limit: f64| (limit - moments.mean()).abs() / moments.sd().max(f64::MIN_POSITIVE);
                let distance = requirement.below.into_iter().chain(requirement.above).map(distance);
                let distance = distance.fold(f64::INFINITY, f64::min);
                if met_probability.value < worst.2 || met_probability.value == worst.2 && distance < worst.3 {
                    worst = (case, position, met_probability.value, distance);
                }
                requirements.push(Met {
                    requirement: requirement.name.clone(),
                    environment: environment.name.clone(),
                    quantity: self.model.quantities[requirement.quantity].name.clone(),
                    probability: met_probability,
                    mean: if finite.is_empty() { 0.0 } else { moments.mean() },
                    sd: if finite.len() < 2 { 0.0 } else { moments.sd() },
                });
            }
        }
        let (case, position, ..) = worst;
        let requirement = &self.spec.requirements[position];
        let quantity = &self.model.quantities[requirement.quantity];
        Prior {
            probability: all,
            requirements,
            driving: Driving {
                requirement: requirement.name.clone(),
                environment: self.spec.environments[case].name.clone(),
                quantity: quantity.name.clone(),
                unit: quantity.unit.clone(),
                is_temperature: quantity.is_temperature,
            },
            leading: self.leading(&values[case][position]),
            tolerable: self.tolerable(all.value, |sd| met(Some((case, position, sd))) / samples.max(1) as f64),
            failed,
        }
    }

    /// Parameters by their main effect on a column of values.
    fn leading(&self, values: &[f64]) -> Vec<(usize, Leading)> {
        let width = self.uncertain.len();
        let mut rows = vec![0.0; width * values.len()];
        self.points.fill_rows(0, &mut rows);
        let mut leading: Vec<(usize, Leading)> = self
            .uncertain
            .iter()
            .enumerate()
            .map(|(position, &index)| {
                let probabilities: Vec<f64> = rows.iter().skip(position).step_by(width).copied().collect();
                let (parameter, prior) = (&self.model.parameters[index], &self.priors[index]);
                let leading = Leading {
                    parameter: parameter.name.clone(),
                    unit: parameter.unit.clone(),
                    mean: prior.mean(),
                    sd: prior.sd(),
                    main: main_effect(&probabilities, values),
                };
                (index, leading)
            })
            .collect();
        let size = |entry: &(usize, Leading)| entry.1.main.map_or(f64::NEG_INFINITY, |main| main.value);
        sort_by(&mut leading, |a, b| size(b).total_cmp(&size(a)));
        leading
    }

    /// The largest discrepancy that leaves the required probability; `met` gives the probability for one.
    fn tolerable(&self, without: f64, met: impl Fn(f64) -> f64) -> Option<f64> {
        if without < self.required {
            return None;
        }
        let (mut low, mut high) = (0.0, 1.0);
        while met(high) >= self.required && high < 1e9 {
            (low, high) = (high, 2.0 * high);
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if met(middle) >= self.required { low = middle } else { high = middle }
        }
        Some(low)
    }
}
