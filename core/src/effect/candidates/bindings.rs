//! What of a model the inputs of an effect may stand for.

use crate::effect::checked::Effect;
use crate::effect::form::EffectInputForm;
use crate::effect::place::{Bound, PlaceKind};
use crate::expression::Term;
use crate::thermal::{Clock, Model, NodeKind};

/// What the effect's inputs may stand for together: each something else.
pub(super) fn bindings(effect: &Effect, model: &Model, nodes: &[usize]) -> Vec<Vec<Bound>> {
    let mut all: Vec<Vec<Bound>> = vec![Vec::new()];
    for entry in &effect.form.inputs {
        let choices: Vec<Bound> = (0..model.inputs.len())
            .map(Bound::Input)
            .chain(nodes.iter().copied().map(Bound::Node))
            .filter(|&bound| entry.value.fits(model, bound))
            .collect();
        let of_sensor = effect.places.contains(&PlaceKind::Sensor);
        let choices = without_doubles(model, &choices, of_sensor);
        let longer = all.iter().flat_map(|before| {
            let free = choices.iter().filter(|choice| !before.contains(choice));
            free.map(|&choice| before.iter().copied().chain([choice]).collect())
        });
        all = longer.collect();
    }
    if effect.is_symmetric() {
        let place = |bound: &Bound| match *bound {
            Bound::Input(index) => (0, index),
            Bound::Node(index) => (1, index),
        };
        all.retain(|pair| pair.windows(2).all(|two| place(&two[0]) < place(&two[1])));
    }
    all
}

/// Whether a node is a boundary whose temperature is an input.
fn is_boundary_input(model: &Model, node: usize, input: usize) -> bool {
    match model.nodes[node].kind {
        NodeKind::Boundary { temperature } => {
            model.graph.term(temperature) == Term::Symbol(Bound::Input(input).symbol())
        }
        NodeKind::Diffusion { .. } | NodeKind::Arithmetic => false,
    }
}

/// Choices without those that are the same twice: a boundary whose temperature is an input, and that input. A sensor sees
/// the node, everything else the input.
fn without_doubles(model: &Model, choices: &[Bound], of_sensor: bool) -> Vec<Bound> {
    let is_double = |choice: &Bound| {
        choices.iter().any(|other| match (*choice, *other) {
            (Bound::Input(input), Bound::Node(node)) => of_sensor && is_boundary_input(model, node, input),
            (Bound::Node(node), Bound::Input(input)) => !of_sensor && is_boundary_input(model, node, input),
            _ => false,
        })
    };
    choices.iter().copied().filter(|choice| !is_double(choice)).collect()
}

impl EffectInputForm {
    /// The clock for which it stands, if it does.
    pub fn clock(&self) -> Option<Clock> {
        let clocks = [(self.date, Clock::Date), (self.elapsed, Clock::Elapsed)];
        clocks.into_iter().find_map(|(is_it, clock)| is_it.then_some(clock))
    }

    /// Whether it may stand for an input or node of the model.
    pub fn fits(&self, model: &Model, bound: Bound) -> bool {
        let clock = self.clock();
        if clock.is_some() || bound.is_clock(model) {
            let [first, last] = bound.range(model);
            let is_its_own = clock.and_then(|clock| model.clocks.get(clock)).map(Bound::Input) == Some(bound);
            let is_seen = self.most_apart.is_none_or(|apart| model.clocks.rows_apart_s <= apart);
            return is_its_own && is_seen && self.least_span.is_none_or(|span| last - first >= span);
        }
        if let Bound::Input(input) = bound
            && model.switches.contains(&input)
        {
            return false;
        }
        let is_boundary = |input: usize| (0..model.nodes.len()).any(|node| is_boundary_input(model, node, input));
        let (allowed, dimension) = match bound {
            Bound::Node(_) => (self.temperature, None),
            Bound::Input(input) => (self.input && (self.boundary || !is_boundary(input)), Some(bound.dimension(model))),
        };
        let fits = match (&self.unit, dimension) {
            (Some(units), Some(dimension)) => (units.0.iter())
                .any(|unit| Some(unit.unit.dimension) == dimension && (!unit.unit.is_angle() || bound.is_angle(model))),
            _ => true,
        };
        allowed && fits
    }
}
