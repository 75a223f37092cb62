//! Events: thermostats that switch and kinks of expressions of time.
//!
//! A thermostat that is off watches `on - T`, one that is on watches `T - off`; it switches where that rises through
//! zero. The instant is found by bisection on the step's interpolant, the step is then repeated up to it. After a
//! switching the thermostat watches the other end of its band, so it cannot chatter.

use crate::thermal::equations::segment;

use super::integrator::Integrator;
use super::tableau::STAGES;
use super::{Transient, TransientError};

/// Points within a step at which signs are looked at.
const LOOKS: usize = 4;
/// Thermostats whose functions lie within this of the one that switches go with it, K.
const TOGETHER_K: f64 = 1e-7;
/// Bisections; more than a double can resolve.
const BISECTIONS: u32 = 60;

impl Integrator<'_> {
    /// Modes of the thermostats from the start temperatures: on below `on`, else off.
    pub(super) fn choose_modes(&mut self) -> Result<(), TransientError> {
        if self.equations.modes == 0 {
            return Ok(());
        }
        self.file[self.equations.temperatures()].copy_from_slice(&self.stage_values[0]);
        self.equations.program.run(segment::SWITCH, &mut self.file);
        for (mode, [on, off]) in self.equations.switch.iter().enumerate() {
            let (on, off) = (self.file[on.index()], self.file[off.index()]);
            let band_k = -(on + off);
            if !(band_k > 0.0) {
                return Err(TransientError::NoHysteresis { element: self.equations.mode_names[mode].clone(), band_k });
            }
            self.file[self.equations.modes().start + mode] = f64::from(u8::from(on > 0.0));
        }
        self.forget_instant();
        self.set_instant(self.time_s);
        Ok(())
    }

    /// Register of the function that a thermostat watches now.
    fn watched(&self, mode: usize) -> usize {
        let on = self.file[self.equations.modes().start + mode] > 0.5;
        self.equations.switch[mode][usize::from(on)].index()
    }

    /// Largest watched function at a share of the step just tried.
    fn watch(&mut self, share: f64, step_s: f64) -> f64 {
        self.interpolate(share, step_s);
        self.set_instant(self.time_s + share * step_s);
        self.equations.program.run(segment::SWITCH, &mut self.file);
        (0..self.equations.modes).map(|mode| self.file[self.watched(mode)]).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The first switching within the step just tried, s.
    pub(super) fn switching_within(&mut self, step_s: f64) -> Option<f64> {
        if self.equations.modes == 0 {
            return None;
        }
        let held = self.file[self.equations.temperatures()].to_vec();
        let mut from = 0.0;
        let mut found = None;
        for look in 1..=LOOKS {
            let to = look as f64 / LOOKS as f64;
            if self.watch(to, step_s) > 0.0 {
                found = Some((from, to));
                break;
            }
            from = to;
        }
        let time_s = found.map(|(mut low, mut high)| {
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (low + high);
                if !(middle > low && middle < high) {
                    break;
                }
                if self.watch(middle, step_s) > 0.0 {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            self.time_s + high * step_s
        });
        // The slopes of the matrix are taken from the file at the step's end.
        self.file[self.equations.temperatures()].copy_from_slice(&held);
        self.set_instant(self.time_s + step_s);
        time_s
    }

    /// Switches what is due at the present state.
    pub(super) fn switch(&mut self, result: &mut Transient) -> Result<(), TransientError> {
        self.set_instant(self.time_s);
        self.file[self.equations.temperatures()].copy_from_slice(&self.stage_values[0]);
        self.equations.program.run(segment::SWITCH, &mut self.file);
        let values: Vec<f64> = (0..self.equations.modes).map(|mode| self.file[self.watched(mode)]).collect();
        // The repeated step may stay short of a crossing that the interpolant saw, by its error: the nearest goes.
        let nearest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let due: Vec<usize> = (0..values.len()).filter(|&mode| values[mode] >= nearest.min(0.0) - TOGETHER_K).collect();
        let Some(&leading) = due.first() else { return Ok(()) };
        let before = self.tangent.is_some().then(|| self.stage_slopes[0].clone());
        self.switch_shift(leading);
        for &mode in &due {
            let place = self.equations.modes().start + mode;
            let on = self.file[place] <= 0.5;
            self.file[place] = f64::from(u8::from(on));
            self.note_event(mode, on, result);
        }
        self.restart()?;
        if let Some(before) = before {
            self.jump_tangent(&before);
        }
        Ok(())
    }

    /// The first kink of an expression of time within the next step: the last instant before it and the first after.
    pub(super) fn kink_within(&mut self, step_s: f64) -> Option<(f64, f64)> {
        if self.equations.kinks.is_empty() {
            return None;
        }
        let start = self.time_s;
        let mut from = start;
        let before = self.kink_signs(from);
        for look in 1..=LOOKS {
            let to = if look == LOOKS { start + step_s } else { start + step_s * (look as f64 / LOOKS as f64) };
            if self.kink_signs(to) != before {
                let (mut low, mut high) = (from, to);
                for _ in 0..BISECTIONS {
                    let middle = 0.5 * (low + high);
                    if !(middle > low && middle < high) {
                        break;
                    }
                    if self.kink_signs(middle) == before {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                return Some((low, high));
            }
            from = to;
        }
        None
    }

    /// Whether each kink function is at least zero at an instant, mixed into one number (a change changes it).
    fn kink_signs(&mut self, time_s: f64) -> u64 {
        self.set_instant(time_s);
        self.equations.program.run(segment::KINK, &mut self.file);
        let mut signs: u64 = 0;
        for register in &self.equations.kinks {
            signs = signs.rotate_left(1) ^ u64::from(self.file[register.index()] >= 0.0);
        }
        signs
    }

    /// Puts the interpolated temperatures at a share of the step just tried into the file: cubic Hermite for
    /// diffusion nodes, linear for arithmetic nodes.
    pub(super) fn interpolate(&mut self, share: f64, step_s: f64) {
        let range = self.equations.temperatures();
        let weights = hermite(share);
        for (row, slot) in self.file[range].iter_mut().enumerate() {
            let (start, end) = (self.stage_values[0][row], self.stage_values[STAGES - 1][row]);
            *slot = if self.equations.capacity[row].is_some() {
                let (from, to) = (self.stage_slopes[0][row], self.stage_slopes[STAGES - 1][row]);
                weights[0] * start + weights[1] * end + step_s * (weights[2] * from + weights[3] * to)
            } else {
                start + share * (end - start)
            };
        }
    }
}

/// Weights of the start, the end, and the slopes there times the step, in the cubic through them.
pub(super) fn hermite(share: f64) -> [f64; 4] {
    let rest = 1.0 - share;
    [rest * rest * (1.0 + 2.0 * share), share * share * (3.0 - 2.0 * share), share * rest * rest, -share * share * rest]
}
