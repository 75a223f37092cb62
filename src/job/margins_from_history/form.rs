//! Settings of `margins-from-history` as written.

use crate::document::{Spanned, written_struct};

written_struct! {
    /// Settings of `margins-from-history`.
    pub struct HistoryForm: "settings of `margins-from-history`" {
        /// CSV with a row a comparison: `predicted` and `measured`, temperatures; `class`, by which rows are judged apart, and
        /// `program`, whose rows are not independent, where they are known.
        required file: Spanned<String>,
        /// The character between cells, a comma where it is left out.
        optional separator: Spanned<String>,
        /// Share of the differences that a margin must hold, 0.95 where it is left out.
        optional capture: Spanned<f64>,
        /// Confidence with which its bound does, 0.95 where it is left out.
        optional confidence: Spanned<f64>,
        /// Margin rules by name that are held against the history; all margins of temperature where they are left out.
        optional rules: Vec<Spanned<String>>,
    }
}
