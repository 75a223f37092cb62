//! Elements of the network from their written form.

use crate::document::formula::Expected;
use crate::document::{Diagnostic, Diagnostics, MapEntry, Place, Scalar, Spanned, code, counted};
use crate::expression::{Dimension, ExprId};
use crate::thermal::element::{
    Conductor, Cooler, Element, ElementKind, Flow, Heater, HeaterControl, Load, Radiation, cooler::Drive, law,
};

use super::form::{CoolerForm, HeaterForm, ModelForm};
use super::name;
use super::resolve::ResolvedModel;

/// The kinds of element, for looking up names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Linear conductor.
    Conductor,
    /// Radiative exchange.
    Radiation,
    /// Heat into a node.
    Load,
    /// Any heat flow between two nodes.
    Flow,
    /// Thermoelectric cooler.
    Cooler,
    /// Controlled heater.
    Heater,
}

impl Kind {
    /// All kinds.
    pub const ALL: &[Self] = &[Self::Conductor, Self::Radiation, Self::Load, Self::Flow, Self::Cooler, Self::Heater];

    /// The kind of an element.
    pub fn of(element: &Element) -> Self {
        match element.kind {
            ElementKind::Conductor(_) => Self::Conductor,
            ElementKind::Radiation(_) => Self::Radiation,
            ElementKind::Load(_) => Self::Load,
            ElementKind::Flow(_) => Self::Flow,
            ElementKind::Cooler(_) => Self::Cooler,
            ElementKind::Heater(_) => Self::Heater,
        }
    }

    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Conductor => "conductor",
            Self::Radiation => "radiation",
            Self::Load => "load",
            Self::Flow => "flow",
            Self::Cooler => "cooler",
            Self::Heater => "heater",
        }
    }
}

const CONDUCTANCE: Expected = Expected::value(Dimension::CONDUCTANCE, "a conductance");
const EXCHANGE_AREA: Expected = Expected::value(Dimension::AREA, "an exchange area");
const POWER: Expected = Expected::value(Dimension::POWER, "a power");
const HEAT: Expected = Expected::value(Dimension::POWER, "a heat flow");
const VOLTAGE: Expected = Expected::value(Dimension::VOLTAGE, "a voltage");
const CURRENT: Expected = Expected::value(Dimension::CURRENT, "a current");
const SEEBECK: Expected = Expected::value(Dimension::SEEBECK, "a Seebeck coefficient");
const RESISTANCE: Expected = Expected::value(Dimension::RESISTANCE, "a resistance");
const COUPLES: Expected = Expected::value(Dimension::NONE, "a number of couples").given();
const SET_POINT: Expected = Expected::value(Dimension::TEMPERATURE, "a set point").given();
const BAND: Expected = Expected::value(Dimension::TEMPERATURE, "a band").given().difference();

/// Reports an impossible constant.
fn refuse(place: &Place, message: String, expected: &str, diagnostics: &mut Diagnostics) {
    diagnostics.push(Diagnostic::error(&code::OUT_OF_RANGE, place, message).expected(expected));
}

/// Resolves all elements into the model, in the order of [`Kind::ALL`].
pub(super) fn resolve_all(form: &ModelForm, model: &mut ResolvedModel, diagnostics: &mut Diagnostics) {
    name::check_labels(&form.conductors, diagnostics);
    name::check_labels(&form.radiations, diagnostics);
    name::check_labels(&form.loads, diagnostics);
    name::check_labels(&form.flows, diagnostics);
    name::check_labels(&form.coolers, diagnostics);
    name::check_labels(&form.heaters, diagnostics);
    for entry in &form.conductors {
        model.places.note("conductor", &entry.name, law::CONDUCTANCE, entry.value.conductance.place());
        let path = model.path(&entry.value.between, &entry.value.conductance, CONDUCTANCE, diagnostics);
        model.add(entry, path.map(|(between, conductance)| ElementKind::Conductor(Conductor { between, conductance })));
    }
    for entry in &form.radiations {
        model.places.note("radiation", &entry.name, law::EXCHANGE_AREA, entry.value.exchange_area.place());
        let path = model.path(&entry.value.between, &entry.value.exchange_area, EXCHANGE_AREA, diagnostics);
        model.add(
            entry,
            path.map(|(between, exchange_area)| ElementKind::Radiation(Radiation { between, exchange_area })),
        );
    }
    for entry in &form.loads {
        let into = model.find_node(&entry.value.into.value, &entry.value.into.place, diagnostics);
        let mut locals = Vec::new();
        if let Some(into) = into {
            locals.push(("T", model.formulas().node(into)));
        }
        let power = match into {
            Some(_) => model.formulas().scalar(&entry.value.power, POWER, &locals, diagnostics),
            None => None,
        };
        let load = into.zip(power).map(|(into, power)| ElementKind::Load(Load { into, power }));
        model.add(entry, load);
    }
    for entry in &form.flows {
        let path = model.path(&entry.value.between, &entry.value.heat, HEAT, diagnostics);
        model.add(entry, path.map(|(between, heat)| ElementKind::Flow(Flow { between, heat })));
    }
    for entry in &form.coolers {
        let own = &entry.value;
        model.places.note("cooler", &entry.name, law::COUPLES, &own.couples.place);
        let scalars = [(law::COUPLE_RESISTANCE, &own.resistance), (law::COUPLE_CONDUCTANCE, &own.conductance)];
        let leads = own.lead_resistance.as_ref().map(|own| (law::LEADS, own));
        for (what, scalar) in scalars.into_iter().chain(leads) {
            model.places.note("cooler", &entry.name, what, scalar.place());
        }
        let cooler = model.cooler(entry, diagnostics);
        model.add(entry, cooler.map(ElementKind::Cooler));
    }
    for entry in &form.heaters {
        let heater = model.heater(entry, diagnostics);
        model.add(entry, heater.map(ElementKind::Heater));
    }
}

