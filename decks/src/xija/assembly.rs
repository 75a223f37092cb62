//! The deck as it grows, component by component.

use std::collections::{HashMap, HashSet};

use crate::deck::{Deck, Input, Load, Note, Value};
use crate::error::DeckError;

use super::class::Class;
use super::component::Component;
use super::specification::{Entry, Specification};
use super::{NODE_CAPACITY_J_PER_K, earth, electronics, heater, network, solar};

/// Names that expressions give a meaning.
const RESERVED: &[&str] = &[
    "exp",
    "log",
    "sqrt",
    "sin",
    "cos",
    "tanh",
    "min",
    "max",
    "abs",
    "step",
    "smoothstep",
    "clamp",
    "interp",
    "pi",
    "sigma",
    "t",
    "T",
    "Ta",
    "Tb",
    "Tm",
];

/// A deck that grows.
pub struct Assembly<'a> {
    /// The deck so far.
    pub deck: Deck,
    /// What is read.
    pub specification: &'a Specification<'a>,
    /// Heat capacity of every node in J/K.
    pub capacity_j_per_k: f64,
    /// The time constant of each of the deck's couplings; none of a radiative one.
    pub taus_ks: Vec<Option<f64>>,
    /// Nodes with the rate at which a proportional heater pulls each to its set point.
    pub heater_rates_per_ks: Vec<(usize, f64)>,
    classes: HashMap<&'a str, Class>,
    /// Index of a component's node in the deck.
    nodes: HashMap<&'a str, usize>,
    /// Identifier of a component's input.
    inputs: HashMap<String, String>,
    identifiers: HashSet<String>,
    /// The next parameter of the list.
    pub next: usize,
    /// How many parameters stand in the list under another name.
    pub renamed: usize,
}

impl<'a> Assembly<'a> {
    /// An empty deck for a specification.
    pub fn new(specification: &'a Specification<'a>) -> Self {
        let deck = Deck { title: specification.title.to_owned(), tool: "xija".to_owned(), ..Deck::default() };
        let entries = specification.entries.iter();
        Self {
            deck,
            specification,
            capacity_j_per_k: NODE_CAPACITY_J_PER_K / specification.method.rate_factor(),
            taus_ks: Vec::new(),
            heater_rates_per_ks: Vec::new(),
            classes: entries.filter_map(|entry| Some((entry.name, Class::of(entry.class_name)?))).collect(),
            nodes: HashMap::new(),
            inputs: HashMap::new(),
            identifiers: HashSet::new(),
            next: 0,
            renamed: 0,
        }
    }

