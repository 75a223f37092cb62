//! Figures that a study asks for, resolved. The report draws them; no job knows them.

/// A figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Its name in the pass.
    pub name: String,
    /// What to look at, for people.
    pub description: Option<String>,
    /// What is drawn.
    pub drawn: Drawn,
}

/// What a figure shows.
#[derive(Clone, Debug, PartialEq)]
pub enum Drawn {
    /// Readings of a test.
    Readings(Readings),
    /// A quantity over two axes.
    Contours(Contours),
}

/// Readings of a sensor in steady phases, beside what the model and others say.
#[derive(Clone, Debug, PartialEq)]
pub struct Readings {
    /// The measurement.
    pub measurement: String,
    /// The sensor, by its position in the measurement.
    pub sensor: usize,
    /// What is taken off its readings.
    pub minus: Option<Source>,
    /// The horizontal axis.
    pub against: Source,
    /// Index of the input by whose values series are told apart.
    pub by: Option<usize>,
    /// What others say.
    pub estimates: Vec<Estimate>,
}

/// Where the numbers of an axis come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// An input of the model, by its index.
    Input(usize),
    /// A sensor, by its position in the measurement.
    Sensor(usize),
}

/// An estimate of others, such as a data sheet's.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Its name.
    pub name: String,
    /// The axis' value and what is estimated there, SI.
    pub points: Vec<(f64, f64)>,
    /// Where it comes from.
    pub source: String,
    /// Set where it was reconstructed: what and how.
    pub reconstructed: Option<String>,
}

/// A quantity over two axes, from a prediction swept in several environments.
#[derive(Clone, Debug, PartialEq)]
pub struct Contours {
    /// The quantity.
    pub quantity: String,
    /// The job.
    pub job: String,
    /// Horizontal and vertical axis: inputs, or quantities of the job.
    pub over: [Coordinate; 2],
}

/// An axis of contours.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Coordinate {
    /// An input, by its index.
    Input(usize),
    /// A quantity of the job.
    Quantity(String),
}
