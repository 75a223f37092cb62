//! xija's solvers, and what they do to the rates.

use serde_json::Value;

use crate::deck::Note;

/// How xija advances the temperatures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// `evolve_method` 1 (`core_1.c`). For a pair of steps that covers the time `h`, with the rate `f0` at its start and
    /// `f1` at the point `h f0 / 2` further, the temperature grows by `h f0 / 2 + h f1`: one and a half times `h` times
    /// the rate.
    Pairs,
    /// `evolve_method` 2 (`core_2.c`): an ordinary Runge-Kutta rule of order 2 or 4.
    Ordinary,
}

impl Method {
    /// The method of a specification; absent, `null` and 0 are 1.
    ///
    /// # Errors
    /// Another number: xija then computes nothing.
    pub fn read(document: &Value) -> Result<Self, String> {
        match document.get("evolve_method").filter(|value| !value.is_null()).map(Value::as_u64) {
            None | Some(Some(0 | 1)) => Ok(Self::Pairs),
            Some(Some(2)) => Ok(Self::Ordinary),
            Some(_) => Err("`evolve_method` must be 1 or 2, or absent (1)".to_owned()),
        }
    }

    /// By what all rates of the equations are multiplied.
    pub fn rate_factor(self) -> f64 {
        match self {
            Self::Pairs => 1.5,
            Self::Ordinary => 1.0,
        }
    }

    /// What an engineer should know.
    pub fn note(self, capacity_j_per_k: f64) -> Note {
        let message = match self {
            Self::Pairs => format!(
                "evolve_method is 1 or absent: this solver of xija advances each pair of steps by 1.5 times the time that \
                 it covers, so the nodes here have {capacity_j_per_k:.1} J/K (1000 / 1.5), and a fitted time constant tau \
                 of this file acts as tau / 1.5 and a fitted heat P warms as 1.5 P would; steady temperatures are unaffected"
            ),
            Self::Ordinary => format!(
                "evolve_method is 2, an ordinary Runge-Kutta rule: the nodes have {capacity_j_per_k:.0} J/K and fitted \
                 time constants act as they stand"
            ),
        };
        Note::new(message)
    }

    /// About how wrong xija's own transient of a node is at `rate_per_s` (of the equations): the relative error of that
    /// rate. From the expansion of one step: of the pair's `(1.5 h)^2 / 2 = 1.125 h^2` the rule has `0.5 h^2`, so that
    /// `0.625 h^2` are missing on `1.5 h`; the ordinary rule of order 2 misses `h^3 / 6` on `h`.
    pub fn relative_error(self, rate_per_s: f64, step_s: f64) -> f64 {
        match self {
            Self::Pairs => 0.625 / 1.5 * 2.0 * step_s * rate_per_s,
            Self::Ordinary => (step_s * rate_per_s) * (step_s * rate_per_s) / 6.0,
        }
    }
}
