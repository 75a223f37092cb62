//! An effect with everything in its file checked.

use crate::document::formula::Expected;
use crate::document::name::{self, check_symbol};
use crate::document::prior::support;
use crate::document::{
    Diagnostic, Diagnostics, Empty, Formulas, MapEntry, Place, Prior, Spanned, WrittenUnit, code, counted, suggest,
};
use crate::expression::{Dependence, Dimension, ExprId, Graph, Names, Symbol};
use crate::thermal::Clock;

use super::form::{AddsForm, AppliesForm, CurveForm, EffectForm, Medium, ParameterForm, Sign};
use super::place::PlaceKind;

/// An effect whose file has been checked: its expressions parse, its names are known, its parts fit together.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Its name, that of its file.
    pub name: String,
    /// As written.
    pub form: EffectForm,
    /// Kinds of place that it may act on, in the order of [`PlaceKind::ALL`].
    pub places: Vec<PlaceKind>,
    /// Whether it may act on a group of such.
    pub groups: bool,
    /// Its file.
    pub json: serde_json::Value,
    /// Whether it is the program's own, whose sizes are meant for any hardware; a study's own are meant for that study's.
    pub embedded: bool,
}

/// What a parameter has the unit of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Like {
    /// An input of the effect, by its position.
    Input(usize),
    /// The temperature of the node on which the effect acts: of each member in a group.
    OwnTemperature,
}

/// The name of the node's own temperature in expressions.
const OWN_TEMPERATURE: &str = "T";

/// Kinds of place that an addition fits, with its name.
const FITS: &[(&str, &[PlaceKind])] = &[
    ("flow", &[PlaceKind::Pair, PlaceKind::Node]),
    ("load", &[PlaceKind::Node]),
    ("factor", &[PlaceKind::Conductor, PlaceKind::Radiation, PlaceKind::Load, PlaceKind::Heater, PlaceKind::Capacity]),
    ("capacity", &[PlaceKind::Node, PlaceKind::Capacity]),
    ("node", &[PlaceKind::Node, PlaceKind::Pair]),
    ("within", &[PlaceKind::Conductor]),
    ("source", &[PlaceKind::Load, PlaceKind::Heater]),
    ("ambient", &[PlaceKind::Node]),
    ("offset", &[PlaceKind::Boundary]),
    ("cooler", &[PlaceKind::Cooler]),
    ("contact", &[PlaceKind::Cooler]),
    ("curve", &[PlaceKind::Node]),
    ("reading", &[PlaceKind::Sensor]),
    ("lag", &[PlaceKind::Sensor]),
    ("clock", &[PlaceKind::Sensor]),
    ("swap", &[PlaceKind::SensorPair]),
];

impl AppliesForm {
    /// The kinds named, without groups.
    fn kinds(&self) -> Vec<PlaceKind> {
        let given = |kind: PlaceKind| -> &Option<Empty> {
            match kind {
                PlaceKind::Pair => &self.pair,
                PlaceKind::Node => &self.node,
                PlaceKind::Boundary => &self.boundary,
                PlaceKind::Conductor => &self.conductor,
                PlaceKind::Radiation => &self.radiation,
                PlaceKind::Load => &self.load,
                PlaceKind::Capacity => &self.capacity,
                PlaceKind::Heater => &self.heater,
                PlaceKind::Cooler => &self.cooler,
                PlaceKind::Sensor => &self.sensor,
                PlaceKind::SensorPair => &self.sensor_pair,
            }
        };
        PlaceKind::ALL.iter().copied().filter(|&kind| given(kind).is_some()).collect()
    }
}

impl AddsForm {
    /// Names of the additions given.
    pub(super) fn given(&self) -> Vec<&'static str> {
        let all = [
            ("flow", self.flow.is_some()),
            ("load", self.load.is_some()),
            ("factor", self.factor.is_some()),
            ("capacity", self.capacity.is_some()),
            ("node", self.node.is_some()),
            ("within", self.within.is_some()),
            ("source", self.source.is_some()),
            ("ambient", self.ambient.is_some()),
            ("offset", self.offset.is_some()),
            ("cooler", self.cooler.is_some()),
            ("contact", self.contact.is_some()),
            ("curve", self.curve.is_some()),
            ("reading", self.reading.is_some()),
            ("lag", self.lag.is_some()),
            ("clock", self.clock.is_some()),
            ("swap", self.swap.is_some()),
        ];
        all.into_iter().filter(|(_, given)| *given).map(|(name, _)| name).collect()
    }
}

