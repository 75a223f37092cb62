//! Figures of a study's own, as written.

use crate::document::{Map, Spanned, WrittenUnit, written_choice, written_struct};

written_choice! {
    /// A figure of the report.
    pub enum FigureForm: "a figure" {
        /// Readings of a sensor in steady phases against an input or another sensor.
        "readings" => Readings(ReadingsForm),
        /// Contours of a quantity over two axes, with the test's phases and what the fit leaves there.
        "contours" => Contours(ContoursForm),
    }
}

written_struct! {
    /// Readings of a sensor beside what the model and others say.
    pub struct ReadingsForm: "readings to be drawn" {
        /// The measurement, of steady phases.
        required data: Spanned<String>,
        /// The sensor.
        required of: Spanned<String>,
        /// What is taken off its readings: another sensor, or an input.
        optional minus: Spanned<String>,
        /// The horizontal axis: an input, or another sensor.
        required against: Spanned<String>,
        /// An input: a series for each of its values.
        optional by: Spanned<String>,
        /// What others say, such as a data sheet.
        default(Map::default()) estimates: Map<EstimateForm>,
        /// What to look at.
        optional description: String,
    }
}

written_struct! {
    /// An estimate of others.
    pub struct EstimateForm: "an estimate" {
        /// Value of the horizontal axis and what is estimated there, point by point.
        required points: Spanned<Vec<[f64; 2]>>,
        /// Units of the two.
        required units: [WrittenUnit; 2],
        /// Where it comes from.
        required source: Spanned<String>,
        /// Set where it was reconstructed: what and how.
        optional reconstructed: String,
    }
}

written_struct! {
    /// Contours of a quantity.
    pub struct ContoursForm: "contours to be drawn" {
        /// The quantity.
        required of: Spanned<String>,
        /// The `propagate` or `predict` job that has it, swept over a design variable in at least two environments.
        required from: Spanned<String>,
        /// Horizontal and vertical axis: the design variable, an input in which the environments differ, or a quantity of
        /// the job.
        required over: [Spanned<String>; 2],
        /// What to look at.
        optional description: String,
    }
}