    /// Takes all components.
    ///
    /// # Errors
    /// Every component that is refused.
    pub fn finish(mut self) -> Result<Deck, Vec<DeckError>> {
        let specification = self.specification;
        let mut errors = Vec::new();
        let mut components = Vec::new();
        let refused = |entry: &Entry<'_>, message: String| {
            let message = format!("component `{}` of class {}: {message}", entry.name, entry.class_name);
            DeckError { file: specification.file.to_owned(), line: entry.line, message }
        };
        for entry in &specification.entries {
            let component = Component::of(entry).and_then(|component| {
                if component.class.is_node() {
                    let at = network::node(&mut self, &component)?;
                    self.nodes.insert(entry.name, at);
                }
                Ok(component)
            });
            components.push(component.map_err(|message| errors.push(refused(entry, message))).ok());
        }
        for (entry, component) in specification.entries.iter().zip(&components) {
            let start = self.next;
            let result = component.as_ref().map(|component| self.take(component));
            if let Some(Err(message)) = &result {
                errors.push(refused(entry, message.clone()));
            }
            if !matches!(result, Some(Ok(()))) {
                // The next component's parameters begin behind those that bear this one's name.
                let rest = specification.fitted.get(start..).unwrap_or_default();
                self.next = start + rest.iter().take_while(|fitted| fitted.component == entry.name).count();
            }
        }
        if errors.is_empty() && self.next < specification.fitted.len() {
            let (used, all) = (self.next, specification.fitted.len());
            let message =
                format!("`pars` has {all} parameters, but the components have {used} in all; remove the others");
            errors.push(DeckError::of(specification.file, message));
        }
        if self.deck.nodes.is_empty() && errors.is_empty() {
            errors.push(DeckError::of(specification.file, "no component of class Node: there is nothing to predict"));
        }
        if !errors.is_empty() {
            return Err(errors);
        }
        network::merge_opposite(&mut self.deck, &mut self.taus_ks);
        self.general_notes();
        Ok(self.deck)
    }

    fn take(&mut self, component: &Component<'_>) -> Result<(), String> {
        match component.class {
            // Nodes come first; drivers become inputs where something depends on them.
            Class::Node | Class::AcisFPtemp => Ok(()),
            Class::Pitch | Class::Roll | Class::Eclipse | Class::SimZ => Ok(()),
            Class::DetectorHousingHeater | Class::TelemData | Class::CmdStatesData => Ok(()),
            Class::Coupling => network::coupling(self, component),
            Class::RadiativeCoupling => network::radiative_coupling(self, component),
            Class::HeatSink => network::heat_sink(self, component),
            Class::HeatSinkRef => network::heat_sink_with_reference(self, component),
            Class::Delay => network::delay(self, component),
            Class::Mask | Class::MaskBox => network::mask(self, component),
            Class::SolarHeat
            | Class::SolarHeatMulplicative
            | Class::SolarHeatAcisCameraBody
            | Class::SolarHeatHrc
            | Class::SolarHeatHrcOpts
            | Class::SolarHeatHrcMult => solar::by_pitch(self, component),
            Class::SolarHeatOffNomRoll => solar::by_roll(self, component),
            Class::AllSimZSolarHeat
            | Class::AcisPsmcSolarHeat
            | Class::HrcISAcisSimZSolarHeat
            | Class::AcisISHrcSimZSolarHeat => solar::by_instrument(self, component),
            Class::EarthHeat => earth::heat(self, component),
            Class::AcisDpaStatePower => electronics::power_of_states(self, component),
            Class::AcisDpaPower => electronics::measured_power(self, component),
            Class::StepFunctionPower => electronics::step(self, component),
            Class::MsidStatePower => electronics::power_of_telemetry(self, component),
            Class::PropHeater => heater::proportional(self, component),
            Class::ThermostatHeater => heater::thermostat(self, component),
        }
    }

    /// Index of the node that a component names.
    ///
    /// # Errors
    /// No such node.
    pub fn node(&self, component: &Component<'_>, argument: &str) -> Result<usize, String> {
        let name = component.arguments.required_text(argument)?;
        self.nodes.get(name).copied().ok_or_else(|| format!("`{argument}` is `{name}`, which is no Node of `comps`"))
    }

    /// The class of a component.
    pub fn class_of(&self, name: &str) -> Option<Class> {
        self.classes.get(name).copied()
    }

    /// An identifier like `wanted` that is not in use.
    pub fn identifier(&mut self, wanted: &str) -> String {
        let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let mut name: String = wanted.chars().map(|c| if is_part(c) { c } else { '_' }).collect();
        if !name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') || RESERVED.contains(&name.as_str()) {
            name.insert(0, '_');
        }
        let mut unique = name.clone();
        let mut count = 1;
        while !self.identifiers.insert(unique.clone()) {
            count += 1;
            unique = format!("{name}_{count}");
        }
        unique
    }

    /// The identifier of an input, declared when it is first asked for; `wanted` is its name.
    pub fn input(&mut self, wanted: &str, unit: &str, nominal: f64, description: &str) -> String {
        if let Some(name) = self.inputs.get(wanted) {
            return name.clone();
        }
        let name = self.identifier(wanted);
        let (unit, description) = (unit.to_owned(), description.to_owned());
        self.deck.inputs.push(Input { name: name.clone(), unit, nominal, description });
        self.inputs.insert(wanted.to_owned(), name.clone());
        name
    }

    /// The input of the component that an argument names, or of `default` where it is absent; none without either.
    ///
    /// # Errors
    /// No such component; one of another class than one of `classes`.
    pub fn driver(
        &mut self,
        component: &Component<'_>,
        argument: &str,
        default: Option<&str>,
        classes: &[Class],
    ) -> Result<Option<String>, String> {
        let Some(name) = component.arguments.text(argument)?.or(default) else { return Ok(None) };
        let class = self.class_of(name).ok_or_else(|| {
            format!("`{argument}` is `{name}`, which is no component of `comps`; add it or correct the name")
        })?;
        if !classes.contains(&class) {
            return Err(format!("`{argument}` is `{name}` of class {class:?}; expected is {classes:?}"));
        }
        let (unit, nominal, description) = match class {
            Class::Pitch => ("deg", 90.0, "angle between the Sun and the line of sight, 45 to 180 deg"),
            Class::Roll => ("deg", 0.0, "off-nominal roll"),
            Class::Eclipse => ("1", 0.0, "1 in the Earth's shadow, else 0"),
            Class::SimZ => ("1", 75_624.0, "position of the science instrument module in steps"),
            Class::DetectorHousingHeater => ("1", 0.0, "1 while the detector housing heater is on, else 0"),
            Class::CmdStatesData => ("1", 0.0, "number or flag of the commanded state"),
            _ => ("1", 0.0, "telemetry"),
        };
        Ok(Some(self.input(name, unit, nominal, description)))
    }

    /// As [`Self::node`], of a node that the model computes.
    ///
    /// # Errors
    /// No such node; one whose temperature is given.
    pub fn predicted_node(&self, component: &Component<'_>, argument: &str) -> Result<usize, String> {
        let at = self.node(component, argument)?;
        match self.deck.nodes.get(at) {
            Some(node) if network::is_predicted(node) => Ok(at),
            _ => {
                Err(format!("`{argument}` is a node that is not predicted (`predict` is false): nothing can act on it"))
            }
        }
    }

    /// Adds a heat into the component's `node`.
    ///
    /// # Errors
    /// No such node.
    pub fn load(&mut self, component: &Component<'_>, power: String) -> Result<(), String> {
        let into = self.predicted_node(component, "node")?;
        self.deck.loads.push(Load { name: component.name.to_owned(), into, power: Value::Expression(power) });
        Ok(())
    }

    /// Adds a sentence at the component's line.
    pub fn note(&mut self, component: &Component<'_>, message: impl Into<String>) {
        let place = component.line.map(|line| format!("{}:{line}", self.specification.file));
        self.deck.notes.push(Note { place, ..Note::new(message) });
    }
}