impl Effect {
    /// Whether it is an unknown function, whose curve is learnt.
    pub fn is_unknown_function(&self) -> bool {
        self.form.adds.value.curve.is_some()
    }

    /// Whether all that it does is to let sensors show at other times what happens.
    pub fn only_changes_timing(&self) -> bool {
        matches!(self.form.adds.value.given()[..], ["lag" | "clock"])
    }

    /// Whether it needs a gas about the hardware.
    pub fn needs_gas(&self) -> bool {
        self.form.medium == Some(Medium::Gas)
    }

    /// Whether it needs what few articles have.
    pub fn is_rare(&self) -> bool {
        self.form.rare
    }

    /// Whether a gradient within a node reads the same.
    pub fn is_like_gradient(&self) -> bool {
        self.form.like_gradient
    }

    /// Whether it depends on when readings were taken, by this clock.
    pub fn depends_on(&self, clock: Clock) -> bool {
        self.form.inputs.iter().any(|entry| entry.value.clock() == Some(clock))
    }

    /// Whether it depends on when readings were taken, by any clock.
    pub fn depends_on_time(&self) -> bool {
        self.form.inputs.iter().any(|entry| entry.value.clock().is_some())
    }

    /// Whether it exchanges the channels of two sensors.
    pub fn exchanges_channels(&self) -> bool {
        self.form.adds.value.swap.is_some()
    }

    /// Whether it does nothing but store heat or follow it late, at a place of this kind: no steady phase shows it. A hidden node
    /// between two nodes is a path as well.
    pub fn only_stores(&self, where_kind: &str) -> bool {
        let stores = |name: &str| match name {
            "capacity" | "within" | "source" | "lag" | "clock" => true,
            "node" => where_kind != PlaceKind::Pair.where_kind(),
            _ => false,
        };
        let given = self.form.adds.value.given();
        !given.is_empty() && given.into_iter().all(stores)
    }

    /// What a parameter of the effect has the unit of instead of a unit of its own.
    pub fn like(&self, parameter: &ParameterForm) -> Option<Like> {
        let name = &parameter.unit_of.as_ref()?.value;
        let has_one_temperature = |place: &PlaceKind| matches!(place, PlaceKind::Node | PlaceKind::Capacity);
        match self.input(name) {
            Some(input) => Some(Like::Input(input)),
            None if name == OWN_TEMPERATURE && self.places.iter().all(has_one_temperature) => {
                Some(Like::OwnTemperature)
            }
            None => None,
        }
    }

    /// Inputs on which it depends: what is bound, and the node's own temperature where a parameter is a level of it.
    pub fn levels_and_inputs(&self) -> usize {
        let is_own = |entry: &MapEntry<ParameterForm>| self.like(&entry.value) == Some(Like::OwnTemperature);
        self.form.inputs.len() + usize::from(self.form.parameters.iter().any(is_own))
    }

    /// Checks an effect as written; `json` is its file. `None` after an error.
    pub fn new(name: &str, form: EffectForm, json: serde_json::Value, diagnostics: &mut Diagnostics) -> Option<Self> {
        let before = diagnostics.errors();
        let places = form.applies.value.kinds();
        if places.is_empty() {
            wrong(&form.applies.place, "the effect has no kind of place", "such as {\"pair\": {}}", diagnostics);
        }
        let effect = Self {
            name: name.to_owned(),
            groups: form.applies.value.group.is_some(),
            places,
            form,
            json,
            embedded: false,
        };
        effect.check_additions(diagnostics);
        effect.check_names(diagnostics);
        for entry in &effect.form.parameters {
            effect.check_parameter(entry, diagnostics);
        }
        if diagnostics.errors() == before {
            effect.check_expressions(diagnostics);
        }
        (diagnostics.errors() == before).then_some(effect)
    }

