//! Measurements as written.

use crate::document::{Amount, Empty, Map, NameOr, Spanned, WrittenUnit, written_choice, written_struct};

use super::uncertain::UncertainForm;

written_choice! {
    /// A measurement.
    pub enum MeasurementForm: "a measurement" {
        /// One row a phase, each in equilibrium.
        "steady" => Steady(Box<SteadyForm>),
        /// One row an instant.
        "transient" => Transient(Box<TransientForm>),
    }
}

impl MeasurementForm {
    /// The sensors, those that are left out among them.
    pub fn sensors(&self) -> &Map<SensorForm> {
        match self {
            Self::Steady(form) => &form.sensors,
            Self::Transient(form) => &form.sensors,
        }
    }
}

written_struct! {
    /// Steady phases, from a table of phases or from windows of time series.
    pub struct SteadyForm: "a steady measurement" {
        /// Description, for the report.
        optional description: String,
        /// CSV within the study: `phase` first, then `NAME [unit]` of inputs and sensors.
        optional file: Spanned<String>,
        /// Instead of `file`: a window of a time series for each phase.
        optional windows: Map<WindowForm>,
        /// The sensors, each a column.
        required sensors: Map<SensorForm>,
        /// Phases kept from every fit.
        optional held_out: HeldOutForm,
        /// Phases and sensors that are left out, each with the reason.
        default(Map::default()) ignore: Map<NameOr<IgnoredIntervalForm>>,
        /// Where a file lies that is not in the repository.
        optional pinned: PinForm,
        /// Constant values of inputs without a column; the others keep their nominal value, with a warning.
        default(Map::default()) inputs: Map<Amount>,
        /// Columns with other headers or units.
        default(Map::default()) columns: Map<ColumnForm>,
        /// The character between cells; `,` where it is left out.
        optional separator: Spanned<String>,
    }
}

written_struct! {
    /// A transient.
    pub struct TransientForm: "a transient measurement" {
        /// Description, for the report.
        optional description: String,
        /// CSV within the study: `time [s]` first, then `NAME [unit]` of inputs and sensors.
        required file: Spanned<String>,
        /// Date and time at which the file's time is 0, such as `2026-03-14T06:00:00`, for people: what sets in at a date is then
        /// stated with its date and time too.
        optional time_zero: Spanned<String>,
        /// How it begins.
        required initial: InitialForm,
        /// Longest time between two rows. Where they lie farther apart, the transient begins anew.
        optional max_gap: Spanned<Amount>,
        /// Inputs that are constant from each row to the next; the others are linear between rows.
        default(Vec::new()) hold: Vec<Spanned<String>>,
        /// Constant values of inputs without a column; the others keep their nominal value, with a warning.
        default(Map::default()) inputs: Map<Amount>,
        /// The sensors, each a column.
        required sensors: Map<SensorForm>,
        /// Rows kept from every fit.
        optional held_out: HeldOutForm,
        /// Sensors that are left out, each with the reason, and named stretches of time.
        default(Map::default()) ignore: Map<NameOr<IgnoredIntervalForm>>,
        /// Where a file lies that is not in the repository.
        optional pinned: PinForm,
        /// Columns with other headers or units.
        default(Map::default()) columns: Map<ColumnForm>,
        /// The character between cells; `,` where it is left out.
        optional separator: Spanned<String>,
    }
}

written_struct! {
    /// A window of a time series that stands for a steady phase.
    pub struct WindowForm: "a window of a time series" {
        /// CSV within the study, `time [s]` first.
        required file: Spanned<String>,
        /// First instant; the file's first where it is left out.
        optional from: Amount,
        /// Last instant; the file's last where it is left out.
        optional to: Amount,
        /// Constant values of inputs without a column, over those of the measurement.
        default(Map::default()) inputs: Map<Amount>,
    }
}

