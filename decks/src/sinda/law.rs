//! Values that depend on temperature: options SIV, SPV and DIV with their arrays.

use super::arrays::points;
use super::assembly::Assembly;
use crate::Table;
use crate::arithmetic::quantity::Quantity;

/// How an array is understood.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// Pairs of temperature and value, linear between them.
    Interpolated,
    /// Coefficients of a polynomial in the temperature, the constant first.
    Polynomial,
}

/// The temperature that a value depends on.
#[derive(Debug, Clone, Copy)]
pub(super) struct At {
    /// The expression, in K.
    pub(super) expression: &'static str,
    /// Its value at the start, in K.
    pub(super) initial_k: f64,
}

/// `factor` times what an array says of a temperature; a number in the array's place is a constant.
///
/// # Errors
/// An array that is not there or not understood.
pub(super) fn law(
    assembly: &mut Assembly,
    submodel: &str,
    form: Form,
    reference: &str,
    at: At,
    factor: &str,
) -> Result<Quantity, String> {
    let factor = assembly.control.quantity(factor).map_err(|message| format!("factor: {message}"))?;
    if let Ok(value) = reference.parse::<f64>()
        && reference.contains('.')
    {
        return Quantity::number(value, false).join('*', factor);
    }
    let ((of, _), _) = assembly.arrays.find(submodel, reference)?;
    assembly.seen.arrays.insert(of);
    let (text, nominal) = match form {
        Form::Interpolated => {
            let (name, nominal) = table(assembly, submodel, reference, at.initial_k)?;
            (format!("interp({name}, {})", at.expression), nominal)
        }
        Form::Polynomial => polynomial(assembly, submodel, reference, at)?,
    };
    if !nominal.is_finite() {
        return Err(format!("array {reference} is not finite at {} K", at.initial_k));
    }
    Quantity::expression(text, nominal).join('*', factor)
}

/// The name of the table of an array, and its value at a temperature.
fn table(assembly: &mut Assembly, submodel: &str, reference: &str, kelvin: f64) -> Result<(String, f64), String> {
    let (key, values) = assembly.arrays.find(submodel, reference)?;
    let (mut x, y) = points(reference, values)?;
    x.iter_mut().for_each(|x| *x = assembly.control.units.kelvin(*x));
    let nominal = interpolated(&x, &y, kelvin);
    if let Some(name) = assembly.tables.get(&key) {
        return Ok((name.clone(), nominal));
    }
    let separator = if key.0.is_empty() { "" } else { "_" };
    let name = assembly.identifiers.make(&format!("{}{separator}A{}", key.0, key.1));
    // The study format has no table of a single point.
    let (x, y) = match (x.as_slice(), y.as_slice()) {
        ([x], [y]) => (vec![*x, x + 1.0], vec![*y, *y]),
        _ => (x, y),
    };
    assembly.deck.tables.push(Table { name: name.clone(), x, y });
    assembly.tables.insert(key, name.clone());
    Ok((name, nominal))
}

/// Linear between the points, constant beyond their ends.
fn interpolated(x: &[f64], y: &[f64], at: f64) -> f64 {
    let above = x.partition_point(|x| *x < at);
    let value = |place: usize| y.get(place).copied().unwrap_or(f64::NAN);
    match (above.checked_sub(1).and_then(|below| x.get(below)), x.get(above)) {
        (Some(low), Some(high)) => value(above - 1) + (value(above) - value(above - 1)) * (at - low) / (high - low),
        (None, _) => value(0),
        (Some(_), None) => value(x.len() - 1),
    }
}

/// A polynomial in the deck's own scale by Horner's rule, and its value.
fn polynomial(assembly: &Assembly, submodel: &str, reference: &str, at: At) -> Result<(String, f64), String> {
    let (_, values) = assembly.arrays.find(submodel, reference)?;
    let (Some(last), Some(rest)) = (values.last(), values.get(..values.len().saturating_sub(1))) else {
        return Err(format!("array {reference} is empty: expected coefficients"));
    };
    let units = &assembly.control.units;
    let degrees = match (units.kelvin_per_degree, units.zero_k) {
        (1.0, 0.0) => format!("({})", at.expression),
        (1.0, zero_k) => format!("(({}) - {zero_k:?})", at.expression),
        (degree, zero_k) => format!("((({}) - {zero_k:?}) / {degree:?})", at.expression),
    };
    let at_start = (at.initial_k - units.zero_k) / units.kelvin_per_degree;
    let (mut text, mut nominal) = (format!("({last:?})"), *last);
    for coefficient in rest.iter().rev() {
        text = format!("({coefficient:?} + {degrees} * {text})");
        nominal = coefficient + at_start * nominal;
    }
    Ok((text, nominal))
}

/// Two conductances one behind the other, each at its own end.
///
/// # Errors
/// A value that is not finite at the start.
pub(super) fn in_series(first: Quantity, second: Quantity) -> Result<Quantity, String> {
    let sum = first.clone().join('+', second.clone())?;
    first.join('*', second)?.join('/', sum)
}