    fn check_additions(&self, diagnostics: &mut Diagnostics) {
        let adds = &self.form.adds;
        let given = adds.value.given();
        if given.is_empty() {
            wrong(&adds.place, "the effect adds nothing", "such as {\"flow\": \"...\"}", diagnostics);
        }
        for addition in &given {
            let fits = FITS.iter().find(|(name, _)| name == addition).map_or(&[][..], |(_, kinds)| kinds);
            for place in self.places.iter().filter(|place| !fits.contains(place)) {
                let words: Vec<&str> = fits.iter().map(|kind| kind.word()).collect();
                let message = format!("`{addition}` cannot act on a {}", place.word());
                let expected = format!("under `applies`: {}", suggest::listed(words, 12));
                wrong(&adds.place, &message, &expected, diagnostics);
            }
        }
        if adds.value.ambient.is_some() && adds.value.flow.is_none() {
            wrong(&adds.place, "`ambient` is the other end of a `flow`, and there is none", "a `flow`", diagnostics);
        }
        if adds.value.flow.is_some() && adds.value.ambient.is_none() && self.places.contains(&PlaceKind::Node) {
            let message = "a `flow` of one node needs an `ambient` as its other end";
            wrong(&adds.place, message, "\"ambient\": {\"temperature\": ...}", diagnostics);
        }
        if let Some(curve) = &adds.value.curve {
            if !(2..=20).contains(&curve.knots.value) {
                let message = format!("a curve of {}", counted(curve.knots.value, "knot"));
                wrong(&curve.knots.place, &message, "2 to 20", diagnostics);
            }
            if self.form.parameters.get(KNOT).is_none() {
                wrong(&adds.place, "a `curve` needs a parameter `knot`", "`knot` under `parameters`", diagnostics);
            }
        }
    }

    fn check_names(&self, diagnostics: &mut Diagnostics) {
        for entry in &self.form.inputs {
            check_symbol(&entry.name, &entry.name_place, diagnostics);
            if entry.value.date && entry.value.elapsed {
                let message = format!("`{}` is the date and the time since the start of a run", entry.name);
                wrong(&entry.name_place, &message, "one of the two; another input for the other", diagnostics);
            }
        }
        for entry in &self.form.parameters {
            check_symbol(&entry.name, &entry.name_place, diagnostics);
            if let Some(input) = self.form.inputs.get(&entry.name) {
                let message = format!("`{}` is the name of an input and of a parameter", entry.name);
                diagnostics.push(
                    Diagnostic::error(&code::DUPLICATE_NAME, &entry.name_place, message)
                        .related(&input.name_place, "the input"),
                );
            }
        }
        if self.form.adds.value.factor.is_some() {
            let expected = "another name: `Tr` is the reference temperature";
            self.refuse_names(&[REFERENCE], "a factor", expected, diagnostics);
        }
        let entries = self.form.parameters.iter().map(|entry| &entry.value);
        let mut asked: Vec<&Spanned<String>> = Vec::new();
        for parameter in entries {
            asked.extend(&parameter.per);
            let named = parameter.unit_of.iter().filter(|_| self.like(parameter) != Some(Like::OwnTemperature));
            asked.extend(named);
        }
        if let Some(CurveForm { of, times, .. }) = &self.form.adds.value.curve {
            asked.push(of);
            asked.extend(times);
        }
        for input in asked {
            if self.form.inputs.get(&input.value).is_none() {
                let input_names = self.form.inputs.iter().map(|entry| entry.name.as_str());
                name::unknown("input", &input.value, &input.place, input_names, diagnostics);
            }
        }
    }

    fn check_parameter(&self, entry: &MapEntry<ParameterForm>, diagnostics: &mut Diagnostics) {
        let form = &entry.value;
        let place = &entry.name_place;
        match (&form.unit, &form.unit_of) {
            (Some(_), Some(unit_of)) => {
                wrong(&unit_of.place, "a parameter has either `unit` or `unit_of`", "one of the two", diagnostics);
            }
            (None, None) => {
                diagnostics.push(
                    Diagnostic::error(&code::MISSING_FIELD, place, format!("`{}` has no unit", entry.name))
                        .expected("`unit`, or `unit_of` an input"),
                );
            }
            (None, Some(_)) if form.prior.is_some() || form.nominal.is_some() || form.plausible.is_some() => {
                let message = "with `unit_of` the scale follows from the bound input";
                wrong(place, message, "neither `prior` nor `nominal` nor `plausible`", diagnostics);
            }
            (None, Some(_)) => {}
            (Some(WrittenUnit { unit, .. }), None) => {
                let Some(prior) = &form.prior else {
                    diagnostics.push(
                        Diagnostic::error(&code::MISSING_FIELD, place, format!("`{}` has no prior", entry.name))
                            .expected("`prior`"),
                    );
                    return;
                };
                let amounts = form.nominal.iter().chain(&form.plausible).chain(&form.probes);
                for amount in amounts {
                    amount.si(unit.dimension, Some(unit), form.sense(), diagnostics);
                }
                match prior.resolve(Some(unit), unit.dimension, form.sense(), diagnostics) {
                    Some(Prior::Distribution(distribution)) => {
                        let [lower, upper] = support(&distribution);
                        if !form.sign.allows(lower) || !form.sign.allows(upper) {
                            let message = format!(
                                "the prior of `{}` reaches the sign that its `sign` excludes ({})",
                                entry.name,
                                form.sign.word()
                            );
                            wrong(place, &message, "a prior on one side of 0", diagnostics);
                        }
                    }
                    Some(Prior::Posterior { place, .. } | Prior::Draws { place, .. }) => {
                        wrong(&place, "an effect's own prior cannot be draws", "a distribution", diagnostics);
                    }
                    None => {}
                }
            }
        }
    }

