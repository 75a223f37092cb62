//! An effect as written: `bmv-effect/1`.

use crate::document::{
    Amount, Empty, EvidenceForm, Map, OneOrMany, PriorForm, Spanned, WrittenUnit, written_struct, written_words,
};

/// The format's name in the file.
pub const FORMAT: &str = "bmv-effect/1";

written_struct! {
    /// A physical effect that a thermal model may lack.
    pub struct EffectForm: "an effect" {
        /// `bmv-effect/1`.
        required format: String,
        /// Title, for people.
        required title: String,
        /// Title where it acts on all thermometers of a test at once, which may mean something else.
        optional title_of_all_thermometers: String,
        /// Heading under which `bmv effects` lists it.
        default(Family::Other) family: Family,
        /// Its name, as `bmv effects NAME --json` prints it; the name of the file is what counts.
        optional name: String,
        /// What it may act on: one or several kinds of place.
        required applies: Spanned<AppliesForm>,
        /// What it needs of the model beside its place; each is bound to an input of the model, or to a node where
        /// temperatures are allowed.
        default(Map::default()) inputs: Map<EffectInputForm>,
        /// Its parameters. Without effect while all amplitudes are 0.
        default(Map::default()) parameters: Map<ParameterForm>,
        /// What it adds to the model.
        required adds: Spanned<AddsForm>,
        /// What must surround the hardware.
        optional medium: Medium,
        /// Whether it needs what few articles have, such as a wet surface.
        default(false) rare: bool,
        /// Whether a gradient within a node, which a lumped node has none of, reads the same.
        default(false) like_gradient: bool,
        /// Data that can see it.
        default(vec![SeenBy::Steady, SeenBy::Transient]) seen_by: Vec<SeenBy>,
        /// The equation, for people.
        optional equation: String,
        /// What it is, at length.
        optional description: String,
        /// What it looks like in the residuals.
        optional signature: String,
        /// Names of effects that it is easily mistaken for.
        default(Vec::new()) confused_with: Vec<Spanned<String>>,
        /// Test that tells it from those.
        optional separate: String,
        /// Where equation and ranges come from.
        required source: String,
        /// How far the source was itself read.
        optional evidence: EvidenceForm,
    }
}

written_words! {
    /// A heading of the catalogue.
    pub enum Family: "a family of effects" {
        /// Paths between nodes.
        "paths" => Paths,
        /// Paths to surroundings that the model lacks.
        "surroundings" => Surroundings,
        /// Heat into nodes.
        "loads" => Loads,
        /// Properties that vary.
        "properties" => Properties,
        /// Heaters, coolers and environments.
        "equipment" => Equipment,
        /// Storage of heat.
        "storage" => Storage,
        /// Sensors.
        "sensors" => Sensors,
        /// Others, such as a study's own.
        "other" => Other,
    }
}

written_words! {
    /// What surrounds the hardware.
    pub enum Medium: "a medium" {
        /// Air or another gas, near the pressure of the atmosphere.
        "gas" => Gas,
    }
}

written_struct! {
    /// Kinds of place, each `{}`.
    pub struct AppliesForm: "an object of kinds of place, such as {\"pair\": {}}" {
        /// Two nodes, unordered.
        optional pair: Empty,
        /// A node that is no boundary.
        optional node: Empty,
        /// A boundary node.
        optional boundary: Empty,
        /// A conductor.
        optional conductor: Empty,
        /// A radiation.
        optional radiation: Empty,
        /// A load.
        optional load: Empty,
        /// The heat capacity of a node that has one.
        optional capacity: Empty,
        /// A controlled heater.
        optional heater: Empty,
        /// A thermoelectric cooler.
        optional cooler: Empty,
        /// A sensor.
        optional sensor: Empty,
        /// Two sensors.
        optional sensor_pair: Empty,
        /// A group of the model whose members are of one of the other kinds.
        optional group: Empty,
    }
}

written_struct! {
    /// Something of the model that an effect needs.
    pub struct EffectInputForm: "an input of an effect" {
        /// Units of which one must fit; any unit where it is left out.
        optional unit: OneOrMany<WrittenUnit>,
        /// Whether a node may be bound, for its temperature.
        default(false) temperature: bool,
        /// Whether an input of the model may be bound.
        default(true) input: bool,
        /// Whether an input may be bound that is the temperature of a boundary.
        default(true) boundary: bool,
        /// Whether it says when: the number of a steady phase from 1 on, or what to add to `t` in a transient. It is bound by itself.
        default(false) date: bool,
        /// Whether it is the time since the start of the run, s, once `t` is added to it. It is bound by itself, in passes of
        /// several transients of like length.
        default(false) elapsed: bool,
        /// Of these two: the effect is tried where the measured time spans at least this many seconds.
        optional least_span: f64,
        /// Of these two: the effect is tried where the rows of transients are, by their median, at most this many seconds apart.
        optional most_apart: f64,
        /// What it is.
        optional description: String,
    }
}

