//! Settings of `discrepancy` as written.

use crate::document::prior::{LognormalForm, PosteriorForm};
use crate::document::{Map, NameOr, Spanned, written_choice, written_struct, written_words};

written_struct! {
    /// Settings of `discrepancy`.
    pub struct DiscrepancyForm: "settings of `discrepancy`" {
        /// Steady measurements; all of the pass where they are left out.
        optional data: Vec<Spanned<String>>,
        /// The `calibrate` job after which residuals are taken: one of this pass by its name, or `{"pass": ..., "job": ...}`. The
        /// pass's only one where it is left out.
        optional from: NameOr<Spanned<PosteriorForm>>,
        /// Sensors; all with five readings or more where they are left out.
        optional sensors: Vec<Spanned<String>>,
        /// Inputs that the discrepancy may depend on; all that vary over the phases where they are left out.
        optional inputs: Vec<Spanned<String>>,
        /// Covariance, `squared-exponential` where it is left out.
        optional kernel: KernelForm,
        /// Trend of the Gaussian process, `constant` where it is left out (in the mode `joint` `none`).
        optional trend: TrendForm,
        /// The law of the discrepancy, `automatic` where it is left out: the simplest that predicts readings left out about as
        /// well as the best (in the mode `joint` a Gaussian process).
        optional law: Spanned<LawForm>,
        /// Whether hyperparameters are drawn from their posterior or those of the highest marginal likelihood, `sampled` where
        /// it is left out.
        optional hyperparameters: Spanned<HyperparametersForm>,
        /// What is known of the discrepancy beforehand; wide priors by the size of the residuals where it is left out.
        optional priors: Spanned<BeforehandForm>,
        /// Draws of the calibration over which residuals are taken (in the mode `joint` draws that are kept), 200 where it is left
        /// out.
        optional draws: Spanned<u64>,
        /// `modular` where it is left out: after the calibration, whose posterior stays as it is. `joint`: together with its
        /// parameters.
        optional mode: Spanned<ModeForm>,
    }
}

written_struct! {
    /// What is known of a discrepancy beforehand.
    pub struct BeforehandForm: "priors of a discrepancy" {
        /// Standard deviation of the smooth part, in the unit of the sensors, differences of temperatures in K.
        optional standard_deviation: HyperpriorForm,
        /// Length by input, in the unit of the input.
        optional lengths: Map<HyperpriorForm>,
        /// Standard deviation of the scatter, as that of the smooth part.
        optional scatter: HyperpriorForm,
    }
}

written_choice! {
    /// What is known of a standard deviation or a length; bare numbers are in SI.
    pub enum HyperpriorForm: "a prior" {
        /// Normal in the logarithm.
        "lognormal" => Lognormal(Spanned<LognormalForm>),
    }
}

written_words! {
    /// Covariance of a Gaussian process.
    pub enum KernelForm: "a covariance" {
        /// Infinitely smooth.
        "squared-exponential" => SquaredExponential,
        /// Twice differentiable.
        "matern-5/2" => Matern52,
    }
}

written_words! {
    /// Trend of a Gaussian process.
    pub enum TrendForm: "a trend" {
        /// None: far from the data nothing is added.
        "none" => None,
        /// A constant.
        "constant" => Constant,
        /// A constant and a slope in each input.
        "linear" => Linear,
    }
}

written_words! {
    /// Law of a discrepancy.
    pub enum LawForm: "a law" {
        /// Chosen sensor by sensor.
        "automatic" => Automatic,
        /// No discrepancy.
        "none" => None,
        /// The same everywhere.
        "constant" => Constant,
        /// A constant and scatter that no input explains.
        "residual-law" => ResidualLaw,
        /// A smooth function of the inputs, and scatter.
        "gaussian-process" => GaussianProcess,
    }
}

written_words! {
    /// How hyperparameters are had.
    pub enum HyperparametersForm: "hyperparameters" {
        /// Draws of their posterior.
        "sampled" => Sampled,
        /// Those of the highest marginal likelihood.
        "maximum" => Maximum,
    }
}

written_words! {
    /// Whether parameters and discrepancy are inferred one after the other or together.
    pub enum ModeForm: "a mode" {
        /// One after the other.
        "modular" => Modular,
        /// Together.
        "joint" => Joint,
    }
}
