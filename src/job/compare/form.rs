//! Settings of `compare` as written.

use crate::document::{Spanned, written_struct};

written_struct! {
    /// Settings of `compare`.
    pub struct CompareForm: "settings of `compare`" {
        /// Measurements; all of the pass where they are left out.
        optional data: Vec<Spanned<String>>,
        /// Criteria profile, `smc-3k` where it is left out.
        optional criteria: Spanned<String>,
        /// The `calibrate` job whose tuned state stands beside the delivered one; `nominal` for none. The first of the
        /// pass on the same data where it is left out.
        optional from: Spanned<String>,
    }
}
