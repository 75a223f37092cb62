//! A calibration in the groups of ArviZ' schema of InferenceData (Kumar et al. 2019, J. Open Source Software 4, 1143), all
//! numbers in SI units: `posterior`, `sample_stats`, `log_likelihood`, `posterior_predictive`, `prior`,
//! `prior_predictive`, `observed_data`, `constant_data`; readings held out are `predictions`, with what belongs to them
//! in `predictions_constant_data`.

use super::drawn::{Drawn, Replicates};
use super::{Calibrate, scores};
use crate::expression::Unit;
use crate::inference::likelihood::Datum;
use crate::inference::sampler::chains::Chain;
use crate::inference::target::Target;
use crate::job::JobError;
use crate::job::dataset::{Attribute, Dataset, Dimension, Group};
use crate::measurement::{Measurement, Rows};

/// Name of the arrays of readings.
const READINGS: &str = "readings";

/// What one entry of the log likelihood stands for: what leave-one-out cross-validation leaves out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LeftOut {
    /// A reading.
    #[default]
    Reading,
    /// A steady phase with all its readings.
    Phase,
}

/// Every so many draws of each chain: those for which readings are predicted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Thinned(pub usize);

impl Thinned {
    /// The chosen draws of all chains: number over all chains, and values.
    pub fn draws(self, drawn: &Drawn) -> Vec<(u64, Vec<f64>)> {
        let chains = drawn.chains.chains.iter().enumerate();
        let of_chain = |(index, chain): (usize, &Chain)| -> Vec<(u64, Vec<f64>)> {
            let first = index * chain.len();
            (0..chain.len())
                .step_by(self.0.max(1))
                .map(|draw| ((first + draw) as u64, chain.draw(draw).to_vec()))
                .collect()
        };
        chains.flat_map(of_chain).collect()
    }
}

impl Calibrate {
    /// Readings that were fitted, in the order of the log likelihood, and readings held out.
    fn places(&self) -> [Vec<Datum>; 2] {
        let mut held_out = Vec::new();
        for (position, measurement) in self.measurements().into_iter().enumerate() {
            for row in (0..measurement.len()).filter(|&row| measurement.held_out(row) && !measurement.ignored(row)) {
                let read = (0..measurement.sensors.len()).filter(|&sensor| measurement.reading(row, sensor).is_some());
                held_out.extend(read.map(|sensor| Datum { measurement: position, row, sensor }));
            }
        }
        [self.likelihood().data().to_vec(), held_out]
    }

    /// Bytes of the arrays that grow with the draws, for so many of them.
    pub fn replicated_bytes(&self, draws: usize) -> u64 {
        let all: usize = self.measurements().iter().map(|measurement| measurement.readings.len()).sum();
        let numbers = (all + self.likelihood().data().len()).saturating_mul(draws);
        (numbers as u64).saturating_mul(size_of::<f64>() as u64)
    }

