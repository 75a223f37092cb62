//! Settings of `test-plan` as written.

use crate::document::{Amount, Map, Spanned, written_struct};

written_struct! {
    /// Settings of `test-plan`.
    pub struct TestPlanForm: "settings of `test-plan`" {
        /// The `design` job of this pass whose choice is planned; the pass's only one where it is left out.
        optional from: Spanned<String>,
        /// What the test is for, a sentence each, beside what the design was asked to learn.
        optional objectives: Vec<Spanned<String>>,
        /// When it has succeeded, a sentence each, beside steady phases, kept red limits and complete readings.
        optional success: Vec<Spanned<String>>,
        /// Criteria profile whose `stabilisation` decides when a phase is steady, `smc-3k` where it is left out.
        optional criteria: Spanned<String>,
        /// Time for readings once a phase is steady, 1 h where it is left out.
        optional hold: Amount,
        /// Longest time that a phase may need to become steady, 72 h where it is left out.
        optional longest: Amount,
        /// Inputs before the first phase, in which the article is steady; those not named are as in the phases, and where the
        /// phases differ in one, at its nominal value. Bare numbers are SI.
        default(Map::default()) start: Map<Amount>,
        /// Samples of the priors behind bands and probabilities, 1024 where it is left out; a power of two.
        optional samples: Spanned<u64>,
        /// Samples of the priors whose transients are integrated, 32 where it is left out.
        optional transients: Spanned<u64>,
    }
}