impl ResolvedModel {
    fn add<T>(&mut self, entry: &MapEntry<T>, kind: Option<ElementKind>) {
        if let Some(kind) = kind {
            self.model.elements.push(Element { name: entry.name.clone(), kind });
        }
    }

    /// Two nodes that differ, and the expression between them.
    fn path(
        &mut self,
        between: &[Spanned<String>; 2],
        scalar: &Scalar,
        expected: Expected,
        diagnostics: &mut Diagnostics,
    ) -> Option<([usize; 2], ExprId)> {
        let [a, b] = between;
        let first = self.find_node(&a.value, &a.place, diagnostics);
        let second = self.find_node(&b.value, &b.place, diagnostics);
        let ends = [first?, second?];
        if ends[0] == ends[1] {
            diagnostics.push(
                Diagnostic::error(&code::SELF_LOOP, &b.place, format!("both ends are the node `{}`", a.value))
                    .expected("two different nodes"),
            );
            return None;
        }
        let mut formulas = self.formulas();
        let locals = formulas.ends(ends);
        let id = formulas.scalar(scalar, expected, &locals, diagnostics)?;
        // A flow may be negative: it has a direction. A conductance or exchange area below 0 moves heat uphill.
        if expected.dimension != Dimension::POWER
            && let Some(value) = self.model.graph.constant(id).filter(|v| *v < 0.0)
        {
            refuse(
                scalar.place(),
                format!("{} of {value} {}", expected.what, expected.dimension),
                "0 or more",
                diagnostics,
            );
            return None;
        }
        Some((ends, id))
    }