written_struct! {
    /// A parameter of an effect.
    pub struct ParameterForm: "a parameter of an effect" {
        /// Its unit, in which bare numbers of this entry are. With `per`: the unit of its product with the inputs'
        /// largest values, so that the numbers say how much it is at those.
        optional unit: WrittenUnit,
        /// Inputs of the effect by which the unit is divided, once for each time named.
        default(Vec::new()) per: Vec<Spanned<String>>,
        /// Instead of `unit`: an input of the effect whose unit it has, or `T`: a level of the node's own temperature, of each
        /// member's in a group.
        optional unit_of: Spanned<String>,
        /// Prior. With `unit_of` there is none: uniform over the input's range, or from 200 to 400 K.
        optional prior: PriorForm,
        /// Nominal value; the prior's median where it is left out.
        optional nominal: Amount,
        /// Which signs are physical.
        default(Sign::Either) sign: Sign,
        /// Values at which an effect that is not smooth at 0 is tried.
        default(Vec::new()) probes: Vec<Amount>,
        /// Scale of plausible amplitudes, for comparing models.
        optional plausible: Amount,
        /// Whether it only shapes the effect; else it is an amplitude.
        default(false) shape: bool,
        /// What it is.
        optional description: String,
    }
}

written_words! {
    /// Which signs are physical.
    pub enum Sign: "a sign" {
        /// 0 or more.
        "positive" => Positive,
        /// 0 or less.
        "negative" => Negative,
        /// Both.
        "either" => Either,
    }
}

written_words! {
    /// A kind of data.
    pub enum SeenBy: "a kind of data" {
        /// Steady phases.
        "steady" => Steady,
        /// Transients.
        "transient" => Transient,
    }
}

written_struct! {
    /// What an effect adds. Expressions know the effect's parameters and inputs, `X_lower` and `X_upper` (the range of
    /// an input `X`), `t`, and the temperatures of the place.
    pub struct AddsForm: "an object of additions, such as {\"flow\": \"...\"}" {
        /// Heat, W, from the first node (`Ta`) to the second (`Tb`); with `ambient` from the node to it.
        optional flow: Spanned<String>,
        /// Heat into the node, W (`T`). In a group it is multiplied by the member's weight.
        optional load: Spanned<String>,
        /// Factor of a conductance, exchange area (`Ta`, `Tb`, `Tm`), power or capacity (`T`).
        optional factor: Spanned<String>,
        /// Heat capacity added to the node, J/K (`T`).
        optional capacity: Spanned<String>,
        /// A hidden node with its own capacity and path.
        optional node: HiddenNodeForm,
        /// A node with its own capacity inside a conductor.
        optional within: WithinForm,
        /// A node with its own capacity between a load or heater and its node: the heat arrives late.
        optional source: SourceNodeForm,
        /// A boundary that the model lacks, at the other end of `flow`.
        optional ambient: AmbientForm,
        /// Added to a boundary's temperature, K.
        optional offset: Spanned<String>,
        /// Factors of a cooler's properties.
        optional cooler: CoolerFactorsForm,
        /// Resistance between a cooler's hot side and its node, K/W.
        optional contact: Spanned<String>,
        /// Heat into the node that follows an unknown function.
        optional curve: CurveForm,
        /// What the sensor reads: an expression of the true value `T`, its `rate` (K/s, of a node's temperature),
        /// `zero` (273.15 for temperatures, else 0) and `t`.
        optional reading: Spanned<String>,
        /// Time constant with which the sensor follows, s.
        optional lag: Spanned<String>,
        /// Time by which the sensor's clock is behind, s: its row of a time shows what happens this much later.
        optional clock: Spanned<String>,
        /// The two sensors' channels are exchanged.
        optional swap: Empty,
    }
}

written_struct! {
    /// A hidden node: on one node it hangs on a path of this conductance; between two nodes it stands in the middle of
    /// one, in series.
    pub struct HiddenNodeForm: "a hidden node" {
        /// Its capacity, J/K (`T` its own temperature).
        required capacity: Spanned<String>,
        /// Conductance of its path, W/K.
        required conductance: Spanned<String>,
    }
}

written_struct! {
    /// A node that a load or heater heats in place of its own, with a path to that.
    pub struct SourceNodeForm: "a node behind a load" {
        /// Its capacity, J/K.
        required capacity: Spanned<String>,
        /// Conductance of its path, W/K, above 0.
        required conductance: Spanned<String>,
    }
}

written_struct! {
    /// A node inside a conductor.
    pub struct WithinForm: "a node inside a conductor" {
        /// Its capacity, J/K.
        required capacity: Spanned<String>,
        /// Share of the resistance between the first end and it, above 0 and below 1.
        required share: Spanned<String>,
    }
}

written_struct! {
    /// A boundary that the model lacks.
    pub struct AmbientForm: "a boundary" {
        /// Its temperature, K.
        required temperature: Spanned<String>,
    }
}

written_struct! {
    /// Factors of a cooler's properties; 1 where left out.
    pub struct CoolerFactorsForm: "factors of a cooler" {
        /// Of the Seebeck coefficient.
        optional seebeck: Spanned<String>,
        /// Of the resistance.
        optional resistance: Spanned<String>,
        /// Of the conductance.
        optional conductance: Spanned<String>,
    }
}

written_struct! {
    /// A piecewise linear function of an input over its range, its values at equally spaced knots being parameters
    /// `knot_1`, `knot_2`, ...; held constant beyond. The effect has one parameter `knot`, which describes all.
    pub struct CurveForm: "a curve" {
        /// The input whose function it is; a node's temperature is taken from 200 to 400 K.
        required of: Spanned<String>,
        /// An input that multiplies the function.
        optional times: Spanned<String>,
        /// Number of knots, 2 to 20.
        required knots: Spanned<usize>,
    }
}
