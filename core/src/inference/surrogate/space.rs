//! The coordinates of a surrogate: parameters and inputs that vary over its runs, shifted and scaled.

use serde::{Deserialize, Serialize};

use super::Run;
use crate::math::functions::ln;
use crate::thermal::{Fault, Point};

/// Share of a range by which rounding may leave it.
const ROUNDING: f64 = 1e-9;

/// A coordinate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Axis {
    /// Place among the parameters, then inputs.
    pub place: usize,
    /// Value at coordinate 0, SI.
    pub centre: f64,
    /// Change of the value by coordinate 1, SI; of its logarithm where that is the coordinate.
    pub scale: f64,
    /// Whether the logarithm of the value is the coordinate.
    pub is_log: bool,
    /// Values between which runs lie, where these have ends of their own, SI.
    pub range: Option<[f64; 2]>,
}

impl Axis {
    /// The coordinate at a value.
    fn at(&self, value: f64) -> f64 {
        let apart = if self.is_log { ln(value) - ln(self.centre) } else { value - self.centre };
        apart / self.scale
    }
}

/// All coordinates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Space {
    /// Names of the model's own parameters, then of its inputs.
    pub names: Vec<String>,
    /// How many of these are parameters.
    pub parameters: usize,
    /// Values in all runs where a parameter or input is no coordinate, SI.
    pub base: Vec<f64>,
    /// The coordinates.
    pub axes: Vec<Axis>,
}

impl Space {
    fn value(&self, point: &Point, place: usize) -> f64 {
        let value = match place.checked_sub(self.parameters) {
            Some(input) => point.inputs.get(input),
            None => point.parameters.get(place),
        };
        value.copied().unwrap_or(f64::NAN)
    }

    /// Coordinates of a run.
    pub fn of_run(&self, run: &Run) -> Vec<f64> {
        let value = |axis: &Axis| match axis.place.checked_sub(self.parameters) {
            Some(input) => run.inputs.get(input),
            None => run.parameters.get(axis.place),
        };
        self.axes.iter().map(|axis| axis.at(value(axis).copied().unwrap_or(f64::NAN))).collect()
    }

    /// Coordinates of a point; parameters behind the model's own are not looked at.
    ///
    /// # Errors
    /// A value that no run had: beyond a range, or another than in all runs.
    pub fn coordinates(&self, point: &Point) -> Result<Vec<f64>, Fault> {
        let what = "no run of the surrogate is near";
        let mut axes = self.axes.iter().peekable();
        let mut coordinates = Vec::with_capacity(self.axes.len());
        for (place, name) in self.names.iter().enumerate() {
            let value = self.value(point, place);
            match axes.next_if(|axis| axis.place == place) {
                Some(axis) => {
                    if let Some([lower, upper]) = axis.range {
                        let slack = ROUNDING * (upper - lower);
                        if !(value >= lower - slack && value <= upper + slack) {
                            let detail = format!(
                                "`{name}` is {value}, and runs reach from {lower} to {upper} (SI): state a wider `range`"
                            );
                            return Err(Fault { what, detail });
                        }
                    }
                    coordinates.push(axis.at(value));
                }
                None => {
                    let base = self.base.get(place).copied().unwrap_or(f64::NAN);
                    if !((value - base).abs() <= ROUNDING * base.abs()) {
                        let detail = format!(
                            "`{name}` is {value}, and was {base} in all runs (SI): give a parameter a prior, or an input its `range`, \
                             that spans what is asked"
                        );
                        return Err(Fault { what, detail });
                    }
                }
            }
        }
        if coordinates.iter().all(|value| value.is_finite()) {
            Ok(coordinates)
        } else {
            Err(Fault { what, detail: "a value is no finite number".to_owned() })
        }
    }

    /// The coordinate that changes with a parameter or input of a point (by its place among the point's parameters, then inputs),
    /// and by how much; `None` where none does.
    pub fn slope(&self, point: &Point, place: usize) -> Option<(usize, f64)> {
        let (own, value) = match place.checked_sub(point.parameters.len()) {
            Some(input) => (self.parameters + input, point.inputs.get(input)?),
            // Parameters behind the model's own are errors of the surrogate.
            None if place >= self.parameters => return None,
            None => (place, point.parameters.get(place)?),
        };
        let (number, axis) = self.axes.iter().enumerate().find(|(_, axis)| axis.place == own)?;
        Some((number, if axis.is_log { 1.0 / (axis.scale * value) } else { 1.0 / axis.scale }))
    }

    /// The point at values of the coordinates, SI, in their order.
    pub fn point(&self, values: &[f64]) -> Point {
        let mut all = self.base.clone();
        for (axis, value) in self.axes.iter().zip(values) {
            if let Some(slot) = all.get_mut(axis.place) {
                *slot = *value;
            }
        }
        let inputs = all.split_off(self.parameters.min(all.len()));
        Point { parameters: all, inputs }
    }
}
