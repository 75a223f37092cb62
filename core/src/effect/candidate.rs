//! Every effect of a catalogue at every place of a model where it could be.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::expression::{ExprId, Graph, Names, Scope, Symbol, parse};
use crate::thermal::{Clock, Model, NodeKind};

use super::catalogue::Catalogue;
use super::checked::Effect;
use super::form::{AddsForm, EffectInputForm, SeenBy};
use super::place::{Bound, PlaceKind, SensorPlace, Site};

/// A group of a model, as effects see it.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupPlace {
    /// Its name.
    pub name: String,
    /// Its members.
    pub site: Site,
}

/// `where_kind` of a group.
pub const GROUP: &str = "group";

/// An effect at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Such as `conductive-path:baseplate:board`: the effect, the names of the place, the input if there is one.
    pub id: String,
    /// The effect.
    pub effect: String,
    /// Kind of the place, as in a result's `where_kind`.
    pub where_kind: &'static str,
    /// Names of the place; those of a pair in alphabetical order.
    pub place: Vec<String>,
    /// What the effect's inputs stand for; several joined by `*`.
    pub input: Option<String>,
    /// The place by indices.
    pub site: Site,
    /// What the effect's inputs stand for, in the order of its file.
    pub bound: Vec<Bound>,
    /// Whether steady phases can see it.
    pub steady: bool,
    /// Whether transients can see it.
    pub transient: bool,
}

impl Candidate {
    /// Inputs of the model that the effect goes with; no clocks.
    pub fn inputs(&self, model: &Model) -> Vec<usize> {
        let input = |bound: &Bound| match bound {
            Bound::Input(input) => Some(*input).filter(|input| !model.clocks.has(*input)),
            Bound::Node(_) => None,
        };
        self.bound.iter().filter_map(input).collect()
    }

    /// Whether it acts on a group.
    pub fn is_group(&self) -> bool {
        self.where_kind == GROUP
    }

    /// Whether this is the same effect on a group of which the other's place is a part.
    pub fn is_whole_of(&self, other: &Self) -> bool {
        self.holds_place_of(other) && self.effect == other.effect && self.input == other.input
    }

    /// Whether it acts on a whole group of nodes or elements, by whatever law, of which the other acts on a part; or is the whole of it.
    pub fn goes_before_member(&self, other: &Self) -> bool {
        self.is_whole_of(other) || !matches!(self.site, Site::Sensors(_)) && self.holds_place_of(other)
    }

    /// Whether it acts on a group beside which the other's place is another one: no part of it, and of the same kind.
    pub fn is_elsewhere_than(&self, other: &Self) -> bool {
        let is_alike = std::mem::discriminant(&self.site) == std::mem::discriminant(&other.site);
        self.is_group() && is_alike && !self.holds_place_of(other)
    }

    /// Whether its place is a group of which the other's is a part.
    fn holds_place_of(&self, other: &Self) -> bool {
        let is_part = match (&self.site, &other.site) {
            (Site::Nodes(whole), Site::Nodes(part)) => {
                part.iter().all(|(node, _)| whole.iter().any(|(own, _)| own == node)) && part.len() < whole.len()
            }
            (Site::Elements(whole), Site::Elements(part)) => {
                part.iter().all(|element| whole.contains(element)) && part.len() < whole.len()
            }
            (Site::Sensors(whole), Site::Sensors(part)) => {
                part.iter().all(|sensor| whole.contains(sensor)) && part.len() < whole.len()
            }
            _ => false,
        };
        self.is_group() && is_part
    }
}

/// A place before what its inputs stand for is chosen.
struct Spot {
    kind: &'static str,
    names: Vec<String>,
    site: Site,
    /// Nodes that may stand for an input that is a temperature.
    nodes: Vec<usize>,
}

/// Sizes of models up to which effects are tried at all places. In a larger model the diagnosis chooses places that its sensors
/// can tell apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Nodes of a model between any two of which effects are tried.
    pub nodes_in_pairs: usize,
    /// Nodes of a model at each of which, and at each of whose elements, effects are tried.
    pub nodes_one_by_one: usize,
    /// Elements of one kind that are places one by one in a model of any size.
    pub elements_of_a_kind: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self { nodes_in_pairs: 64, nodes_one_by_one: 160, elements_of_a_kind: 64 }
    }
}

