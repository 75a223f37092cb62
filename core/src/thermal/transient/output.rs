//! What is recorded along the way: states at output instants, and maxima, minima and means over time.
//!
//! Between step ends diffusion temperatures follow the cubic Hermite interpolant; the arithmetic nodes' balances are
//! closed anew at each output. Extremes are looked for at [`LOOKS`] points a step and refined by a parabola through the
//! best three; means are integrated by Boole's rule (Abramowitz & Stegun 25.4.14).

use crate::thermal::equations::segment;
use crate::thermal::model::QuantityValue;

use super::integrator::Integrator;
use super::{Transient, TransientError, TransientRequest};

/// Intervals a step is cut into for statistics over time.
const LOOKS: usize = 4;
/// Boole's weights for these intervals, over the whole step.
const BOOLE: [f64; LOOKS + 1] = [7.0 / 90.0, 32.0 / 90.0, 12.0 / 90.0, 32.0 / 90.0, 7.0 / 90.0];

/// Records a transient as it goes.
pub(super) struct Recorder<'a> {
    outputs_s: &'a [f64],
    /// Whether temperatures are recorded beside quantities.
    temperatures: bool,
    next: usize,
    /// Quantities over time: index and what of it.
    followed: Vec<(usize, QuantityValue)>,
    values: Vec<f64>,
    tangents: Vec<f64>,
    columns: usize,
    start_s: f64,
    end_s: f64,
}

impl<'a> Recorder<'a> {
    pub fn new(integrator: &Integrator<'_>, request: &TransientRequest<'a>, start_s: f64, end_s: f64) -> Self {
        let network = integrator.network;
        let followed: Vec<(usize, QuantityValue)> = (0..network.quantities())
            .filter(|&quantity| network.is_over_time(quantity))
            .map(|quantity| (quantity, network.quantities[quantity]))
            .collect();
        let columns = integrator.tangent.as_ref().map_or(0, |tangent| tangent.columns());
        Self {
            outputs_s: request.outputs_s,
            temperatures: request.temperatures,
            next: 0,
            values: followed
                .iter()
                .map(|(_, kind)| match kind {
                    QuantityValue::Maximum(_) => f64::NEG_INFINITY,
                    QuantityValue::Minimum(_) => f64::INFINITY,
                    QuantityValue::TimeMean(_) | QuantityValue::Instant(_) => 0.0,
                })
                .collect(),
            tangents: vec![0.0; followed.len() * columns],
            followed,
            columns,
            start_s,
            end_s,
        }
    }

    /// Number of outputs.
    pub fn outputs(&self) -> usize {
        self.outputs_s.len()
    }

    /// Records the outputs that are due where the state stands.
    pub fn due(&mut self, integrator: &mut Integrator<'_>, result: &mut Transient) -> Result<(), TransientError> {
        while self.outputs_s.get(self.next).is_some_and(|&output| output <= integrator.time_s) {
            self.output(integrator, 0.0, 0.0, result)?;
        }
        Ok(())
    }

    /// Records the start.
    pub fn begin(&mut self, integrator: &mut Integrator<'_>, result: &mut Transient) -> Result<(), TransientError> {
        self.due(integrator, result)?;
        if !self.followed.is_empty() && self.end_s <= self.start_s {
            integrator.state_at(0.0, 0.0)?;
            integrator.evaluate_quantities();
            for (at, &(quantity, _)) in self.followed.iter().enumerate() {
                self.values[at] = integrator.quantity(quantity);
            }
        }
        Ok(())
    }

    /// Records what lies in the step just tried, before the state moves.
    pub fn record(
        &mut self,
        integrator: &mut Integrator<'_>,
        step_s: f64,
        arrival_s: f64,
        result: &mut Transient,
    ) -> Result<(), TransientError> {
        while let Some(&output) = self.outputs_s.get(self.next) {
            if output > arrival_s {
                break;
            }
            let share = if output == arrival_s { 1.0 } else { ((output - integrator.time_s) / step_s).clamp(0.0, 1.0) };
            self.output(integrator, share, step_s, result)?;
        }
        if !self.followed.is_empty() {
            self.follow(integrator, step_s)?;
        }
        Ok(())
    }

    fn output(
        &mut self,
        integrator: &mut Integrator<'_>,
        share: f64,
        step_s: f64,
        result: &mut Transient,
    ) -> Result<(), TransientError> {
        self.next += 1;
        integrator.state_at(share, step_s)?;
        integrator.evaluate_quantities();
        result.quantities.extend((0..integrator.network.quantities()).map(|q| integrator.quantity(q)));
        if self.temperatures {
            integrator.output_temperatures(result);
        }
        integrator.output_tangent(share, step_s, self.temperatures, result);
        Ok(())
    }