    fn check_expressions(&self, diagnostics: &mut Diagnostics) {
        let mut graph = Graph::new();
        let mut names = Names::default();
        let mut put = |name: String, symbol: Symbol, dimension: Option<Dimension>| {
            let id = graph.symbol(symbol);
            names.values.insert(name, id);
            if let Some(dimension) = dimension {
                names.dimensions.insert(symbol, dimension);
            }
        };
        for (index, entry) in (0u32..).zip(&self.form.parameters) {
            let unit = entry.value.unit.as_ref().filter(|_| entry.value.per.is_empty());
            put(entry.name.clone(), Symbol::Parameter(index), unit.map(|written| written.unit.dimension));
        }
        for (index, entry) in (0u32..).zip(&self.form.inputs) {
            let dimension = match entry.value.unit.as_ref().map(|units| units.0.as_slice()) {
                Some([one]) => Some(one.unit.dimension),
                _ => None,
            };
            put(entry.name.clone(), Symbol::Input(index), dimension);
            put(format!("{}_lower", entry.name), Symbol::Local(2 * index), dimension);
            put(format!("{}_upper", entry.name), Symbol::Local(2 * index + 1), dimension);
        }
        let mut check = Check { graph, names, diagnostics };
        let adds = &self.form.adds.value;
        check.text(&adds.flow, Expected::value(Dimension::POWER, "a heat flow"), &["Ta", "Tb", "Tm"]);
        check.text(&adds.load, Expected::value(Dimension::POWER, "a power"), &["T"]);
        let has_ends = self.places.iter().any(|place| place.has_ends());
        let ends: &[&str] = if has_ends { &["Ta", "Tb", "Tm", REFERENCE] } else { &["T", REFERENCE] };
        check.text(&adds.factor, Expected::value(Dimension::NONE, "a factor"), ends);
        check.text(&adds.capacity, Expected::value(Dimension::HEAT_CAPACITY, "a heat capacity"), &["T"]);
        if let Some(node) = &adds.node {
            let capacity = Expected::value(Dimension::HEAT_CAPACITY, "a heat capacity");
            check.text(&Some(node.capacity.clone()), capacity, &["T"]);
            let conductance = Expected::value(Dimension::CONDUCTANCE, "a conductance");
            check.text(&Some(node.conductance.clone()), conductance, &[]);
        }
        if let Some(within) = &adds.within {
            let capacity = Expected::value(Dimension::HEAT_CAPACITY, "a heat capacity").given();
            check.text(&Some(within.capacity.clone()), capacity, &[]);
            check.text(&Some(within.share.clone()), Expected::value(Dimension::NONE, "a share").given(), &[]);
        }
        if let Some(source) = &adds.source {
            let capacity = Expected::value(Dimension::HEAT_CAPACITY, "a heat capacity").given();
            check.text(&Some(source.capacity.clone()), capacity, &[]);
            let conductance = Expected::value(Dimension::CONDUCTANCE, "a conductance").given();
            check.text(&Some(source.conductance.clone()), conductance, &[]);
        }
        if let Some(ambient) = &adds.ambient {
            let temperature = Expected::value(Dimension::TEMPERATURE, "a temperature").given();
            check.text(&Some(ambient.temperature.clone()), temperature, &[]);
        }
        check.text(&adds.offset, Expected::value(Dimension::TEMPERATURE, "an offset").given(), &[]);
        if let Some(cooler) = &adds.cooler {
            for factor in [&cooler.seebeck, &cooler.resistance, &cooler.conductance] {
                check.text(factor, Expected::value(Dimension::NONE, "a factor"), &["Ta", "Tb", "Tm"]);
            }
        }
        let resistance = Dimension::TEMPERATURE.over(Dimension::POWER);
        check.text(&adds.contact, Expected::value(resistance, "a resistance").given(), &[]);
        let times = [
            (&adds.lag, "a time constant", "a lag is one of the parameters itself"),
            (&adds.clock, "a time", "the time of a clock is one of the parameters itself"),
        ];
        for (time, what, message) in times {
            check.text(time, Expected::value(Dimension::TIME, what).given(), &[]);
            if let Some(time) = time.as_ref().filter(|time| self.form.parameters.get(&time.value).is_none()) {
                wrong(&time.place, message, "a parameter's name", check.diagnostics);
            }
        }
        if let Some(reading) = &adds.reading {
            // A sensor may measure anything: of its reading only the names are checked.
            let locals = check.locals(&["T", RATE, ZERO]);
            let mut formulas = Formulas { graph: &mut check.graph, names: &check.names };
            formulas.parse(reading, &locals, check.diagnostics);
            let expected = "another name: `rate` is the reading's rate of change, `zero` its zero";
            self.refuse_names(&[RATE, ZERO], "a reading", expected, check.diagnostics);
        }
    }

