//! Fitted values at which an effect is not what it is called: thresholds that no fitted row crosses, heat capacities that keep all heat,
//! linear laws of temperature that leave nothing of what they change.

use std::collections::BTreeMap;

use crate::diagnosis::linearisation::threshold_levels::{is_crossed, temperatures_read};
use crate::diagnosis::{Problem, Refit};
use crate::effect::{EffectParameter, REFERENCE_SYMBOL, Site};
use crate::expression::{Graph, Symbol};
use crate::measurement::{Initial, Measurement, Rows};

/// Log odds by which an effect stands behind others for each such value: what it does there, plainer laws do.
pub(crate) const OUT_OF_RANGE: f64 = 10.0;
/// Lengths of the longest run beyond which a time constant is that of a store that keeps what it is given: within the run a twentieth
/// of a constant heat reaches the node.
const LONGEST_RUNS: f64 = 10.0;
/// Least share of a power or a conductance that a linear law of temperature may leave: it is the first term of a series, and a law
/// that takes more than this is no small change any more. Beyond its zero a power would cool.
const LEAST_LEFT: f64 = 0.1;

impl Problem {
    /// At how many fitted values effects are not what they are called: thresholds that no fitted row crosses, heat capacities that keep
    /// all heat, linear laws that leave nothing.
    pub fn values_out_of_range(&self, refit: &Refit) -> usize {
        let fitted = refit.by_name();
        let linear = refit.effects.iter().filter(|&&effect| self.leaves_nothing(effect, &fitted)).count();
        self.levels_not_crossed(refit) + self.stores_that_keep_all(refit) + linear
    }

    /// How many levels of a fit's effects, such as thresholds, have all fitted rows on one side.
    fn levels_not_crossed(&self, refit: &Refit) -> usize {
        let fitted = refit.by_name();
        let of_effect = |&effect: &usize| {
            let candidate = &self.candidates[effect];
            let Some(file) = self.catalogue.get(&candidate.effect) else { return 0 };
            let is_missed = |parameter: &EffectParameter| {
                let value = fitted.get(&format!("{}.{}", candidate.id, parameter.name));
                value.is_some_and(|&value| !is_crossed(self, candidate, file, parameter, value))
            };
            file.parameters(&self.model, &candidate.bound).iter().filter(|own| !own.amplitude && is_missed(own)).count()
        };
        refit.effects.iter().map(of_effect).sum()
    }

    /// How many effects give a load a heat capacity that keeps nearly all heat to the end of the longest run: the load is off then, and
    /// that is no capacity's doing. None where a steady or periodic state is asked for too, in which all heat arrives.
    fn stores_that_keep_all(&self, refit: &Refit) -> usize {
        let Some(longest_s) = self
            .measurements
            .iter()
            .map(transient_s)
            .try_fold(0.0, |longest: f64, length| length.map(|length| longest.max(length)))
        else {
            return 0;
        };
        let fitted = refit.by_name();
        let keeps_all = |&&effect: &&usize| {
            let candidate = &self.candidates[effect];
            let file = self.catalogue.get(&candidate.effect);
            let Some(source) = file.and_then(|file| file.form.adds.value.source.as_ref()) else { return false };
            let value = |text: &str| fitted.get(&format!("{}.{text}", candidate.id)).copied();
            // What is a formula, or no unknown, has no time constant that is known here.
            let ends = value(&source.capacity.value).zip(value(&source.conductance.value));
            ends.is_some_and(|(capacity, conductance)| capacity > LONGEST_RUNS * longest_s * conductance)
        };
        refit.effects.iter().filter(keeps_all).count()
    }

    /// Whether an effect is a factor that is linear in a temperature and that at one of those that were read at its nodes is less
    /// than [`LEAST_LEFT`]. Not where a node has no sensor.
    fn leaves_nothing(&self, effect: usize, fitted: &BTreeMap<String, f64>) -> bool {
        let candidate = &self.candidates[effect];
        let (Site::Elements(elements), Some(file)) = (&candidate.site, self.catalogue.get(&candidate.effect)) else {
            return false;
        };
        let mut graph = Graph::new();
        let Some(law) = file.factor(&mut graph) else { return false };
        let names: Vec<String> = file.form.parameters.names().map(|name| format!("{}.{name}", candidate.id)).collect();
        let reference_k = self.reference_k(candidate);
        let factor = |temperature_k: f64| {
            let value = |symbol: Symbol| match symbol {
                Symbol::Node(_) => temperature_k,
                Symbol::Parameter(own) => {
                    names.get(own as usize).and_then(|name| fitted.get(name)).copied().unwrap_or(f64::NAN)
                }
                REFERENCE_SYMBOL => reference_k,
                // What depends on anything else is no law of temperature alone.
                _ => f64::NAN,
            };
            graph.evaluate(law, &value)
        };
        let is_vanishing = |&element: &usize| {
            let nodes = self.model.elements.get(element)?.nodes();
            let read: Option<Vec<[f64; 2]>> = nodes.iter().map(|&node| temperatures_read(self, node)).collect();
            let read = read.filter(|read| !read.is_empty())?;
            let mean = |end: usize| read.iter().map(|ends| ends[end]).sum::<f64>() / read.len() as f64;
            let [least, most] = [mean(0), mean(1)];
            let [cold, middle, hot] = [factor(least), factor(0.5 * (least + most)), factor(most)];
            let is_linear = cold != hot && (middle - 0.5 * (cold + hot)).abs() <= 1e-9 * (cold - hot).abs();
            Some(is_linear && cold.min(hot) < LEAST_LEFT)
        };
        elements.iter().any(|element| is_vanishing(element) == Some(true))
    }
}

/// Time from the start of a run to its last fitted row, s; 0 without one. `None` of steady phases that are fitted, and of a run that starts
/// in a steady or periodic state.
fn transient_s(measurement: &Measurement) -> Option<f64> {
    let Some(last) = measurement.fitted_rows().next_back() else { return Some(0.0) };
    let Rows::Transient { inputs, initial: Initial::Temperatures { .. }, .. } = &measurement.rows else { return None };
    inputs.times_s.first().zip(inputs.times_s.get(last)).map(|(first, last)| last - first)
}
