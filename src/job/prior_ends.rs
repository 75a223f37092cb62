//! The ends of a prior, for what takes it as a range.

use crate::random::Distribution;

/// Share of a prior without bounds that lies beyond each of its ends: 3 sigma of a normal.
const BEYOND: f64 = 1.349_898_031_630_094_6e-3;

/// The ends of a prior that a worst case or a correlation looks at: its bounds where it has them, else 3 sigma.
pub fn ends(prior: &Distribution) -> [f64; 2] {
    let (lower, upper) = prior.support();
    let open_below = match prior {
        Distribution::LogNormal { .. } => true,
        Distribution::Normal { lower, .. } => lower.is_none(),
        _ => false,
    };
    [
        if open_below { prior.quantile(BEYOND) } else { lower },
        if upper.is_finite() { upper } else { prior.quantile(1.0 - BEYOND) },
    ]
}
