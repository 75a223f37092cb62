//! All that was found, to the result.

use super::Sensitivity;
use super::block::{Found, Squares};
use super::output::{
    Case, DerivativeBound, Index, Local, Method, OfQuantity, Output, PairEffect, Parameter, Precision, Scatter, Sobol,
};
use super::sobol::SAMPLE;
use crate::job::JobError;
use crate::math::sort::sort_by;
use crate::statistics::elementary_effects::ElementaryEffect;
use crate::statistics::sobol_indices::{Estimate, SobolIndices, SobolSums, pairs, places};

/// Parameters of a scatter plot.
const SCATTERED: usize = 2;

/// Estimates of a list of indices from those of each scramble.
fn estimates(scrambles: &[SobolIndices], of: impl Fn(&SobolIndices) -> &[f64]) -> Vec<Estimate> {
    let count = scrambles.first().map_or(0, |first| of(first).len());
    (0..count)
        .map(|place| Estimate::of(&scrambles.iter().map(|indices| of(indices)[place]).collect::<Vec<_>>()))
        .collect()
}

impl Sensitivity {
    /// The widest interval of any main or total effect; infinite where one has no end.
    pub(super) fn widest(&self, found: &[Found]) -> f64 {
        let mut widest: f64 = 0.0;
        for case in found {
            for position in 0..self.spec.quantities.len() {
                let Some(indices) = indices_of(case, position) else { continue };
                for estimate in estimates(&indices, |i| &i.main).iter().chain(&estimates(&indices, |i| &i.total)) {
                    // Written so that a NaN counts as wide.
                    if !(estimate.width() <= widest) {
                        widest = estimate.width();
                    }
                }
            }
        }
        widest
    }

    /// The result.
    pub(super) fn output(&self, found: &[Found], samples: u64) -> Result<Output, JobError> {
        let parameters = self
            .uncertain
            .iter()
            .map(|&index| {
                let parameter = &self.model.parameters[index];
                Parameter {
                    name: parameter.name.clone(),
                    unit: parameter.unit.clone(),
                    nominal: self.nominal[index],
                    sd: self.priors[index].sd(),
                }
            })
            .collect();
        let precision = self.spec.precision.filter(|_| self.spec.has(Method::Sobol)).map(|asked| {
            let widest = self.widest(found);
            Precision { asked, widest, is_reached: widest <= asked }
        });
        let centres = self.centres()?;
        let cases = found.iter().zip(centres).enumerate();
        Ok(Output {
            methods: self.spec.methods.clone(),
            samples,
            scrambles: self.spec.scrambles,
            trajectories: self.spec.trajectories,
            parameters,
            precision,
            cases: cases.map(|(case, (sums, centres))| self.case(case, sums, centres, samples)).collect(),
        })
    }

    fn case(&self, case: usize, found: &Found, centres: &[f64], samples: u64) -> Case {
        Case {
            environment: self.spec.environments[case].name.clone(),
            quantities: (centres.iter().enumerate())
                .map(|(position, centre)| self.quantity(found, position, *centre))
                .collect(),
            solves: found.solves,
            failed: found.failed,
            rows_left_out: found.scrambles.iter().map(|scramble| scramble.left_out).sum(),
            rows: if self.spec.has(Method::Sobol) { samples * self.spec.scrambles } else { 0 },
            trajectories_left_out: found.trajectories_left_out,
            failures: found.failures.clone(),
        }
    }

    fn quantity(&self, found: &Found, position: usize, nominal: f64) -> OfQuantity {
        let k = self.uncertain.len();
        let quantity = &self.model.quantities[self.spec.quantities[position]];
        let local: Vec<Local> = found.local.get(position * k..(position + 1) * k).unwrap_or_default().to_vec();
        let indices = indices_of(found, position);
        let morris = self.morris(found, position);
        let is_constant = if self.spec.has(Method::Sobol) {
            indices.is_none()
        } else {
            !morris.is_empty() && morris.iter().all(|effect| effect.mu_star == 0.0)
        };
        let sobol = indices.as_deref().map(|indices| self.shares(found, position, indices));
        let derivative = if is_constant { Vec::new() } else { self.derivative(found, position, indices.as_deref()) };
        let scatter = sobol.as_ref().and_then(|sobol| self.scatter(found, position, sobol));
        OfQuantity {
            name: quantity.name.clone(),
            unit: quantity.unit.clone(),
            is_temperature: quantity.is_temperature,
            nominal,
            is_constant,
            local,
            morris,
            sobol,
            derivative,
            scatter,
        }
    }

    fn morris(&self, found: &Found, position: usize) -> Vec<ElementaryEffect> {
        let (k, quantities) = (self.uncertain.len(), self.spec.quantities.len());
        // Of one trajectory there is no standard deviation.
        if found.morris.len() < 2 * quantities * k {
            return Vec::new();
        }
        let of = |coordinate: usize| -> Vec<f64> {
            found.morris.chunks(quantities * k).map(|effects| effects[position * k + coordinate]).collect()
        };
        (0..k).map(|coordinate| ElementaryEffect::of(&of(coordinate))).collect()
    }