written_struct! {
    /// A sensor: what it measures and how well.
    pub struct SensorForm: "a sensor" {
        /// The quantity; a node's name means its temperature.
        required measures: Spanned<String>,
        /// Standard deviation of the noise.
        optional sigma: UncertainForm,
        /// Additive error.
        optional bias: UncertainForm,
        /// Time constant.
        optional lag: UncertainForm,
        /// Time by which the clock of its rows is behind that of the inputs; below 0: ahead.
        optional clock_behind: UncertainForm,
        /// Correlation time of the noise; white where it is left out.
        optional correlation_time: UncertainForm,
        /// Standard deviation of white noise beside the correlated noise; none where it is left out.
        optional white: UncertainForm,
        /// Description, for the report.
        optional description: String,
    }
}

written_choice! {
    /// What is kept from every fit.
    pub enum HeldOutForm: "what is held out" {
        /// Phases of a steady measurement, by name.
        "phases" => Phases(Vec<Spanned<String>>),
        /// Stretches of time of a transient.
        "intervals" => Intervals(Vec<Spanned<IntervalForm>>),
        /// All of it.
        "all" => All(Empty),
    }
}

written_struct! {
    /// A stretch of time, both ends included.
    pub struct IntervalForm: "a stretch of time" {
        /// First instant; the first row where it is left out.
        optional from: Amount,
        /// Last instant; the last row where it is left out.
        optional to: Amount,
    }
}

written_struct! {
    /// A stretch of time that is left out.
    pub struct IgnoredIntervalForm: "a stretch of time with `because`" {
        /// First instant; the first row where it is left out.
        optional from: Amount,
        /// Last instant; the last row where it is left out.
        optional to: Amount,
        /// Why.
        required because: Spanned<String>,
    }
}

written_choice! {
    /// How a transient begins.
    pub enum InitialForm: "the start of a transient" {
        /// Temperatures by node; `all` stands for those not named.
        "temperatures" => Temperatures(Map<UncertainForm>),
        /// Nodes with sensors at their first readings, the others in balance with them.
        "measured" => Measured(Box<MeasuredStartForm>),
        /// The steady state at the first row's inputs.
        "steady" => Steady(Empty),
        /// The periodic state of the inputs' cycle.
        "periodic" => Periodic(Empty),
    }
}

written_struct! {
    /// A start at the first readings.
    pub struct MeasuredStartForm: "a start at the first readings" {
        /// How many rows, from the first on, a reading is the mean of; 1 where neither this nor `over` is there.
        optional rows: Spanned<u64>,
        /// Instead of `rows`: the time from the first row on that a reading is the mean over.
        optional over: Amount,
        /// Temperatures of nodes that are known otherwise, each a value or a prior.
        default(Map::default()) temperatures: Map<UncertainForm>,
        /// Where the nodes without a reading are expected to begin; `{"balance": {}}` where it is left out.
        optional others: OtherNodesForm,
        /// Standard deviation of the starts of nodes that store heat and have no reading, about where they are expected: half
        /// of the range of the start temperatures where it is left out; with 0 they are not fitted.
        optional others_sd: Amount,
    }
}

written_choice! {
    /// Where nodes without a reading are expected to begin.
    pub enum OtherNodesForm: "where nodes without a reading begin" {
        /// In balance with the readings and the first row's inputs.
        "balance" => Balance(Empty),
        /// At the mean of the nodes with readings that are the fewest elements away.
        "nearest" => Nearest(Empty),
    }
}

written_struct! {
    /// A column whose header is not `NAME [unit]`.
    pub struct ColumnForm: "a column" {
        /// The header as it stands in the file; `NAME` where it is left out.
        optional header: Spanned<String>,
        /// The unit of the cells; the header's in brackets where it is left out.
        optional unit: WrittenUnit,
    }
}

written_struct! {
    /// A file that is known by its hash.
    pub struct PinForm: "a pinned file" {
        /// SHA-256 of the bytes, 64 hexadecimal digits.
        required sha256: Spanned<String>,
        /// Size in bytes.
        optional bytes: u64,
        /// Where it can be had, https.
        optional origin: Spanned<String>,
        /// Its licence.
        optional licence: String,
    }
}