    /// The calibration as groups of arrays; `posterior` are replicates of the thinned draws, `prior` those of the prior's.
    ///
    /// # Errors
    /// Phases asked for where no steady phase was fitted.
    pub fn inference_data(
        &self,
        drawn: &Drawn,
        thinned: Thinned,
        left_out: LeftOut,
        posterior: &Replicates,
        prior: &Replicates,
    ) -> Result<Dataset, JobError> {
        let [fitted, held_out] = self.places();
        let chains = drawn.chains.chains.len();
        let draws = drawn.chains.chains.first().map_or(0, Chain::len);
        let rows =
            |step: usize| vec![Dimension::of_places("chain", chains, 1), Dimension::of_places("draw", draws, step)];
        let mut dataset = Dataset::default();

        let mut of_posterior = Group::new("posterior", rows(1));
        self.add_unknowns(&mut of_posterior, |place| {
            drawn.chains.chains.iter().flat_map(|chain| chain.parameter(place)).collect()
        });
        dataset.add(of_posterior);
        dataset.add(self.sample_statistics(drawn, rows(1)));
        dataset.add(self.log_likelihood(rows(thinned.0), left_out, &posterior.log_likelihoods)?);
        let readings = |name: &'static str, rows: Vec<Dimension>, places: &[Datum], dimension, values: &Replicates| {
            let mut group = Group::new(name, rows);
            let about = "what the sensors read: the model's prediction with noise";
            let labels = Dimension::of_names(dimension, self.labels(places));
            group.across(READINGS, about, labels, self.chosen(places, &values.readings));
            group
        };
        dataset.add(readings("posterior_predictive", rows(thinned.0), &fitted, "reading", posterior));
        let of_prior = || vec![Dimension::of_places("chain", 1, 1), Dimension::of_places("draw", drawn.prior.len(), 1)];
        let mut before = Group::new("prior", of_prior());
        self.add_unknowns(&mut before, |place| {
            drawn.prior.iter().map(|draw| draw.get(place).copied().unwrap_or(f64::NAN)).collect()
        });
        dataset.add(before);
        dataset.add(readings("prior_predictive", of_prior(), &fitted, "reading", prior));
        let mut observed = Group::new("observed_data", vec![Dimension::of_names("reading", self.labels(&fitted))]);
        observed.numbers(READINGS, "what was measured", None, self.measured(&fitted));
        dataset.add(observed);
        dataset.add(self.constants("constant_data", "reading", &fitted));
        if !held_out.is_empty() {
            dataset.add(readings("predictions", rows(thinned.0), &held_out, "held_out", posterior));
            let mut constants = self.constants("predictions_constant_data", "held_out", &held_out);
            constants.numbers("measured", "what was measured", None, self.measured(&held_out));
            dataset.add(constants);
        }
        Ok(dataset)
    }

    /// Adds the unknowns, whose values `of` gives by their place.
    fn add_unknowns(&self, group: &mut Group, of: impl Fn(usize) -> Vec<f64>) {
        let unknowns = self.likelihood().unknowns();
        for (place, (name, unit)) in unknowns.names.iter().zip(&unknowns.units).enumerate() {
            let unit = Unit::parse(unit).ok().map(|unit| Unit::si(unit.dimension).text);
            group.numbers(name, name, unit, of(place));
        }
    }

    /// Densities at the draws, and how the chains went.
    fn sample_statistics(&self, drawn: &Drawn, rows: Vec<Dimension>) -> Group {
        let mut group = Group::new("sample_stats", rows);
        let chains = &drawn.chains.chains;
        let log_likelihoods: Vec<f64> = chains.iter().flat_map(|chain| chain.log_likelihoods.clone()).collect();
        if self.target.joint().is_empty() {
            let log_prior = |draw: &[f64]| -> f64 {
                self.target.priors().iter().zip(draw).map(|(prior, value)| prior.log_density(*value)).sum()
            };
            let draws = chains.iter().flat_map(|chain| (0..chain.len()).map(|draw| chain.draw(draw)));
            let sums = log_likelihoods.iter().zip(draws).map(|(log, draw)| log + log_prior(draw)).collect();
            group.numbers("lp", "log of prior density times likelihood", None, sums);
        }
        group.numbers("log_likelihood", "log likelihood of all readings", None, log_likelihoods);
        let by_chain = |of: &dyn Fn(&Chain) -> f64| Attribute::Numbers(chains.iter().map(of).collect());
        group.attributes.push(("acceptance_rate_by_chain", by_chain(&|chain| chain.moves.acceptance)));
        group.attributes.push(("divergences_by_chain", by_chain(&|chain| chain.moves.divergences as f64)));
        if let Some(weights) = &drawn.weights {
            group.attributes.push(("weight_by_chain", Attribute::Numbers(weights.clone())));
        }
        group
    }

    /// Log densities by reading or by phase.
    fn log_likelihood(
        &self,
        rows: Vec<Dimension>,
        left_out: LeftOut,
        log_likelihoods: &[f64],
    ) -> Result<Group, JobError> {
        let mut group = Group::new("log_likelihood", rows);
        let data = self.likelihood().data();
        match left_out {
            LeftOut::Reading => {
                let about = "log density of a reading, given those before it where noise is correlated";
                let labels = Dimension::of_names("reading", self.labels(data));
                group.across(READINGS, about, labels, log_likelihoods.to_vec());
            }
            LeftOut::Phase => {
                let measurements = self.measurements();
                let (groups, summed) = scores::by_phase(&measurements, data, log_likelihoods);
                if groups.is_empty() {
                    return Err(JobError::Failed(
                        "no steady phase was fitted: the log likelihood is by reading alone".to_owned(),
                    ));
                }
                let label = |phase: &scores::Group| {
                    let measurement = measurements[phase.measurement];
                    format!("{}/{}", measurement.name, row_label(measurement, phase.row))
                };
                let labels = Dimension::of_names("phase", groups.iter().map(label).collect());
                group.across(READINGS, "log density of the readings of a steady phase", labels, summed);
            }
        }
        Ok(group)
    }

    /// What belongs to readings and was not measured by them: their sensors, and the inputs of their rows.
    fn constants(&self, name: &'static str, dimension: &'static str, places: &[Datum]) -> Group {
        let measurements = self.measurements();
        let of = |datum: &Datum| measurements[datum.measurement];
        let mut group = Group::new(name, vec![Dimension::of_names(dimension, self.labels(places))]);
        let texts = |text: &dyn Fn(&Datum) -> String| places.iter().map(text).collect::<Vec<String>>();
        group.texts("measurement", "measurement", texts(&|datum| of(datum).name.clone()));
        group.texts("sensor", "sensor", texts(&|datum| of(datum).sensors[datum.sensor].name.clone()));
        let unit = |datum: &Datum| {
            let quantity = of(datum).sensors[datum.sensor].quantity;
            self.inputs.model.quantities.get(quantity).map_or_else(String::new, |quantity| quantity.unit.clone())
        };
        group.texts("unit", "SI unit of the reading", texts(&unit));
        let phase = |datum: &Datum| match &of(datum).rows {
            Rows::Steady(_) => row_label(of(datum), datum.row),
            Rows::Transient { .. } => String::new(),
        };
        group.texts("phase", "steady phase; empty in a transient", texts(&phase));
        let time = |datum: &Datum| match &of(datum).rows {
            Rows::Steady(_) => f64::NAN,
            Rows::Transient { inputs, .. } => inputs.times_s[datum.row],
        };
        group.numbers("time", "instant in a transient", Some("s".to_owned()), places.iter().map(time).collect());
        let inputs = &self.inputs.model.inputs;
        if !inputs.is_empty() {
            let of_row = |datum: &Datum| -> Vec<f64> {
                match &of(datum).rows {
                    Rows::Steady(phases) => phases[datum.row].inputs.clone(),
                    Rows::Transient { inputs: table, .. } => {
                        (0..inputs.len()).map(|input| table.in_row(datum.row, input)).collect()
                    }
                }
            };
            let names = Dimension::of_names("input", inputs.iter().map(|input| input.name.clone()).collect());
            group.across(
                "inputs",
                "inputs of the model in the reading's row",
                names,
                places.iter().flat_map(of_row).collect(),
            );
        }
        group
    }

    /// What was measured.
    fn measured(&self, places: &[Datum]) -> Vec<f64> {
        let measurements = self.measurements();
        let reading = |datum: &Datum| measurements[datum.measurement].reading(datum.row, datum.sensor);
        places.iter().map(|datum| reading(datum).unwrap_or(f64::NAN)).collect()
    }

    /// The chosen readings of all, draw by draw.
    fn chosen(&self, places: &[Datum], readings: &[f64]) -> Vec<f64> {
        let measurements = self.measurements();
        let mut firsts = Vec::new();
        let mut width = 0;
        for measurement in &measurements {
            firsts.push(width);
            width += measurement.readings.len();
        }
        let place = |datum: &Datum| {
            firsts[datum.measurement] + datum.row * measurements[datum.measurement].sensors.len() + datum.sensor
        };
        let chosen: Vec<usize> = places.iter().map(place).collect();
        readings.chunks_exact(width.max(1)).flat_map(|draw| chosen.iter().map(|&place| draw[place])).collect()
    }

    /// A label of each reading: measurement, row, sensor.
    fn labels(&self, places: &[Datum]) -> Vec<String> {
        let measurements = self.measurements();
        let label = |datum: &Datum| {
            let measurement = measurements[datum.measurement];
            let sensor = &measurement.sensors[datum.sensor].name;
            format!("{}/{}/{sensor}", measurement.name, row_label(measurement, datum.row))
        };
        places.iter().map(label).collect()
    }
}

/// A row as its file names it: the phase, or the instant.
fn row_label(measurement: &Measurement, row: usize) -> String {
    match &measurement.rows {
        Rows::Steady(phases) => phases[row].name.clone(),
        Rows::Transient { inputs, .. } => format!("{} s", inputs.times_s[row]),
    }
}