    fn shares(&self, found: &Found, position: usize, indices: &[SobolIndices]) -> Sobol {
        let (main, total) = (estimates(indices, |i| &i.main), estimates(indices, |i| &i.total));
        let left_out: u64 = found.scrambles.iter().map(|scramble| scramble.left_out).sum();
        let mut pooled: Option<SobolSums> = None;
        for scramble in &found.scrambles {
            match (&mut pooled, scramble.sums.get(position)) {
                (Some(pooled), Some(sums)) => pooled.merge(sums),
                (pooled @ None, Some(sums)) => *pooled = Some(sums.clone()),
                (_, None) => {}
            }
        }
        let bounds = |coordinate: usize| {
            let pooled = pooled.as_ref().filter(|_| left_out > 0)?;
            pooled.bounds(left_out, main[coordinate].value, total[coordinate].value)
        };
        let index = |estimates: &[Estimate], which: usize| -> Vec<Index> {
            let with_bounds =
                |(coordinate, &estimate)| Index { estimate, bounds: bounds(coordinate).map(|b| b[which]) };
            estimates.iter().enumerate().map(with_bounds).collect()
        };
        let name = |coordinate: usize| self.model.parameters[self.uncertain[coordinate]].name.clone();
        let second_order = pairs(self.uncertain.len())
            .zip(estimates(indices, |i| &i.second))
            .map(|((i, j), estimate)| PairEffect { parameters: [name(i), name(j)], estimate })
            .collect();
        let sums: Vec<f64> = indices.iter().map(|i| i.main.iter().sum()).collect();
        let mean = |of: &dyn Fn(&SobolIndices) -> f64| indices.iter().map(of).sum::<f64>() / indices.len() as f64;
        Sobol {
            mean: mean(&|i| i.mean),
            sd: mean(&|i| i.variance).sqrt(),
            main: index(&main, 0),
            total: index(&total, 1),
            second_order,
            sum_main: Estimate::of(&sums),
            places: places(&total),
        }
    }

    /// Bounds by derivatives; the variance is that of the Sobol rows where there are any, else of the same points.
    fn derivative(&self, found: &Found, position: usize, indices: Option<&[SobolIndices]>) -> Vec<DerivativeBound> {
        let k = self.uncertain.len();
        let usable: Vec<(usize, &Squares)> =
            found.squares.iter().enumerate().filter(|(_, squares)| squares.points > 1).collect();
        if usable.len() < 2 {
            return Vec::new();
        }
        let pooled = |of: &dyn Fn(&Squares) -> f64| {
            let points: u64 = usable.iter().map(|(_, s)| s.points).sum();
            usable.iter().map(|(_, s)| of(s)).sum::<f64>() / points as f64
        };
        let mean_variance = usable.iter().map(|(_, s)| s.moments[position][1]).sum::<f64>() / usable.len() as f64;
        if indices.is_none() && !(mean_variance > 0.0) {
            return Vec::new();
        }
        let variance = |scramble: usize| match indices {
            Some(indices) => indices.get(scramble).map_or(mean_variance, |i| i.variance),
            None => mean_variance,
        };
        (0..k)
            .map(|coordinate| {
                let place = position * k + coordinate;
                let replicates: Vec<f64> =
                    usable.iter().map(|&(i, s)| s.weighted[place] / s.points as f64 / variance(i)).collect();
                DerivativeBound {
                    bound: Estimate::of(&replicates),
                    root_mean_square: pooled(&|s| s.plain[place]).sqrt(),
                }
            })
            .collect()
    }

    /// Some samples with the leading parameters; their values are drawn again from the point set.
    fn scatter(&self, found: &Found, position: usize, sobol: &Sobol) -> Option<Scatter> {
        let kept = found.sample.len() / self.spec.quantities.len().max(1);
        let values = found.sample.get(position * kept..(position + 1) * kept)?;
        let rows: Vec<usize> = (0..kept.min(SAMPLE)).filter(|&row| values[row].is_some()).collect();
        let mut order: Vec<usize> = (0..self.uncertain.len()).collect();
        let size = |coordinate: usize| sobol.total[coordinate].estimate.value;
        sort_by(&mut order, |&i, &j| size(j).total_cmp(&size(i)));
        order.truncate(SCATTERED);
        let mut drawn = vec![0.0; 2 * self.uncertain.len()];
        let mut x = vec![Vec::new(); order.len()];
        for &row in &rows {
            self.points.first()?.fill_row(row, &mut drawn);
            for (column, &coordinate) in x.iter_mut().zip(&order) {
                column.push(self.priors[self.uncertain[coordinate]].quantile(drawn[2 * coordinate]));
            }
        }
        Some(Scatter { parameters: order, x, y: rows.iter().filter_map(|&row| values[row]).collect() })
    }
}

/// Indices of a quantity by scramble; `None` where it is constant in one, or was not computed.
fn indices_of(found: &Found, position: usize) -> Option<Vec<SobolIndices>> {
    if found.scrambles.is_empty() {
        return None;
    }
    found.scrambles.iter().map(|scramble| scramble.sums.get(position)?.indices()).collect()
}