impl Limits {
    /// Whether pairs of nodes are to be chosen, since they are too many.
    pub fn choose_pairs(&self, model: &Model) -> bool {
        model.nodes.len() > self.nodes_in_pairs
    }

    /// Whether nodes and elements are to be chosen too.
    pub fn choose_members(&self, model: &Model) -> bool {
        model.nodes.len() > self.nodes_one_by_one
    }

    /// The elements among which places are to be chosen, ascending: those of kinds of which a large model has many.
    pub fn elements_to_choose(&self, model: &Model) -> Vec<usize> {
        if !self.choose_members(model) {
            return Vec::new();
        }
        let mut by_kind: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (index, element) in model.elements.iter().enumerate() {
            by_kind.entry(element.physics().kind()).or_default().push(index);
        }
        let many = by_kind.into_values().filter(|own| own.len() > self.elements_of_a_kind);
        let mut chosen: Vec<usize> = many.flatten().collect();
        chosen.sort_unstable();
        chosen
    }
}

/// A place of a large model that is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Chosen {
    /// Effects between two nodes.
    Pair([usize; 2]),
    /// Effects on a node.
    Node(usize),
    /// Effects on an element.
    Element(usize),
    /// Effects of a node's temperature on sensors.
    Surroundings(usize),
}

/// What of a model is a place.
#[derive(Default)]
struct Among {
    pairs: Vec<[usize; 2]>,
    nodes: Vec<usize>,
    elements: Vec<usize>,
    /// Nodes whose temperatures effects on sensors know.
    surroundings: Vec<usize>,
}

impl Among {
    /// Everything that is a place without being chosen.
    fn of(model: &Model, limits: &Limits) -> Self {
        let count = if limits.choose_pairs(model) { 0 } else { model.nodes.len() };
        let pairs = (0..count).flat_map(|a| (a + 1..count).map(move |b| [a, b])).collect();
        let mut nodes: Vec<usize> = (0..model.nodes.len()).collect();
        if limits.choose_members(model) {
            nodes.retain(|&node| matches!(model.nodes[node].kind, NodeKind::Boundary { .. }));
        }
        let chosen = limits.elements_to_choose(model);
        let elements = (0..model.elements.len()).filter(|element| chosen.binary_search(element).is_err()).collect();
        Self { pairs, surroundings: nodes.clone(), nodes, elements }
    }
}

impl From<Chosen> for Among {
    fn from(chosen: Chosen) -> Self {
        match chosen {
            Chosen::Pair(pair) => Self { pairs: vec![pair], ..Self::default() },
            Chosen::Node(node) => Self { nodes: vec![node], ..Self::default() },
            Chosen::Element(element) => Self { elements: vec![element], ..Self::default() },
            Chosen::Surroundings(node) => Self { surroundings: vec![node], ..Self::default() },
        }
    }
}

/// All candidates, in the order of the catalogue, then of the model, within the usual [limits](Limits).
pub fn candidates(
    model: &Model,
    groups: &[GroupPlace],
    sensors: &[SensorPlace],
    catalogue: &Catalogue,
) -> Vec<Candidate> {
    candidates_within(&Limits::default(), model, groups, sensors, catalogue)
}

/// The same; where pairs are to be chosen those between two nodes are not among them, where nodes and elements are to be chosen too
/// only those at groups, boundaries, sensors, and elements of kinds of which the model has few.
pub fn candidates_within(
    limits: &Limits,
    model: &Model,
    groups: &[GroupPlace],
    sensors: &[SensorPlace],
    catalogue: &Catalogue,
) -> Vec<Candidate> {
    let among = Among::of(model, limits);
    let mut candidates = Vec::new();
    for effect in catalogue.effects() {
        for spot in spots(effect, model, groups, sensors, &among) {
            for bound in bindings(effect, model, &spot.nodes) {
                candidates.push(candidate(effect, model, &spot, bound, sensors));
            }
        }
    }
    without_copies(catalogue, candidates)
}

