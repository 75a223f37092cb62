//! A transient cut into stretches of time that an engineer would call phases.

use crate::document::time;
use crate::measurement::{InputTable, Measurement, Rows};

/// Most stretches that steps of the inputs may give before equal ones are taken instead.
const MOST_BY_STEPS: usize = 16;
/// Number of equal stretches.
const EQUAL: usize = 10;

/// Rows from `from` to before `to`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stretch {
    /// First row.
    pub from: usize,
    /// Row after the last.
    pub to: usize,
    /// Whether its rows are held out.
    pub held_out: bool,
}

/// Cuts a transient where an input that is held between rows steps, where held-out rows begin or end, and, where the
/// inputs give no useful phases, into ten equal parts. A steady measurement has none.
pub fn stretches(measurement: &Measurement) -> Vec<Stretch> {
    let Rows::Transient { inputs, held_out, .. } = &measurement.rows else {
        return Vec::new();
    };
    let rows = inputs.times_s.len();
    if rows == 0 {
        return Vec::new();
    }
    let mut cuts: Vec<usize> =
        (1..rows).filter(|&row| inputs.columns.iter().any(|c| c.hold && c.values[row] != c.values[row - 1])).collect();
    if cuts.is_empty() || cuts.len() >= MOST_BY_STEPS {
        let (start, end) = (inputs.times_s[0], inputs.times_s[rows - 1]);
        cuts = (1..EQUAL)
            .map(|k| {
                let time = start + (end - start) * k as f64 / EQUAL as f64;
                inputs.times_s.partition_point(|&t| t < time)
            })
            .collect();
    }
    cuts.extend((1..rows).filter(|&row| held_out[row] != held_out[row - 1]));
    cuts.extend([0, rows]);
    cuts.sort_unstable();
    cuts.dedup();
    cuts.windows(2)
        .filter(|pair| pair[0] < pair[1])
        .map(|pair| Stretch { from: pair[0], to: pair[1], held_out: held_out[pair[0]] })
        .collect()
}

/// A stretch's name, by its first and last instant, in the unit that suits the whole record: `10 to 120 s`.
pub fn name(inputs: &InputTable, stretch: Stretch) -> String {
    time::stretch(inputs.times_s[stretch.from], inputs.times_s[stretch.to - 1], inputs.longest_s())
}

/// The stretch in which deviations, each with its instant in s, have the largest root mean square; None without any.
pub fn worst(measurement: &Measurement, deviations: &[(f64, f64)]) -> Option<String> {
    let Rows::Transient { inputs, .. } = &measurement.rows else { return None };
    let mean_squares = stretches(measurement).into_iter().filter_map(|stretch| {
        let (from, to) = (inputs.times_s[stretch.from], inputs.times_s[stretch.to - 1]);
        let squares: Vec<f64> =
            deviations.iter().filter(|(t, _)| (from..=to).contains(t)).map(|(_, own)| own * own).collect();
        (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / squares.len() as f64, stretch))
    });
    let (_, stretch) = mean_squares.max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(name(inputs, stretch))
}
