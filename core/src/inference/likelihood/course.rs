//! The courses of transients at given unknowns, linearised, for whoever asks what small heats would change in the readings.

use super::transient::TransientPart;
use super::{Likelihood, Part};
use crate::inference::target::Rejected;
use crate::measurement::InputTable;
use crate::measurement::timing::Timing;
use crate::thermal::transient::linearised::{KnownCourse, LinearisedTransient};

/// A transient at given unknowns.
#[derive(Clone, Debug)]
pub struct Course {
    /// Position of the measurement.
    pub measurement: usize,
    /// Inputs with their constant errors.
    pub inputs: InputTable,
    /// Rows up to the last that is used.
    pub rows: usize,
    /// Temperatures of all nodes, `rows x nodes`, K.
    pub temperatures: Vec<f64>,
    /// Rows between which the linearised network goes.
    pub kept: Vec<usize>,
    /// The network along it.
    pub linearised: LinearisedTransient,
    /// The sensors.
    pub sensors: Vec<CourseSensor>,
}

/// A sensor of a transient.
#[derive(Clone, Debug)]
pub struct CourseSensor {
    /// Position of its quantity in the network.
    pub quantity: usize,
    /// When it shows what happens.
    pub timing: Timing,
    /// Position of its first residual; the others follow.
    pub first: usize,
    /// Rows of its residuals.
    pub rows: Vec<usize>,
}

impl Likelihood {
    /// The courses of all transients at given unknowns, each linearised between kept rows (by measurement; all where there are
    /// none). `None` where one of them cannot be linearised: it begins in a periodic state or with nodes in balance, or the network has
    /// thermostats or is too large.
    ///
    /// # Errors
    /// As [`crate::inference::target::Target::log_likelihood`].
    pub fn courses(&self, unknowns: &[f64], kept: &[Option<Vec<usize>>]) -> Result<Option<Vec<Course>>, Rejected> {
        let unknowns = &*self.at(unknowns);
        let parameters = self.full_of(unknowns);
        let mut courses = Vec::new();
        for part in &self.parts {
            let Part::Transient(part) = part else { continue };
            if part.is_empty() {
                continue;
            }
            match self.course(part, unknowns, &parameters, kept)? {
                Some(course) => courses.push(course),
                None => return Ok(None),
            }
        }
        Ok(Some(courses))
    }

    fn course(
        &self,
        part: &TransientPart,
        unknowns: &[f64],
        parameters: &[f64],
        kept: &[Option<Vec<usize>>],
    ) -> Result<Option<Course>, Rejected> {
        let Some(known) = part.known(self, unknowns, parameters)? else { return Ok(None) };
        let kept = kept.get(part.measurement()).cloned().flatten().unwrap_or_else(|| (0..known.rows).collect());
        if kept.last().is_none_or(|&last| last + 1 != known.rows) {
            return Ok(None);
        }
        let course = KnownCourse {
            parameters,
            inputs: &known.inputs,
            from_steady: known.from_steady,
            temperatures: &known.temperatures,
            rows: &kept,
        };
        let linearised = self.network.linearised_along(&course);
        let Ok(Some(linearised)) = linearised else { return Ok(None) };
        Ok(Some(Course {
            measurement: part.measurement(),
            inputs: known.inputs,
            rows: known.rows,
            temperatures: known.temperatures,
            kept,
            linearised,
            sensors: part.course_sensors(unknowns),
        }))
    }
}