/// Without effects of the program where a study's own is the same law: no data tell the two apart.
fn without_copies(catalogue: &Catalogue, candidates: Vec<Candidate>) -> Vec<Candidate> {
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

/// The candidates at chosen places, in their order, then that of the catalogue, with effects that are wanted.
pub fn candidates_at(
    model: &Model,
    sensors: &[SensorPlace],
    catalogue: &Catalogue,
    chosen: &[Chosen],
    wanted: impl Fn(&str) -> bool,
) -> Vec<Candidate> {
    let mut candidates = Vec::new();
    for &place in chosen {
        let among = Among::from(place);
        let (acts, own): (fn(PlaceKind) -> bool, &[SensorPlace]) = match place {
            Chosen::Pair(_) => (|kind| kind == PlaceKind::Pair, &[]),
            Chosen::Node(_) => (|kind| matches!(kind, PlaceKind::Node | PlaceKind::Capacity), &[]),
            Chosen::Element(_) => (PlaceKind::is_of_elements, &[]),
            Chosen::Surroundings(_) => (|kind| kind == PlaceKind::Sensor, sensors),
        };
        let fits = |effect: &&Effect| wanted(&effect.name) && effect.places.iter().any(|&kind| acts(kind));
        for effect in catalogue.effects().iter().filter(fits) {
            for spot in spots(effect, model, &[], own, &among) {
                for bound in bindings(effect, model, &spot.nodes) {
                    // What does not know the node's temperature is a candidate without it.
                    let is_new = match place {
                        Chosen::Surroundings(node) => bound.contains(&Bound::Node(node)),
                        _ => true,
                    };
                    if is_new {
                        candidates.push(candidate(effect, model, &spot, bound, sensors));
                    }
                }
            }
        }
    }
    candidates
}

fn candidate(effect: &Effect, model: &Model, spot: &Spot, bound: Vec<Bound>, sensors: &[SensorPlace]) -> Candidate {
    let of_sensor = effect.places.contains(&PlaceKind::Sensor);
    let mut place = spot.names.clone();
    // When is no name of a place.
    let bound_names = bound.iter().filter(|one| !one.is_clock(model)).map(|one| one.name(model));
    let names: Vec<&str> = bound_names.collect();
    // A node that a sensor's reading depends on is part of the sensor's place.
    let node = of_sensor && matches!(bound.as_slice(), [Bound::Node(_)]);
    if node {
        place.extend(names.iter().map(|name| (*name).to_owned()));
    }
    let input = (!names.is_empty() && !node).then(|| names.join("*"));
    let mut id = effect.name.clone();
    for part in place.iter().chain(&input) {
        id.push(':');
        id.push_str(part);
    }
    let watching: &[SensorPlace] = match &spot.site {
        Site::Sensors(measured) => measured,
        _ => sensors,
    };
    let seen =
        |by: SeenBy, has: fn(&SensorPlace) -> bool| effect.form.seen_by.contains(&by) && watching.iter().any(has);
    Candidate {
        id,
        effect: effect.name.clone(),
        where_kind: spot.kind,
        place,
        input,
        site: spot.site.clone(),
        bound,
        steady: seen(SeenBy::Steady, |sensor| sensor.steady),
        transient: seen(SeenBy::Transient, |sensor| sensor.transient),
    }
}

fn spots(effect: &Effect, model: &Model, groups: &[GroupPlace], sensors: &[SensorPlace], among: &Among) -> Vec<Spot> {
    let mut spots = Vec::new();
    let name = |node: usize| model.nodes[node].name.clone();
    for &kind in &effect.places {
        let mut put = |names: Vec<String>, site: Site, nodes: Vec<usize>| {
            spots.push(Spot { kind: kind.where_kind(), names, site, nodes });
        };
        match kind {
            PlaceKind::Pair => {
                for &[a, b] in &among.pairs {
                    let given = |node: usize| matches!(model.nodes[node].kind, NodeKind::Boundary { .. });
                    if given(a) && given(b) {
                        continue;
                    }
                    let ends = if name(a) <= name(b) { [a, b] } else { [b, a] };
                    put(ends.map(name).to_vec(), Site::Pair(ends), ends.to_vec());
                }
            }
            PlaceKind::Node | PlaceKind::Boundary | PlaceKind::Capacity => {
                for &node in among.nodes.iter().filter(|node| kind.is_node(&model.nodes[**node].kind)) {
                    put(vec![name(node)], Site::Nodes([(node, 1.0)].into()), vec![node]);
                }
            }
            PlaceKind::Sensor => {
                for sensor in sensors.iter().filter(|sensor| effect.fits_sensor(model, sensor)) {
                    let all = among.surroundings.iter().copied();
                    let others = all.filter(|&node| !is_temperature_of(model, sensor, node)).collect();
                    put(vec![sensor.name.clone()], Site::Sensors(vec![sensor.clone()]), others);
                }
            }
            PlaceKind::SensorPair => {
                for (position, a) in sensors.iter().enumerate() {
                    for b in &sensors[position + 1..] {
                        let unit = |sensor: &SensorPlace| model.quantities.get(sensor.quantity).map(|q| &q.unit);
                        if unit(a) == unit(b) {
                            let (a, b) = if a.name <= b.name { (a, b) } else { (b, a) };
                            let names = vec![a.name.clone(), b.name.clone()];
                            put(names, Site::Sensors(vec![a.clone(), b.clone()]), Vec::new());
                        }
                    }
                }
            }
            _ => {
                for &index in among.elements.iter().filter(|index| kind.is_element(&model.elements[**index])) {
                    let element = &model.elements[index];
                    put(vec![element.name.clone()], Site::Elements([index].into()), element.nodes());
                }
            }
        }
    }
    if effect.groups {
        let fitting = groups.iter().filter(|group| effect.fits_group(model, &group.site));
        spots.extend(fitting.map(|group| Spot {
            kind: GROUP,
            names: vec![group.name.clone()],
            site: group.site.clone(),
            nodes: Vec::new(),
        }));
    }
    spots
}

fn is_temperature_of(model: &Model, sensor: &SensorPlace, node: usize) -> bool {
    let symbol = Bound::Node(node).symbol();
    model.quantities.get(sensor.quantity).is_some_and(|quantity| {
        model.graph.term(quantity.value.expression()) == crate::expression::Term::Symbol(symbol)
    })
}

/// What the effect's inputs may stand for together: each something else.
fn bindings(effect: &Effect, model: &Model, nodes: &[usize]) -> Vec<Vec<Bound>> {
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
            model.graph.term(temperature) == crate::expression::Term::Symbol(Bound::Input(input).symbol())
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
            return is_its_own && self.least_span.is_none_or(|span| last - first >= span);
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

impl Effect {
    /// Whether a load is the same with its two inputs exchanged.
    fn is_symmetric(&self) -> bool {
        let (Some(load), 2) = (&self.form.adds.value.load, self.form.inputs.len()) else { return false };
        let mut graph = Graph::new();
        let first = self.law(&load.value, &mut graph, &[0, 1]);
        first.is_some() && first == self.law(&load.value, &mut graph, &[1, 0])
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

    /// An expression of the effect where its inputs stand for these of a model; `None` where it does not parse.
    fn law(&self, text: &str, graph: &mut Graph, inputs: &[u32]) -> Option<ExprId> {
        let mut names = Names::default();
        for (index, entry) in (0u32..).zip(&self.form.parameters) {
            names.values.insert(entry.name.clone(), graph.symbol(Symbol::Parameter(index)));
        }
        let places = (0u32..).zip(["T", "Ta", "Tb", "Tm", "rate", "zero"]);
        let mut locals: Vec<(&str, ExprId)> =
            places.map(|(index, name)| (name, graph.symbol(Symbol::Node(index)))).collect();
        locals.extend(
            self.form.inputs.names().zip(inputs).map(|(name, &input)| (name, graph.symbol(Symbol::Input(input)))),
        );
        parse(text, graph, &Scope::with(&names, locals)).ok()
    }

    /// Whether a sensor's law fits what it measures: an amplitude in K, or none with a unit.
    pub fn fits_sensor(&self, model: &Model, sensor: &SensorPlace) -> bool {
        let Some(quantity) = model.quantities.get(sensor.quantity) else { return false };
        let per_temperature = self.form.adds.value.reading.is_some()
            && self.form.parameters.iter().any(|entry| {
                !entry.value.shape && entry.value.unit.as_ref().is_some_and(|written| !written.unit.dimension.is_none())
            });
        quantity.is_temperature || !per_temperature
    }

    /// Whether members of a group are places of this effect.
    pub fn fits_group(&self, model: &Model, site: &Site) -> bool {
        self.groups
            && self.places.iter().any(|&kind| match site {
                Site::Nodes(nodes) => nodes.iter().all(|&(node, _)| kind.is_node(&model.nodes[node].kind)),
                Site::Elements(elements) => elements.iter().all(|&element| kind.is_element(&model.elements[element])),
                Site::Sensors(sensors) => {
                    kind == PlaceKind::Sensor && sensors.iter().all(|sensor| self.fits_sensor(model, sensor))
                }
                Site::Pair(_) | Site::Parameter(_) => false,
            })
    }
}