    /// Goes on with maxima, minima and means over the step just tried.
    fn follow(&mut self, integrator: &mut Integrator<'_>, step_s: f64) -> Result<(), TransientError> {
        let count = self.followed.len();
        let mut seen = vec![0.0; (LOOKS + 1) * count];
        for look in 0..=LOOKS {
            integrator.state_at(look as f64 / LOOKS as f64, step_s)?;
            integrator.evaluate_quantities();
            for (at, &(quantity, kind)) in self.followed.iter().enumerate() {
                let value = integrator.quantity(quantity);
                seen[look * count + at] = value;
                if matches!(kind, QuantityValue::TimeMean(_)) {
                    self.values[at] += BOOLE[look] * step_s * value;
                }
            }
            if self.columns > 0 {
                let tangents = integrator.quantity_tangent_at(look as f64 / LOOKS as f64, step_s);
                for (at, &(quantity, kind)) in self.followed.iter().enumerate() {
                    if matches!(kind, QuantityValue::TimeMean(_)) {
                        for column in 0..self.columns {
                            self.tangents[at * self.columns + column] +=
                                BOOLE[look] * step_s * tangents[quantity * self.columns + column];
                        }
                    }
                }
            }
        }
        for at in 0..count {
            let (quantity, kind) = self.followed[at];
            let sign = match kind {
                QuantityValue::Maximum(_) => 1.0,
                QuantityValue::Minimum(_) => -1.0,
                QuantityValue::TimeMean(_) | QuantityValue::Instant(_) => continue,
            };
            let mut best = 0;
            for look in 1..=LOOKS {
                if sign * seen[look * count + at] > sign * seen[best * count + at] {
                    best = look;
                }
            }
            let mut candidates = vec![best as f64 / LOOKS as f64];
            if best > 0 && best < LOOKS {
                let (a, b, c) = (seen[(best - 1) * count + at], seen[best * count + at], seen[(best + 1) * count + at]);
                let bend = a - 2.0 * b + c;
                if bend != 0.0 {
                    let shift = (0.5 * (a - c) / bend).clamp(-1.0, 1.0);
                    candidates.push((best as f64 + shift) / LOOKS as f64);
                }
            }
            for share in candidates {
                integrator.state_at(share, step_s)?;
                integrator.evaluate_quantities();
                let value = integrator.quantity(quantity);
                if sign * value > sign * self.values[at] {
                    self.values[at] = value;
                    if self.columns > 0 {
                        // At an extreme in time its instant does not matter to first order.
                        let tangents = integrator.quantity_tangent_at(share, step_s);
                        let from = quantity * self.columns;
                        self.tangents[at * self.columns..(at + 1) * self.columns]
                            .copy_from_slice(&tangents[from..from + self.columns]);
                    }
                }
            }
        }
        Ok(())
    }

    /// Puts the statistics over time into the result.
    pub fn finish(&self, integrator: &Integrator<'_>, result: &mut Transient) {
        let quantities = integrator.network.quantities();
        let duration = self.end_s - self.start_s;
        result.over_time = vec![None; quantities];
        result.over_time_tangent = vec![0.0; quantities * self.columns];
        for (at, &(quantity, kind)) in self.followed.iter().enumerate() {
            let scale =
                if matches!(kind, QuantityValue::TimeMean(_)) && duration > 0.0 { duration.recip() } else { 1.0 };
            result.over_time[quantity] = Some(scale * self.values[at]);
            for column in 0..self.columns {
                result.over_time_tangent[quantity * self.columns + column] =
                    scale * self.tangents[at * self.columns + column];
            }
        }
    }
}

impl Integrator<'_> {
    /// Brings the file to a share of the step just tried, arithmetic nodes closed.
    fn state_at(&mut self, share: f64, step_s: f64) -> Result<(), TransientError> {
        self.set_instant(self.time_s + share * step_s);
        self.interpolate(share, step_s);
        if self.algebraic.is_some() && share > 0.0 && share < 1.0 {
            // The first inner stage's room is free once the step has been tried.
            let range = self.equations.temperatures();
            let (file, room) = (&self.file[range], &mut self.stage_values[1]);
            room.copy_from_slice(file);
            self.make_consistent(1)?;
            let range = self.equations.temperatures();
            self.file[range].copy_from_slice(&self.stage_values[1]);
        }
        Ok(())
    }

    /// Appends the temperatures of all nodes at the state in the file to the result.
    fn output_temperatures(&mut self, result: &mut Transient) {
        self.equations.program.run(segment::BOUNDARY, &mut self.file);
        let from = result.temperatures.len();
        result.temperatures.resize(from + self.network.nodes.len(), 0.0);
        let row = &mut result.temperatures[from..];
        for &(node, register) in &self.equations.boundaries {
            row[node] = self.file[register.index()];
        }
        let first = self.equations.temperatures().start;
        for (position, &node) in self.equations.unknowns.iter().enumerate() {
            row[node] = self.file[first + position];
        }
    }

    /// Evaluates the quantities at the state in the file.
    fn evaluate_quantities(&mut self) {
        self.equations.program.run(segment::QUANTITY, &mut self.file);
    }

    /// A quantity as evaluated last.
    fn quantity(&self, index: usize) -> f64 {
        self.file[self.equations.quantity[index].index()]
    }
}
