//! Samplers of the posterior, a file each. One more is a file here and a line in the list below.

use serde::{Deserialize, Serialize};

use super::Calibrate;
use super::block::Partial;
use crate::document::declare::word;
use crate::document::schema::words;
use crate::document::{Diagnostics, Node, Schemas, Written, suggest};
use crate::inference::estimate::informed::Informed;
use crate::inference::estimate::point_estimate::PointEstimate;
use crate::inference::likelihood::Likelihood;
use crate::inference::sampler::chains::{Chain, SampleError};
use crate::inference::sampler::parts::Parts;
use crate::job::stored::Block;
use crate::job::{self, JobError};
use crate::measurement::{Measurement, Rows};

/// A way to sample the posterior.
pub(super) trait Method: Sync {
    /// The name in files.
    fn name(&self) -> &'static str;
    /// What it is, for the schema of a pass.
    fn about(&self) -> &'static str;
    /// Steps that adapt and are dropped, and draws of a chain, where nothing is said.
    fn defaults(&self) -> (u64, u64);
    /// Fewest draws of a chain.
    fn least_draws(&self) -> u64 {
        4
    }
    /// Whether some of its first steps are dropped.
    fn has_warm_up(&self) -> bool {
        true
    }
    /// Whether it aims at an acceptance that can be chosen.
    fn has_acceptance(&self) -> bool {
        false
    }
    /// Whether it moves islands of particles from the prior on, whose weights tell the evidence, in place of chains from
    /// the most probable points.
    fn has_islands(&self) -> bool {
        false
    }
    /// Runs a chain from its start, or an island, which has none.
    ///
    /// # Errors
    /// A start or settings of which no chain comes.
    fn run(&self, run: &Run<'_>) -> Result<Partial, JobError>;
}

/// A chain or an island that is to run.
pub(super) struct Run<'a> {
    /// The calibration with its settings.
    pub calibration: &'a Calibrate,
    /// The posterior.
    pub target: &'a Informed<Likelihood>,
    /// The most probable point.
    pub estimate: &'a PointEstimate,
    /// Number of the chain or the island.
    pub index: u64,
    /// Where a chain starts, SI.
    pub start: Option<&'a [f64]>,
    /// Where its states are kept.
    pub parts: &'a dyn job::Parts,
}

impl Run<'_> {
    /// Runs a chain of so many transitions that keeps its state every so many, from the last one that is there.
    fn in_parts<S: Block>(
        &self,
        transitions: u64,
        every: u64,
        run: impl FnOnce(&mut Parts<'_, S>) -> Result<Chain, SampleError>,
    ) -> Result<Partial, JobError> {
        let kept = self.parts;
        let read = |part: u64| S::from_bytes(&kept.find(part)?, "chain").ok();
        let from = (1..transitions.div_ceil(every)).rev().find_map(read);
        let mut failure = None;
        let mut keep = |part: u64, state: S| match state.into_bytes() {
            Ok(bytes) => kept.keep(part, &bytes),
            Err(error) => failure = Some(error),
        };
        let chain = run(&mut Parts { from, every, is_due: &|| kept.is_due(), keep: &mut keep });
        match failure {
            Some(error) => Err(error),
            None => chain.map(Partial::Chain).map_err(|error| JobError::Failed(error.to_string())),
        }
    }
}

/// Declares the samplers: a module each, a variant, an entry of the list.
macro_rules! samplers {
    ($( $variant:ident in $module:ident ),* $(,)?) => {
        $( mod $module; )*

        /// How the posterior is sampled.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum Sampler {
            $( #[doc = concat!("See `", stringify!($module), ".rs`.")] $variant ),*
        }

        impl Sampler {
            /// All samplers.
            pub const ALL: &[Self] = &[$( Self::$variant ),*];

            pub(super) fn method(self) -> &'static dyn Method {
                match self { $( Self::$variant => &$module::$variant ),* }
            }
        }
    };
}

samplers! {
    Nuts in nuts,
    AdaptiveMetropolis in adaptive_metropolis,
    IndependenceMetropolis in independence_metropolis,
    Smc in smc,
}

impl Sampler {
    /// The name in files.
    pub fn name(self) -> &'static str {
        self.method().name()
    }

    /// Steps that adapt and are dropped, and draws of a chain, where nothing is said.
    pub fn defaults(self) -> (u64, u64) {
        self.method().defaults()
    }

    fn names() -> Vec<&'static str> {
        Self::ALL.iter().map(|sampler| sampler.name()).collect()
    }
}

/// Rows of transients from which one likelihood a draw is spent: trajectories take several gradients of all rows for each, and
/// the posterior of so many rows is nearly normal.
const LONG_RECORD: usize = 200;

/// Whether the transients among measurements have so many rows that `independence-metropolis` samples where nothing is said.
pub fn is_long<'a>(measurements: impl Iterator<Item = &'a Measurement>) -> bool {
    let transients = measurements.filter(|own| matches!(own.rows, Rows::Transient { .. }));
    transients.map(Measurement::len).sum::<usize>() >= LONG_RECORD
}

/// What a name in a file stands for, in messages.
const WHAT: &str = "a sampler";

impl Written for Sampler {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        let name = word(node, &Self::names(), WHAT, diagnostics)?;
        Self::ALL.iter().copied().find(|sampler| sampler.name() == name)
    }

    fn schema(schemas: &mut Schemas) -> serde_json::Value {
        schemas.define("SamplerForm", |_| {
            let all: Vec<_> = Self::ALL.iter().map(|sampler| (sampler.name(), sampler.method().about())).collect();
            words("How a posterior is sampled.", &all)
        })
    }

    fn expected() -> String {
        format!("{WHAT}: {}", suggest::listed(Self::names().into_iter(), 20))
    }
}
