//! What would have been seen: the amplitude of a direction that the family's test finds with a given power.
//!
//! A direction is found where its statistic exceeds the critical value `c` of the family, which is that of a member's own
//! probability ([`Family::critical`](crate::diagnosis::screening::family::Family::critical)). The score of the amplitude `a` is normal about
//! `a |g~|` with standard deviation 1, so that `a = (c + 1.2816) / |g~|` is found nine times in ten (for two-sided tests the
//! far tail is left out: it adds less than 1e-6). Bounds of parameters that come into play lower the power.

use crate::diagnosis::Direction;
use crate::diagnosis::screening::multi_column::Projected;
use crate::diagnosis::screening::score::Prepared;
use crate::inference::null_maximum::Side;
use crate::math::special::{normal_quantile, student_t_quantile};

/// The amplitude, SI, of a direction of one column that is found with a power (0.9, say) at a member's critical
/// probability. `None` where no plausible one is seen, and for several columns.
pub fn detectable(
    prepared: &Prepared,
    direction: &Direction,
    critical_p: f64,
    power: f64,
    degrees: Option<f64>,
) -> Option<f64> {
    let Projected::Single { norm, side, .. } = prepared.projected(direction) else { return None };
    let p = if side == Side::Two { 0.5 * critical_p } else { critical_p };
    let c = match degrees {
        None => -normal_quantile(p),
        Some(d) => -student_t_quantile(p, d),
    };
    Some((c + normal_quantile(power)) / norm)
}
