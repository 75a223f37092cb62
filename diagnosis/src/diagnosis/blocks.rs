//! What stretches of the data say of sets of effects where the model is a little wrong everywhere: log likelihoods block by block, of
//! which [`crate::diagnosis::odds::sampling`] asks how far chance decides between two sets.

use std::collections::BTreeMap;

use crate::diagnosis::engine::{Diagnosis, SensorNoise, State};
use crate::diagnosis::fits::refit::HeldOut;
use crate::diagnosis::noise::model_error::Errors;
use crate::math::functions::ln;
use crate::measurement::Rows;

/// Most and fewest blocks of a transient.
const BLOCKS: [f64; 2] = [50.0, 8.0];

/// A stretch of a measurement: whether its readings are held out, the position of the measurement, and its own there.
type Block = (bool, usize, usize);

/// Log likelihoods of held-out readings, each with its error and the independent readings that it is worth, where the error has the size
/// that a set shows there. But for a constant their sum is what the gain of unseen rows compares.
pub fn of_held_out(readings: &[(f64, f64)], rmse: f64) -> Vec<f64> {
    let log = |&(error, independent): &(f64, f64)| -independent * (ln(rmse) + 0.5 * (error / rmse) * (error / rmse));
    readings.iter().map(log).collect()
}

/// Independent readings that a held-out one is worth.
fn independent_readings(state: &State, one: &HeldOut) -> f64 {
    let same = |noise: &&SensorNoise| noise.measurement == one.measurement && noise.sensor == one.sensor;
    state.noise.iter().find(same).map_or(0.0, SensorNoise::independent_readings)
}

impl Diagnosis {
    /// Independent readings that the held-out rows are worth.
    pub(crate) fn independent_unseen(&self, state: &State) -> f64 {
        let of = |one: &HeldOut| independent_readings(state, one);
        state.refits.first().map_or(0.0, |refit| refit.held_out.iter().map(of).sum())
    }

    /// Log likelihoods by set and block: of the fitted readings with the model error that is most likely beside the set, and of the
    /// held-out ones with the error that it shows there. A steady phase is a block, or a stretch of a transient in which errors are
    /// alike.
    pub(crate) fn log_likelihoods_of_blocks(&self, state: &State) -> Vec<Vec<f64>> {
        let mut blocks = vec![Vec::new(); state.refits.len()];
        let Some((_, instruments)) = self.reference(state) else { return blocks };
        let problem = self.with_noise(&state.noise, &state.most_steps);
        let readings = problem.fitted_readings();
        let block = |is_held_out: bool, measurement: usize, row: usize| -> Block {
            let measured = &problem.measurements[measurement];
            let rows_of_block = match measured.rows {
                Rows::Steady(_) => 1.0,
                Rows::Transient { .. } => {
                    let rows = measured.len() as f64;
                    let [most, fewest] = BLOCKS.map(|count| rows / count);
                    instruments[measurement].readings_of_one.clamp(most, fewest)
                }
            };
            (is_held_out, measurement, (row as f64 / rows_of_block) as usize)
        };
        let keys: Vec<Block> = readings.iter().map(|one| block(false, one.measurement, one.row)).collect();
        for one in self.beside_sets(state, &instruments) {
            let refit = &state.refits[one.place];
            let mut sums: BTreeMap<Block, f64> = BTreeMap::new();
            for (measurement, instrument) in instruments.iter().enumerate() {
                let mine: Vec<usize> = (0..keys.len()).filter(|&k| readings[k].measurement == measurement).collect();
                let own = Errors { errors: mine.iter().map(|&k| refit.errors[k]).collect(), ..instrument.clone() };
                for (k, log) in mine.into_iter().zip(own.of_readings(one.sds[measurement])) {
                    *sums.entry(keys[k]).or_default() += log;
                }
            }
            if let Some(rmse) = refit.rmse_held_out_k.filter(|rmse| *rmse > 0.0) {
                let readings: Vec<(f64, f64)> =
                    refit.held_out.iter().map(|one| (one.error, independent_readings(state, one))).collect();
                for (reading, log) in refit.held_out.iter().zip(of_held_out(&readings, rmse)) {
                    *sums.entry(block(true, reading.measurement, reading.row)).or_default() += log;
                }
            }
            blocks[one.place] = sums.into_values().collect();
        }
        blocks
    }
}
