//! Whether an effect is smooth at amplitude 0, has to be probed, or cannot be seen.

use crate::diagnosis::error::NoDirection;
use std::collections::HashMap;

use super::kinds;
use crate::diagnosis::Problem;
use crate::document::Spanned;
use crate::effect::form::{AddsForm, SeenBy, Sign};
use crate::effect::{Candidate, Effect, EffectParameter, Site};
use crate::expression::{ExprId, Graph, Names, Scope, Symbol, parse};
use crate::thermal::NodeKind;

/// How a candidate's directions are found.
pub enum Form<'a> {
    /// It cannot be seen, for a reason.
    Unseen(NoDirection),
    /// By derivatives at amplitude 0, at each of these values of its parameters (amplitudes: 0).
    Smooth {
        /// The effect, as the data see it.
        effect: &'a Effect,
    },
    /// By finite values.
    Probe {
        /// The effect.
        effect: &'a Effect,
    },
    /// By predictions that are read at other times.
    Timing {
        /// The effect.
        effect: &'a Effect,
    },
    /// By exchanged predictions.
    Swap,
    /// As the parameter of this index, whose prior may be too narrow.
    Parameter(usize),
}

/// What is known of every effect of the catalogue.
pub struct Forms {
    steady: bool,
    transient: bool,
    smooth: HashMap<String, bool>,
    /// Effects as steady phases see them.
    at_rest: HashMap<String, Effect>,
}

impl Forms {
    /// Of a problem's candidates.
    pub fn new(problem: &Problem) -> Self {
        let (steady, transient) = kinds(problem);
        let mut forms = Self { steady, transient, smooth: HashMap::new(), at_rest: HashMap::new() };
        for effect in problem.catalogue.effects() {
            let resting = if transient { effect.clone() } else { at_rest(effect) };
            forms.smooth.insert(effect.name.clone(), is_smooth(&resting));
            forms.at_rest.insert(effect.name.clone(), resting);
        }
        forms
    }

    /// Whether only steady phases have readings.
    pub fn is_steady(&self) -> bool {
        self.steady && !self.transient
    }

    /// Whether steady phases have readings.
    pub fn has_steady_phases(&self) -> bool {
        self.steady
    }

    /// The form of a candidate.
    pub fn of(&self, problem: &Problem, position: usize) -> Form<'_> {
        let candidate = &problem.candidates[position];
        if let Site::Parameter(index) = candidate.site {
            return Form::Parameter(index);
        }
        let Some(effect) = self.at_rest.get(&candidate.effect) else {
            return Form::Unseen(NoDirection::Unknown);
        };
        let written = problem.catalogue.get(&candidate.effect).unwrap_or(effect);
        if let Some(reason) = self.unseen(written, candidate) {
            return Form::Unseen(reason);
        }
        if effect.exchanges_channels() {
            return Form::Swap;
        }
        if effect.only_changes_timing() {
            return Form::Timing { effect };
        }
        if self.smooth[&candidate.effect] && !gives_storage(problem, effect, candidate) {
            Form::Smooth { effect }
        } else {
            Form::Probe { effect }
        }
    }

    fn unseen(&self, effect: &Effect, candidate: &Candidate) -> Option<NoDirection> {
        let adds = &effect.form.adds.value;
        if (candidate.steady && self.steady) || (candidate.transient && self.transient) {
            let dangling = !self.transient && adds.node.is_some() && !matches!(candidate.site, Site::Pair(_));
            return dangling.then_some(NoDirection::Capacity);
        }
        let seen = |by: SeenBy| effect.form.seen_by.contains(&by);
        let steady_only = self.steady && !self.transient;
        Some(if steady_only && !seen(SeenBy::Steady) {
            if adds.lag.is_some() {
                NoDirection::Lag
            } else if adds.clock.is_some() {
                NoDirection::Clock
            } else if adds.capacity.is_some() || adds.node.is_some() || adds.within.is_some() || adds.source.is_some() {
                NoDirection::Capacity
            } else {
                NoDirection::Course
            }
        } else if !self.steady && !seen(SeenBy::Transient) {
            NoDirection::Transients
        } else {
            match &candidate.site {
                Site::Sensors(_) => NoDirection::NoSuchSensor,
                _ => NoDirection::NoSuchReading,
            }
        })
    }
}

/// An effect as steady phases see it: a hidden node between two others is a path.
fn at_rest(effect: &Effect) -> Effect {
    let mut effect = effect.clone();
    let adds = &mut effect.form.adds.value;
    if let (Some(node), None) = (&adds.node, &adds.flow)
        && effect.places.contains(&crate::effect::PlaceKind::Pair)
    {
        let text = format!("({}) * (Ta - Tb)", node.conductance.value);
        adds.flow = Some(Spanned { value: text, place: node.conductance.place.clone() });
        // Single nodes are told apart before; a path needs no node.
        adds.node = None;
    }
    effect
}

/// Whether an effect gives storage to a node that has none: its capacity has a floor there.
fn gives_storage(problem: &Problem, effect: &Effect, candidate: &Candidate) -> bool {
    let Site::Nodes(nodes) = &candidate.site else { return false };
    let bare = |node: usize| matches!(problem.model.nodes.get(node).map(|n| n.kind), Some(NodeKind::Arithmetic));
    effect.form.adds.value.capacity.is_some() && nodes.iter().any(|&(node, _)| bare(node))
}

/// The expressions of what is added without a limit of its own.
fn texts(adds: &AddsForm) -> Vec<&str> {
    let mut texts = vec![&adds.flow, &adds.load, &adds.factor, &adds.capacity, &adds.offset, &adds.reading];
    if let Some(cooler) = &adds.cooler {
        texts.extend([&cooler.seebeck, &cooler.resistance, &cooler.conductance]);
    }
    let mut texts: Vec<&str> = texts.into_iter().flatten().map(|text| text.value.as_str()).collect();
    texts.extend(adds.ambient.as_ref().map(|ambient| ambient.temperature.value.as_str()));
    texts
}

