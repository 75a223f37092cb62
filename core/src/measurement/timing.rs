//! When a sensor shows what happens: it may follow slowly (`lag`), and its clock may be off.
//!
//! A clock that is behind by `b` stamps its rows too early: the row of time `t` shows the truth at `t + b`. The truth is straight
//! between rows, as a lag has it, and stays as it is before the first row and after the last.

use super::lag;

/// How the readings of a sensor follow the truth in time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timing {
    /// Its time constant, s; 0: none.
    pub lag_s: f64,
    /// Time by which its clock is behind, s; below 0: ahead.
    pub behind_s: f64,
}

/// Derivatives of readings, SI unit of the reading a second.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TimingSlopes {
    /// By the time constant, by row.
    pub by_lag: Vec<f64>,
    /// By the time by which the clock is behind, by row.
    pub by_behind: Vec<f64>,
}

impl Timing {
    /// Readings for the truth at instants `times_s`.
    pub fn reading(&self, times_s: &[f64], truth: &[f64]) -> Vec<f64> {
        let mut readings = truth.to_vec();
        self.apply(times_s, &mut readings, None);
        readings
    }

    /// Replaces the truth by the readings; `slopes`, where given, receive their derivatives. The map is linear in the truth, so that
    /// derivatives of the truth pass through it in the same way.
    pub fn apply(&self, times_s: &[f64], values: &mut [f64], slopes: Option<&mut TimingSlopes>) {
        let Some(slopes) = slopes else {
            lag::apply(times_s, values, self.lag_s, None);
            if self.behind_s != 0.0 {
                let lagged = values.to_vec();
                read_off(times_s, &lagged, self.behind_s, |row, value, _| values[row] = value);
            }
            return;
        };
        slopes.by_lag.resize(values.len(), 0.0);
        slopes.by_behind.resize(values.len(), 0.0);
        lag::apply(times_s, values, self.lag_s, Some(&mut slopes.by_lag));
        let lagged = values.to_vec();
        read_off(times_s, &lagged, self.behind_s, |row, value, slope| {
            values[row] = value;
            slopes.by_behind[row] = slope;
        });
        if self.behind_s != 0.0 && self.lag_s > 0.0 {
            let by_lag = slopes.by_lag.clone();
            read_off(times_s, &by_lag, self.behind_s, |row, value, _| slopes.by_lag[row] = value);
        }
    }
}

/// Gives by row what a clock that is behind shows, and its derivative by the time by which it is behind: where that meets a row, the
/// mean of those to both sides.
fn read_off(times_s: &[f64], truth: &[f64], behind_s: f64, mut give: impl FnMut(usize, f64, f64)) {
    let rows = truth.len();
    // Rises to the row after one; nothing changes beyond the ends.
    let slope = |row: Option<usize>| match row.filter(|row| row + 1 < rows) {
        Some(row) => (truth[row + 1] - truth[row]) / (times_s[row + 1] - times_s[row]),
        None => 0.0,
    };
    // Number of rows up to the instant that is shown.
    let mut passed = 0;
    for row in 0..rows {
        let shown_s = times_s[row] + behind_s;
        while passed < rows && times_s[passed] <= shown_s {
            passed += 1;
        }
        let Some(before) = passed.checked_sub(1) else {
            give(row, truth[0], 0.0);
            continue;
        };
        let (beyond_s, rise) = (shown_s - times_s[before], slope(Some(before)));
        if beyond_s == 0.0 {
            give(row, truth[before], 0.5 * (slope(before.checked_sub(1)) + rise));
        } else {
            give(row, truth[before] + rise * beyond_s, rise);
        }
    }
}
