//! What law an effect is, whatever its parameters and inputs are called.

use std::collections::BTreeMap;

use crate::expression::{ExprId, Graph, Names, Scope, Symbol, parse};

use super::candidate::Candidate;
use super::catalogue::Catalogue;
use super::checked::{Effect, REFERENCE, REFERENCE_K, REFERENCE_SYMBOL};
use super::form::AddsForm;

/// Without effects of the program where a study's own is the same law: no data tell the two apart.
pub(super) fn without_copies(catalogue: &Catalogue, candidates: Vec<Candidate>) -> Vec<Candidate> {
    let of_study: Vec<&Effect> = catalogue.effects().iter().filter(|effect| !effect.embedded).collect();
    let copied = |effect: &Effect| -> Vec<&str> {
        let alike = of_study.iter().filter(|own| own.is_same_law(effect));
        alike.map(|own| own.name.as_str()).collect()
    };
    let copies: BTreeMap<&str, Vec<&str>> = (catalogue.effects().iter().filter(|effect| effect.embedded))
        .map(|effect| (effect.name.as_str(), copied(effect)))
        .filter(|(_, own)| !own.is_empty())
        .collect();
    let is_copy = |one: &Candidate| {
        copies.get(one.effect.as_str()).is_some_and(|own| {
            let is_own = |other: &&Candidate| own.contains(&other.effect.as_str());
            candidates.iter().filter(is_own).any(|other| other.site == one.site && other.bound == one.bound)
        })
    };
    let kept: Vec<bool> = candidates.iter().map(|one| !is_copy(one)).collect();
    candidates.into_iter().zip(kept).filter_map(|(one, keep)| keep.then_some(one)).collect()
}

impl Effect {
    /// Whether a load is the same with its two inputs exchanged.
    pub(super) fn is_symmetric(&self) -> bool {
        let (Some(load), 2) = (&self.form.adds.value.load, self.form.inputs.len()) else { return false };
        let mut graph = Graph::new();
        let first = self.law(&load.value, &mut graph, &[0, 1]);
        first.is_some() && first == self.law(&load.value, &mut graph, &[1, 0])
    }

    /// Whether it adds heat that is in proportion to its one input, whatever the temperatures are.
    pub fn is_proportional_load(&self) -> bool {
        let (Some(load), 1) = (&self.form.adds.value.load, self.form.inputs.len()) else { return false };
        let mut graph = Graph::new();
        let Some(heat) = self.law(&load.value, &mut graph, &[0]) else { return false };
        let input = Symbol::Input(0);
        let slope = graph.derivative(heat, input);
        let is_linear = !graph.symbols(slope).contains(&input) && graph.constant(slope) != Some(0.0);
        let needs_temperature = graph.symbols(heat).iter().any(|symbol| matches!(symbol, Symbol::Node(_)));
        is_linear && !needs_temperature && self.form.adds.value.given().len() == 1
    }

    /// Whether both add nothing but the same heat, factor or reading, whatever its parameters and inputs are called.
    pub fn is_same_law(&self, other: &Self) -> bool {
        let (own, others) = (&self.form.adds.value, &other.form.adds.value);
        let expression = |adds: &AddsForm| -> [Option<String>; 4] {
            [&adds.flow, &adds.load, &adds.factor, &adds.reading].map(|one| one.as_ref().map(|text| text.value.clone()))
        };
        if own.given().len() != 1
            || others.given().len() != 1
            || self.form.inputs.len() != other.form.inputs.len()
            || self.form.parameters.len() != other.form.parameters.len()
        {
            return false;
        }
        let order: Vec<u32> = (0u32..).take(self.form.inputs.len()).collect();
        let mut graph = Graph::new();
        expression(own).into_iter().zip(expression(others)).any(|pair| {
            let (Some(one), Some(two)) = pair else { return false };
            let first = self.law(&one, &mut graph, &order);
            first.is_some() && first == other.law(&two, &mut graph, &order)
        })
    }

    /// Whether its factor names a reference temperature.
    pub fn has_reference(&self) -> bool {
        let is_of_word = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
        let names = |text: &str| text.split(|letter| !is_of_word(letter)).any(|word| word == REFERENCE);
        self.form.adds.value.factor.as_ref().is_some_and(|factor| names(&factor.value))
    }

    /// Its factor over what it may depend on: its parameters and inputs by their positions in its file, temperatures, which are nodes,
    /// and the [reference temperature](REFERENCE_SYMBOL).
    /// `None` where it is no factor, or takes the ends of an input's range.
    pub fn factor(&self, graph: &mut Graph) -> Option<ExprId> {
        let order: Vec<u32> = (0u32..).take(self.form.inputs.len()).collect();
        let reference = graph.symbol(REFERENCE_SYMBOL);
        self.law_at(&self.form.adds.value.factor.as_ref()?.value, graph, &order, reference)
    }

    /// An expression of the effect where its inputs stand for these of a model, with the reference temperature of what states none; `None`
    /// where it does not parse.
    fn law(&self, text: &str, graph: &mut Graph, inputs: &[u32]) -> Option<ExprId> {
        let reference = graph.number(REFERENCE_K);
        self.law_at(text, graph, inputs, reference)
    }

    /// The same with a reference temperature.
    fn law_at(&self, text: &str, graph: &mut Graph, inputs: &[u32], reference: ExprId) -> Option<ExprId> {
        let mut names = Names::default();
        for (index, entry) in (0u32..).zip(&self.form.parameters) {
            names.values.insert(entry.name.clone(), graph.symbol(Symbol::Parameter(index)));
        }
        let places = (0u32..).zip(["T", "Ta", "Tb", "Tm", "rate", "zero"]);
        let is_free = |name: &str| self.form.parameters.get(name).is_none();
        let places = places.filter(|(_, name)| is_free(name));
        let mut locals: Vec<(&str, ExprId)> =
            places.map(|(index, name)| (name, graph.symbol(Symbol::Node(index)))).collect();
        locals.extend(
            self.form.inputs.names().zip(inputs).map(|(name, &input)| (name, graph.symbol(Symbol::Input(input)))),
        );
        if is_free(REFERENCE) {
            locals.push((REFERENCE, reference));
        }
        parse(text, graph, &Scope::with(&names, locals)).ok()
    }
}