/// Whether the effect has slopes in its amplitudes at 0: they are finite, and not zero where an amplitude occurs.
fn is_smooth(effect: &Effect) -> bool {
    let adds = &effect.form.adds.value;
    if adds.curve.is_some() {
        return true;
    }
    if adds.node.is_some()
        || adds.within.is_some()
        || adds.source.is_some()
        || adds.contact.is_some()
        || adds.lag.is_some()
        || adds.clock.is_some()
    {
        return false;
    }
    let mut graph = Graph::new();
    let mut names = Names::default();
    let mut put = |graph: &mut Graph, name: String, symbol: Symbol| {
        let id = graph.symbol(symbol);
        names.values.insert(name, id);
    };
    for (index, entry) in (0u32..).zip(&effect.form.parameters) {
        put(&mut graph, entry.name.clone(), Symbol::Parameter(index));
    }
    for (index, entry) in (0u32..).zip(&effect.form.inputs) {
        put(&mut graph, entry.name.clone(), Symbol::Input(index));
        put(&mut graph, format!("{}_lower", entry.name), Symbol::Local(0));
        put(&mut graph, format!("{}_upper", entry.name), Symbol::Local(1));
    }
    let stand_ins = ["T", "Ta", "Tb", "Tm", "rate", "zero"];
    let locals: Vec<(&str, ExprId)> =
        (0u32..).zip(stand_ins).map(|(index, name)| (name, graph.symbol(Symbol::Node(index)))).collect();
    let scope = Scope::with(&names, locals);
    let mut roots = Vec::new();
    for text in texts(adds) {
        let Ok(id) = parse(text, &mut graph, &scope) else { return false };
        roots.push(id);
    }
    let shapes: Vec<bool> = effect.form.parameters.iter().map(|entry| entry.value.shape).collect();
    // An input below, between and above thresholds, at several temperatures.
    let states = [1.3, 4.7, 9.1];
    let mut occurs = false;
    for (index, _) in (0u32..).zip(&shapes).filter(|(_, shape)| !**shape) {
        let symbol = Symbol::Parameter(index);
        let mut moves = false;
        let mut here = false;
        for &root in &roots {
            here |= graph.symbols(root).contains(&symbol);
            let slope = graph.derivative(root, symbol);
            for state in states {
                let value = graph.evaluate(slope, &|symbol| match symbol {
                    Symbol::Parameter(index) if shapes.get(index as usize) == Some(&true) => 5.0,
                    Symbol::Parameter(_) | Symbol::Local(0) => 0.0,
                    Symbol::Local(_) | Symbol::Output(_) => 10.0,
                    Symbol::Node(node) => 280.0 + 3.0 * f64::from(node) * state,
                    Symbol::Input(input) => state + 0.1 * f64::from(input),
                    Symbol::Time => 100.0 * state,
                    Symbol::Mode(_) => 1.0,
                });
                if !value.is_finite() {
                    return false;
                }
                moves |= value != 0.0;
            }
        }
        if here && !moves {
            return false;
        }
        occurs |= here;
    }
    occurs
}

/// Bounds of an amplitude, SI: what its sign and its prior allow, 0 among it.
pub(super) fn bounds(parameter: &EffectParameter) -> (f64, f64) {
    let (lower, upper) = parameter.prior.support();
    let lower = if parameter.sign == Sign::Positive { 0.0 } else { lower.min(0.0) };
    let upper = if parameter.sign == Sign::Negative { 0.0 } else { upper.max(0.0) };
    (lower, upper)
}

/// Plausible size of an amplitude, SI, above 0.
pub(super) fn plausible(parameter: &EffectParameter) -> f64 {
    let spread = 0.5 * (parameter.prior.quantile(0.84) - parameter.prior.quantile(0.16));
    let sizes = [parameter.plausible.abs(), spread.abs(), parameter.nominal.abs(), 1.0];
    sizes.into_iter().find(|size| *size > 0.0 && size.is_finite()).unwrap_or(1.0)
}

/// Values at which the parameters that shape an effect are tried, SI: of one of them the thresholds that part the data
/// where it is one, else its nominal value and quantiles of its prior (a few more where it is spread evenly); of several
/// the product, as far as it is small, else the nominal values.
pub(super) fn shapes(
    parameters: &[EffectParameter],
    thresholds: impl Fn(&EffectParameter) -> Option<Vec<f64>>,
) -> Vec<Vec<f64>> {
    use crate::random::Distribution::{LogUniform, Uniform};
    const MOST: usize = 9;
    let mut all: Vec<Vec<f64>> = vec![Vec::new()];
    for parameter in parameters.iter().filter(|parameter| !parameter.amplitude) {
        let parting = if parameter.prior.is_fixed() { None } else { thresholds(parameter) };
        let values = parting.filter(|_| all.len() == 1).unwrap_or_else(|| {
            let mut values = vec![parameter.nominal];
            if !parameter.prior.is_fixed() {
                let at: &[f64] = match parameter.prior {
                    Uniform { .. } | LogUniform { .. } => &[0.1, 0.3, 0.7, 0.9],
                    _ => &[0.05, 0.95],
                };
                values.extend(at.iter().map(|&u| parameter.prior.quantile(u)));
            }
            values.truncate((MOST / all.len()).max(1));
            values
        });
        all = all.iter().flat_map(|before| values.iter().map(move |&v| [before.as_slice(), &[v]].concat())).collect();
    }
    all
}
