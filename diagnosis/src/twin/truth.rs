//! What is true in a case of the laboratory.

use serde::{Deserialize, Serialize};

/// An effect of the catalogue that is hidden in a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HiddenEffect {
    /// Its candidate's id.
    pub id: String,
    /// The effect.
    pub effect: String,
    /// Names of its place.
    #[serde(rename = "where")]
    pub place: Vec<String>,
    /// What its inputs stand for.
    pub input: Option<String>,
    /// Its parameters.
    pub parameters: Vec<HiddenValue>,
    /// What would be left, in standard deviations of the noise, were it alone missing; 0 where it was not asked.
    pub alone: f64,
}

/// A parameter of a hidden effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HiddenValue {
    /// Its name in the effect.
    pub name: String,
    /// Its value, in its unit.
    pub value: f64,
    /// Its unit, SI.
    pub unit: String,
    /// Whether it is an amplitude.
    pub amplitude: bool,
}

/// Physics of a case that no effect of the catalogue is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outside {
    /// Heat that follows the root of an input: `a sqrt((x - lower) / (upper - lower))`.
    Root {
        /// The node.
        node: String,
        /// The input.
        input: String,
    },
    /// Heat that swings with a period of its own: `a sin(2 pi t / period + phase)`.
    Swing {
        /// The node.
        node: String,
        /// The period, s.
        period_s: f64,
    },
    /// Heat that somebody switches on and off without a note.
    Unlogged {
        /// The node.
        node: String,
    },
}

impl Outside {
    /// Ids of candidates that stand for it although they have no name for it: a curve over the right input.
    pub fn stands_for(&self) -> Vec<String> {
        match self {
            Self::Root { node, input } => vec![format!("input-function-load:{node}:{input}")],
            Self::Swing { .. } | Self::Unlogged { .. } => Vec::new(),
        }
    }
}

/// The noise of a case.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NoiseTruth {
    /// As the sensors state it.
    #[serde(alias = "as-told")]
    AsStated,
    /// Ornstein-Uhlenbeck and white noise, together of the stated standard deviation: a correlation that is not stated.
    Correlated {
        /// The correlation time, s.
        correlation_time_s: f64,
        /// Share of the variance that is correlated.
        share: f64,
    },
}

/// A set of effects that may be taken for the truth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rival {
    /// Ids of its effects; none for the baseline model.
    pub effects: Vec<String>,
    /// Cosine between what the truth and what the rival do to the whitened readings beyond the model's own parameters.
    pub cosine: f64,
    /// Smallest squared distance of its refitted predictions from the true ones, in standard deviations of the noise.
    pub delta2: f64,
}

/// What is true in a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Effects of the catalogue.
    pub effects: Vec<HiddenEffect>,
    /// Physics that the catalogue lacks.
    pub outside: Option<Outside>,
    /// Size of what a network with finer nodes leaves by itself, in standard deviations.
    pub finer: Option<f64>,
    /// The model's parameters, SI.
    pub parameters: Vec<(String, f64)>,
    /// The noise.
    pub noise: NoiseTruth,
    /// Root mean square, in standard deviations of the noise, of what the baseline model leaves of noise-free readings
    /// when it is refitted to them.
    pub size: f64,
    /// The size that was asked for; `None` where the amplitude was.
    pub asked: Option<f64>,
    /// The nearest rivals, nearest first, where they were looked for.
    pub rivals: Option<Vec<Rival>>,
}

/// Rivals nearer than this, in squared standard deviations, cannot be told from the truth.
pub const SEPARABLE_DELTA2: f64 = 9.0;

impl Truth {
    /// Whether anything is missing from the baseline model.
    pub fn is_null(&self) -> bool {
        self.effects.is_empty() && self.outside.is_none() && self.finer.is_none()
    }

    /// Ids of the hidden effects.
    pub fn ids(&self) -> Vec<&str> {
        self.effects.iter().map(|effect| effect.id.as_str()).collect()
    }

    /// Whether no rival explains the truth; `None` where rivals were not looked for.
    pub fn is_separable(&self) -> Option<bool> {
        self.rivals.as_ref().map(|rivals| rivals.iter().all(|rival| rival.delta2 >= SEPARABLE_DELTA2))
    }
}
