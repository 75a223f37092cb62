//! Settings of `calibrate` as written.

use super::Sampler;
use crate::document::{Spanned, written_struct};

written_struct! {
    /// Settings of `calibrate`.
    pub struct CalibrateForm: "settings of `calibrate`" {
        /// Measurements; all of the pass where they are left out.
        optional data: Vec<Spanned<String>>,
        /// Parameters; all whose prior is not fixed where they are left out.
        optional parameters: Vec<Spanned<String>>,
        /// How the posterior is sampled. Where it is left out: `adaptive-metropolis` for a model without derivatives;
        /// `independence-metropolis` for transients of 200 rows or more, unless an `acceptance` is stated; `nuts` for all others.
        optional sampler: Sampler,
        /// Number of chains (of islands for `smc`), 4 where it is left out.
        optional chains: Spanned<u64>,
        /// Steps of a chain that adapt and are dropped: 500 for `nuts`, 5000 for `adaptive-metropolis`, 100 for
        /// `independence-metropolis`.
        optional warmup: Spanned<u64>,
        /// Draws of a chain that are kept: 1000, 5000 for `adaptive-metropolis`, 2000 for `independence-metropolis`.
        optional draws: Spanned<u64>,
        /// Mean acceptance that the steps of `nuts` are adapted to, 0.8 where it is left out; 0.95 takes shorter steps, for
        /// posteriors in which trajectories diverge.
        optional acceptance: Spanned<f64>,
    }
}