    /// Refuses parameters and inputs with a name that an expression of this kind knows already.
    fn refuse_names(&self, known: &[&str], expression: &str, expected: &str, diagnostics: &mut Diagnostics) {
        let parameters = self.form.parameters.iter().map(|entry| (&entry.name, &entry.name_place));
        let own = parameters.chain(self.form.inputs.iter().map(|entry| (&entry.name, &entry.name_place)));
        for (name, place) in own.filter(|(name, _)| known.contains(&name.as_str())) {
            let message = format!("in {expression} `{name}` means something else already");
            diagnostics.push(Diagnostic::error(&code::EFFECT_FILE, place, message).expected(expected));
        }
    }
}

/// Rate of change of what a sensor measures. In a reading only: elsewhere a parameter may have this name.
const RATE: &str = "rate";
/// Zero of what a sensor measures, likewise.
const ZERO: &str = "zero";

/// The reference temperature, in a factor only: a law of temperature is 1 there.
pub(super) const REFERENCE: &str = "Tr";
/// What stands for it in an expression of the effect alone.
pub const REFERENCE_SYMBOL: Symbol = Symbol::Local(u32::MAX);
/// The reference temperature of an effect that states none, K: 20 degC, at which data sheets state properties.
pub const REFERENCE_K: f64 = 293.15;

/// The parameter that describes a curve's knots.
pub const KNOT: &str = "knot";

impl Sign {
    /// Whether a value is on a side that it allows.
    pub fn allows(self, value: f64) -> bool {
        match self {
            Self::Positive => value >= 0.0,
            Self::Negative => value <= 0.0,
            Self::Either => true,
        }
    }
}

fn wrong(place: &Place, message: &str, expected: &str, diagnostics: &mut Diagnostics) {
    diagnostics.push(Diagnostic::error(&code::EFFECT_FILE, place, message).expected(expected));
}

/// Expressions that are tried with stand-ins for everything that they may name.
struct Check<'d> {
    graph: Graph,
    names: Names,
    diagnostics: &'d mut Diagnostics,
}

impl Check<'_> {
    fn locals(&mut self, names: &[&'static str]) -> Vec<(&'static str, ExprId)> {
        (0u32..).zip(names).map(|(index, name)| (*name, self.graph.symbol(Symbol::Node(index)))).collect()
    }

    fn text(&mut self, text: &Option<Spanned<String>>, expected: Expected, locals: &[&'static str]) {
        let Some(text) = text else { return };
        let locals = self.locals(locals);
        // Ranges of inputs stand as local values.
        let expected = Expected { allowed: expected.allowed.union(Dependence::LOCAL), ..expected };
        let mut formulas = Formulas { graph: &mut self.graph, names: &self.names };
        formulas.text(text, expected, &locals, self.diagnostics);
    }
}
