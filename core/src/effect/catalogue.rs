//! The catalogue: effects that come with the program, and a study's own.
//!
//! To add an effect to the program: a file in `core/src/effect/catalogue` and a line in the list below.

use crate::document::{Diagnostic, Diagnostics, Node, Schemas, code, read_file};

use super::checked::Effect;
use super::form::{EffectForm, FORMAT};

/// Effects that come with the program, in the order in which they are shown.
const EMBEDDED: &[(&str, &str)] = &[
    ("conductive-path", include_str!("catalogue/conductive-path.json")),
    ("radiative-path", include_str!("catalogue/radiative-path.json")),
    ("gas-conduction", include_str!("catalogue/gas-conduction.json")),
    ("convection", include_str!("catalogue/convection.json")),
    ("path-to-ambient", include_str!("catalogue/path-to-ambient.json")),
    ("path-to-logged-temperature", include_str!("catalogue/path-to-logged-temperature.json")),
    ("radiation-to-ambient", include_str!("catalogue/radiation-to-ambient.json")),
    ("free-convection", include_str!("catalogue/free-convection.json")),
    ("heat-load", include_str!("catalogue/heat-load.json")),
    ("input-proportional-load", include_str!("catalogue/input-proportional-load.json")),
    ("joule-heating", include_str!("catalogue/joule-heating.json")),
    ("product-load", include_str!("catalogue/product-load.json")),
    ("input-function-load", include_str!("catalogue/input-function-load.json")),
    ("product-function-load", include_str!("catalogue/product-function-load.json")),
    ("periodic-load", include_str!("catalogue/periodic-load.json")),
    ("daily-load", include_str!("catalogue/daily-load.json")),
    ("daily-hours-load", include_str!("catalogue/daily-hours-load.json")),
    ("dated-load", include_str!("catalogue/dated-load.json")),
    ("event-load", include_str!("catalogue/event-load.json")),
    ("evaporation", include_str!("catalogue/evaporation.json")),
    ("input-dependent-load", include_str!("catalogue/input-dependent-load.json")),
    ("dissipation-temperature", include_str!("catalogue/dissipation-temperature.json")),
    ("temperature-dependent-conductance", include_str!("catalogue/temperature-dependent-conductance.json")),
    ("temperature-dependent-emittance", include_str!("catalogue/temperature-dependent-emittance.json")),
    ("mli-effective-emittance", include_str!("catalogue/mli-effective-emittance.json")),
    ("input-dependent-conductance", include_str!("catalogue/input-dependent-conductance.json")),
    ("conductance-step", include_str!("catalogue/conductance-step.json")),
    ("conductance-lost-below", include_str!("catalogue/conductance-lost-below.json")),
    ("dated-conductance", include_str!("catalogue/dated-conductance.json")),
    ("event-conductance", include_str!("catalogue/event-conductance.json")),
    ("absorptance-drift", include_str!("catalogue/absorptance-drift.json")),
    ("heater-capacity", include_str!("catalogue/heater-capacity.json")),
    ("heater-efficiency", include_str!("catalogue/heater-efficiency.json")),
    ("missing-heater", include_str!("catalogue/missing-heater.json")),
    ("cooler-degradation", include_str!("catalogue/cooler-degradation.json")),
    ("cooler-contact", include_str!("catalogue/cooler-contact.json")),
    ("sink-offset", include_str!("catalogue/sink-offset.json")),
    ("sink-drift", include_str!("catalogue/sink-drift.json")),
    ("thermal-mass", include_str!("catalogue/thermal-mass.json")),
    ("latent-heat", include_str!("catalogue/latent-heat.json")),
    ("hidden-node", include_str!("catalogue/hidden-node.json")),
    ("path-capacity", include_str!("catalogue/path-capacity.json")),
    ("sensor-bias", include_str!("catalogue/sensor-bias.json")),
    ("sensor-gain", include_str!("catalogue/sensor-gain.json")),
    ("sensor-lag", include_str!("catalogue/sensor-lag.json")),
    ("sensor-clock", include_str!("catalogue/sensor-clock.json")),
    ("sensor-drift", include_str!("catalogue/sensor-drift.json")),
    ("dated-bias", include_str!("catalogue/dated-bias.json")),
    ("sensor-conduction", include_str!("catalogue/sensor-conduction.json")),
    ("sensor-self-heating", include_str!("catalogue/sensor-self-heating.json")),
    ("sensor-gradient", include_str!("catalogue/sensor-gradient.json")),
    ("swapped-channels", include_str!("catalogue/swapped-channels.json")),
];

/// Effects by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Catalogue {
    effects: Vec<Effect>,
}

impl Catalogue {
    /// The effects that come with the program; what is wrong with one goes to `diagnostics`.
    pub fn embedded(diagnostics: &mut Diagnostics) -> Self {
        let mut catalogue = Self::default();
        for (name, text) in EMBEDDED {
            catalogue.read(name, &format!("{name}.json"), text.as_bytes(), diagnostics);
        }
        catalogue.effects.iter_mut().for_each(|effect| effect.embedded = true);
        catalogue
    }

    /// Reads a file and adds its effect under a name, in place of one of that name. The tree that was read comes back.
    pub fn read(&mut self, name: &str, shown: &str, bytes: &[u8], diagnostics: &mut Diagnostics) -> Option<Node> {
        let (form, node) = read_file::<EffectForm>(shown, bytes, FORMAT, diagnostics)?;
        let effect = Effect::new(name, form, node.to_json(), diagnostics)?;
        match self.effects.iter_mut().find(|other| other.name == name) {
            Some(other) => *other = effect,
            None => self.effects.push(effect),
        }
        Some(node)
    }

    /// Checks that effects named by others exist.
    pub fn check(&self, diagnostics: &mut Diagnostics) {
        for effect in &self.effects {
            for other in effect.form.confused_with.iter().filter(|other| self.get(&other.value).is_none()) {
                let near = diagnostics.nearest(&other.value, self.names());
                diagnostics.push(
                    Diagnostic::error(
                        &code::UNKNOWN_EFFECT,
                        &other.place,
                        format!("there is no effect `{}`", other.value),
                    )
                    .expected("the name of an effect")
                    .suggest(near),
                );
            }
        }
    }

    /// An effect by name.
    pub fn get(&self, name: &str) -> Option<&Effect> {
        self.effects.iter().find(|effect| effect.name == name)
    }

    /// Effects in order.
    pub fn effects(&self) -> &[Effect] {
        &self.effects
    }

    /// Names in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.effects.iter().map(|effect| effect.name.as_str())
    }
}

/// The JSON Schema of effect files.
pub fn schema() -> serde_json::Value {
    Schemas::document::<EffectForm>("bmv effect (bmv-effect/1)")
}