    fn cooler(&mut self, entry: &MapEntry<CoolerForm>, diagnostics: &mut Diagnostics) -> Option<Cooler> {
        let form = &entry.value;
        let mut nodes: Vec<usize> = Vec::new();
        let written = std::iter::once(&form.cold).chain(&form.interstage).chain(std::iter::once(&form.hot));
        let mut valid = true;
        for name in written {
            let Some(node) = self.find_node(&name.value, &name.place, diagnostics) else {
                valid = false;
                continue;
            };
            if nodes.contains(&node) {
                let message = format!("the node `{}` stands twice in this cooler", name.value);
                diagnostics.push(
                    Diagnostic::error(&code::SELF_LOOP, &name.place, message)
                        .expected("different nodes from cold to hot"),
                );
                valid = false;
            }
            nodes.push(node);
        }
        let stages = 1 + form.interstage.len();
        let written = &form.couples.value.0;
        if written.len() != stages {
            let message = format!("{} of couples for {}", counted(written.len(), "number"), counted(stages, "stage"));
            diagnostics.push(
                Diagnostic::error(&code::WRONG_LENGTH, &form.couples.place, message)
                    .expected(format!("{stages}, from cold to hot: one more than nodes in `interstage`")),
            );
            valid = false;
        }
        if !valid {
            return None;
        }
        let mut formulas = self.formulas();
        let locals = formulas.ends([nodes[0], nodes[nodes.len() - 1]]);
        // Of a cooler only the mean temperature has a plain meaning for its materials.
        let seebeck = formulas.scalar(&form.seebeck, SEEBECK, &locals, diagnostics);
        let resistance = formulas.scalar(&form.resistance, RESISTANCE, &locals, diagnostics);
        let conductance = formulas.scalar(&form.conductance, CONDUCTANCE, &locals, diagnostics);
        let couples: Vec<Option<ExprId>> =
            written.iter().map(|c| formulas.scalar(c, COUPLES, &[], diagnostics)).collect();
        let lead_resistance = match &form.lead_resistance {
            Some(scalar) => formulas.scalar(scalar, RESISTANCE, &[], diagnostics),
            None => Some(formulas.graph.number(0.0)),
        };
        let drive = match (&form.voltage, &form.current) {
            (Some(voltage), None) => formulas.scalar(voltage, VOLTAGE, &locals, diagnostics).map(Drive::Voltage),
            (None, Some(current)) => formulas.scalar(current, CURRENT, &locals, diagnostics).map(Drive::Current),
            (both, _) => {
                let message = match both {
                    Some(_) => "a cooler has either `voltage` or `current`, and this one has both",
                    None => "a cooler has either `voltage` or `current`, and this one has neither",
                };
                let place = entry.name_place.clone();
                diagnostics.push(
                    Diagnostic::error(&code::ONE_KIND, &place, message).expected("exactly one of `voltage`, `current`"),
                );
                None
            }
        };
        for (scalar, id, what) in [
            (&form.resistance, resistance, "a couple's resistance"),
            (&form.conductance, conductance, "a couple's conductance"),
        ] {
            if let Some(value) = id.and_then(|id| self.model.graph.constant(id)).filter(|v| *v <= 0.0) {
                refuse(scalar.place(), format!("{what} of {value}"), "above 0", diagnostics);
            }
        }
        for (scalar, id) in written.iter().zip(&couples) {
            if let Some(value) = id.and_then(|id| self.model.graph.constant(id)).filter(|v| *v <= 0.0) {
                refuse(scalar.place(), format!("{value} couples"), "a number above 0", diagnostics);
            }
        }
        Some(Cooler {
            nodes,
            couples: couples.into_iter().collect::<Option<_>>()?,
            drive: drive?,
            seebeck: seebeck?,
            resistance: resistance?,
            conductance: conductance?,
            lead_resistance: lead_resistance?,
        })
    }

    fn heater(&mut self, entry: &MapEntry<HeaterForm>, diagnostics: &mut Diagnostics) -> Option<Heater> {
        let form = &entry.value;
        let into = self.find_node(&form.into.value, &form.into.place, diagnostics);
        let senses = match &form.senses {
            Some(name) => self.find_node(&name.value, &name.place, diagnostics),
            None => into,
        };
        let mut formulas = self.formulas();
        let locals: Vec<_> = into.map(|node| ("T", formulas.node(node))).into_iter().collect();
        let power = match into {
            Some(_) => formulas.scalar(&form.power, POWER, &locals, diagnostics),
            None => None,
        };
        let mut order = None;
        let control = match (&form.thermostat, &form.proportional) {
            (Some(thermostat), None) => {
                let on = formulas.scalar(&thermostat.on_below, SET_POINT, &[], diagnostics);
                let off = formulas.scalar(&thermostat.off_above, SET_POINT, &[], diagnostics);
                order = Some((on?, off?, thermostat.off_above.place()));
                Some(HeaterControl::Thermostat { on: on?, off: off? })
            }
            (None, Some(proportional)) => {
                let set_point = formulas.scalar(&proportional.set_point, SET_POINT, &[], diagnostics);
                let band = formulas.scalar(&proportional.band, BAND, &[], diagnostics);
                let zero = formulas.graph.number(0.0);
                order = Some((zero, band?, proportional.band.place()));
                Some(HeaterControl::Proportional { set_point: set_point?, band: band? })
            }
            (both, _) => {
                let message = match both {
                    Some(_) => "a heater has either `thermostat` or `proportional`, and this one has both",
                    None => "a heater has either `thermostat` or `proportional`, and this one has neither",
                };
                let mut diagnostic = Diagnostic::error(&code::ONE_KIND, &entry.name_place, message)
                    .expected("exactly one of `thermostat`, `proportional`");
                if both.is_none() {
                    diagnostic = diagnostic.help("a heater without control is one of the `loads`");
                }
                diagnostics.push(diagnostic);
                None
            }
        };
        let values =
            order.map(|(low, high, place)| (self.model.graph.constant(low), self.model.graph.constant(high), place));
        if let Some((Some(low), Some(high), place)) = values
            && low >= high
        {
            let (message, expected) = match form.thermostat {
                Some(_) => (
                    format!("the heater switches off above {high} K and on below {low} K"),
                    "`off_above` above `on_below`",
                ),
                None => (format!("a band of {high} K"), "a width above 0"),
            };
            refuse(place, message, expected, diagnostics);
            return None;
        }
        Some(Heater { into: into?, senses: senses?, power: power?, control: control? })
    }
}
