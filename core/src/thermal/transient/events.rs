//! Events: thermostats that switch and discontinuities of expressions of time.
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
/// Switchings of thermostats that are allowed in any transient, and for each of its outputs: of more nobody sees a thing.
pub(super) const MOST_SWITCHINGS: u64 = 200_000;
pub(super) const SWITCHINGS_AN_OUTPUT: u64 = 200;
/// Switchings from which it is looked at how many there would be to the end.
const SWITCHINGS_LOOKED_AT: u64 = 10_000;
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
        let mut bracket = None;
        for look in 1..=LOOKS {
            let to = look as f64 / LOOKS as f64;
            if self.watch(to, step_s) > 0.0 {
                bracket = Some((from, to));
                break;
            }
            from = to;
        }
        let time_s = bracket.map(|(mut low, mut high)| {
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

    /// That the thermostats would not switch more often to the end than `most` times.
    pub(super) fn check_cycling(
        &self,
        [start_s, end_s]: [f64; 2],
        most: u64,
        result: &Transient,
    ) -> Result<(), TransientError> {
        let events = self.stats.events;
        if events < SWITCHINGS_LOOKED_AT {
            return Ok(());
        }
        let expected = events as f64 * (end_s - start_s) / (self.time_s - start_s);
        // Written so that no time passed counts as too often.
        if expected <= most as f64 {
            return Ok(());
        }
        let times = |mode: usize| {
            let name = &self.equations.mode_names[mode];
            result.events.iter().filter(|event| event.element == *name).count()
        };
        // The first of those that switch most often.
        let mode = (0..self.equations.modes).rev().max_by_key(|&mode| times(mode)).unwrap_or(0);
        let [on, off] = self.equations.switch[mode];
        let band_k = -(self.file[on.index()] + self.file[off.index()]);
        Err(TransientError::Cycling {
            element: self.equations.mode_names[mode].clone(),
            switchings: times(mode) as u64,
            time_s: self.time_s,
            expected,
            end_s,
            most,
            band_k,
            // Cycles are as long as the band is wide; with room to spare.
            wider_k: 2.0 * band_k * expected / most as f64,
        })
    }

    /// The first discontinuity of an expression of time within the next step: the last instant before it and the first after.
    pub(super) fn discontinuity_within(&mut self, step_s: f64) -> Option<(f64, f64)> {
        if self.equations.discontinuities.is_empty() && self.equations.table_discontinuities.is_empty() {
            return None;
        }
        let start = self.time_s;
        let mut from = start;
        let before = self.discontinuity_signs(from);
        for look in 1..=LOOKS {
            let to = if look == LOOKS { start + step_s } else { start + step_s * (look as f64 / LOOKS as f64) };
            if self.discontinuity_signs(to) != before {
                let (mut low, mut high) = (from, to);
                for _ in 0..BISECTIONS {
                    let middle = 0.5 * (low + high);
                    if !(middle > low && middle < high) {
                        break;
                    }
                    if self.discontinuity_signs(middle) == before {
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

    /// Whether each discontinuity function is at least zero at an instant, and between which of its points each table is read,
    /// mixed into one number (a change changes it; Fowler, Noll & Vo's hash).
    fn discontinuity_signs(&mut self, time_s: f64) -> u64 {
        self.set_instant(time_s);
        self.equations.program.run(segment::DISCONTINUITY, &mut self.file);
        let mut signs: u64 = 0xcbf2_9ce4_8422_2325;
        let mut mix = |value: u64| signs = (signs ^ value).wrapping_mul(0x0100_0000_01b3);
        for register in &self.equations.discontinuities {
            mix(u64::from(self.file[register.index()] >= 0.0));
        }
        for (points, register) in &self.equations.table_discontinuities {
            let at = self.file[register.index()];
            mix(points.partition_point(|&point| point <= at) as u64);
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
