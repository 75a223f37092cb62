//! Piecewise linear functions of the pitch angle, as expressions of their ordinates.

use crate::deck::Table;

use super::assembly::Assembly;
use super::component::Component;

/// A component with more points than this in all has tables of fixed numbers: expressions of more than about a thousand
/// operations help nobody.
pub const MOST_POINTS: usize = 80;

/// A number in an expression.
pub fn number(value: f64) -> String {
    if value < 0.0 { format!("({value})") } else { value.to_string() }
}

/// Abscissae of a list argument in degrees, or the class's own; they must rise, and be two at least.
///
/// # Errors
/// A list of another form.
pub fn abscissae(component: &Component<'_>, argument: &str, default: &[f64]) -> Result<Vec<f64>, String> {
    let pitches = component.arguments.numbers(argument)?.unwrap_or_else(|| default.to_vec());
    let rise = pitches.windows(2).all(|pair| matches!(pair, [left, right] if left < right));
    if !rise || pitches.len() < 2 {
        return Err(format!("`{argument}` must be two or more pitch angles in degrees that rise"));
    }
    Ok(pitches)
}

/// A function of `pitch` (the identifier of an angle in radians) through the next parameters of the list, one per
/// abscissa in degrees, constant beyond the ends; `prefix` is what their names begin with.
///
/// It is `P0 + sum (P[i+1] - P[i]) clamp((pitch - x[i]) / (x[i+1] - x[i]), 0, 1)`, so that the ordinates stay parameters.
///
/// # Errors
/// Parameters that are missing or of another kind.
pub fn function(
    assembly: &mut Assembly<'_>,
    component: &Component<'_>,
    pitch: &str,
    prefix: &str,
    pitches: &[f64],
    as_table: bool,
) -> Result<String, String> {
    if as_table {
        let ordinates = pitches.iter().map(|_| assembly.fitted(prefix).map(|fitted| fitted.value));
        let y = ordinates.collect::<Result<Vec<f64>, String>>()?;
        let name = assembly.identifier(&format!("{}__{prefix}", component.name));
        let x = pitches.iter().map(|degrees| degrees.to_radians()).collect();
        assembly.deck.tables.push(Table { name: name.clone(), x, y });
        let message = format!(
            "{name} is a table of {} fixed numbers over pitch in radians: too many for parameters",
            pitches.len()
        );
        assembly.note(component, message);
        return Ok(format!("interp({name}, {pitch})"));
    }
    let mut sum = String::new();
    let mut before: Option<(f64, String)> = None;
    for &degrees in pitches {
        let name = assembly.parameter(component, &format!("{prefix}_{degrees:.0}"), "W", |power| power)?;
        match before {
            None => sum.clone_from(&name),
            Some((left, last)) => {
                let (from, width) = (number(left), number(degrees - left));
                sum.push_str(&format!(" + ({name} - {last}) * clamp(({pitch} * 180 / pi - {from}) / {width}, 0, 1)"));
            }
        }
        before = Some((degrees, name));
    }
    Ok(sum)
}
