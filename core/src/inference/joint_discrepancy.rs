//! Parameters and discrepancies inferred together (Kennedy & O'Hagan 2001, J. R. Statist. Soc. B 63, 425, section 4):
//! `z = f(theta) + delta(x) + noise` with a Gaussian process `delta` a sensor.
//!
//! `ln p(z | theta, phi) = sum ln N(z - f(theta); trend, K(phi) + S)` over the sensors with a process, trends integrated out,
//! and the likelihood as it is for all other readings. Its slopes with the parameters are `-J' P r` with the slopes `J` of the
//! residuals `r` and the precision `P` of `gaussian_process::marginal`.
//!
//! What these data cannot tell apart is decided by the priors of the hyperparameters (Brynjarsdottir & O'Hagan 2014, Inverse
//! Problems 30, 114007).

use crate::inference::gaussian_process::marginal::{Factored, factored_with_gradient};
use crate::inference::gaussian_process::{Form, GaussianProcessError, Training};
use crate::inference::likelihood::HALF_LN_TAU;
use crate::inference::target::{LeastSquares, Rejected, Target};
use crate::math::functions::ln;
use crate::random::Distribution;

/// The discrepancy of a sensor.
#[derive(Clone, Debug)]
pub struct SensorProcess {
    /// Name of the sensor.
    pub sensor: String,
    /// Places of its residuals in the target.
    pub rows: Vec<usize>,
    /// Standard deviations of their noise, which is independent from reading to reading and known.
    pub sds: Vec<f64>,
    /// Points and variances of the noise; the values are not used.
    pub training: Training,
    /// The parts of the process.
    pub form: Form,
    /// Priors of its hyperparameters (logarithms, [`Form::hyperparameters`]).
    pub priors: Vec<Distribution>,
}

/// A target whose residuals of some sensors hold a discrepancy. Its parameters are those of the target, then the
/// hyperparameters, process by process.
#[derive(Clone, Debug)]
pub struct JointDiscrepancy<T> {
    target: T,
    processes: Vec<SensorProcess>,
    names: Vec<String>,
    priors: Vec<Distribution>,
    /// Residuals without a discrepancy.
    alone: Vec<usize>,
    /// What the target's normalising constant holds of those with one.
    constant: f64,
}

/// Memory of one chain.
pub struct Memory<W> {
    target: W,
    residuals: Vec<f64>,
    jacobian: Vec<f64>,
    offset_gradient: Vec<f64>,
    values: Vec<f64>,
    trainings: Vec<Training>,
}

impl<T: LeastSquares> JointDiscrepancy<T> {
    /// The target with these processes, which share no residual.
    pub fn new(target: T, processes: Vec<SensorProcess>) -> Self {
        let (mut names, mut priors) = (target.names().to_vec(), target.priors().to_vec());
        let mut is_alone = vec![true; target.residual_count()];
        let mut constant = 0.0;
        for process in &processes {
            names.extend((1..=process.priors.len()).map(|k| format!("hyperparameter {k} of {}", process.sensor)));
            priors.extend_from_slice(&process.priors);
            for (&row, sd) in process.rows.iter().zip(&process.sds) {
                is_alone[row] = false;
                constant += -ln(*sd) - HALF_LN_TAU;
            }
        }
        let alone = (0..is_alone.len()).filter(|&row| is_alone[row]).collect();
        Self { target, processes, names, priors, alone, constant }
    }

    /// Number of the target's own parameters.
    pub fn own_parameters(&self) -> usize {
        self.target.dimension()
    }

    /// The hyperparameters of each process.
    pub fn hyperparameters<'p>(&self, parameters: &'p [f64]) -> Vec<&'p [f64]> {
        let mut rest = &parameters[self.own_parameters()..];
        let mut parts = Vec::new();
        for process in &self.processes {
            let (own, others) = rest.split_at(process.priors.len());
            parts.push(own);
            rest = others;
        }
        parts
    }

    /// Puts the residuals of a process, in the unit of its sensor, in place.
    fn take(process: &SensorProcess, residuals: &[f64], training: &mut Training) -> Result<(), Rejected> {
        let values: Vec<f64> = process.rows.iter().zip(&process.sds).map(|(&row, sd)| residuals[row] * sd).collect();
        training.set_values(&values).map_err(rejected)
    }

    fn of_alone(&self, residuals: &[f64]) -> f64 {
        self.alone.iter().map(|&row| residuals[row] * residuals[row]).sum()
    }
}

fn rejected(error: GaussianProcessError) -> Rejected {
    Rejected::new(match error {
        // Their numbers differ from point to point.
        GaussianProcessError::Number { .. } => "a residual is not a finite number".to_owned(),
        other => other.to_string(),
    })
}

impl<T: LeastSquares> Target for JointDiscrepancy<T> {
    type Workspace = Memory<T::Workspace>;

    fn names(&self) -> &[String] {
        &self.names
    }

    fn priors(&self) -> &[Distribution] {
        &self.priors
    }

    fn workspace(&self) -> Self::Workspace {
        let (rows, n) = (self.target.residual_count(), self.own_parameters());
        Memory {
            target: self.target.workspace(),
            residuals: vec![0.0; rows],
            jacobian: vec![0.0; rows * n],
            offset_gradient: vec![0.0; n],
            values: vec![0.0; n],
            trainings: self.processes.iter().map(|process| process.training.clone()).collect(),
        }
    }

    fn log_likelihood(&self, parameters: &[f64], memory: &mut Self::Workspace) -> Result<f64, Rejected> {
        let own = &parameters[..self.own_parameters()];
        let offset = self.target.residuals(own, &mut memory.target, &mut memory.residuals)?;
        let mut value = offset - self.constant - 0.5 * self.of_alone(&memory.residuals);
        let parts = self.hyperparameters(parameters);
        for ((process, training), part) in self.processes.iter().zip(&mut memory.trainings).zip(parts) {
            Self::take(process, &memory.residuals, training)?;
            value += Factored::new(training, &process.form, part).map_err(rejected)?.log_likelihood();
        }
        Ok(value)
    }

    fn log_likelihood_gradient(
        &self,
        parameters: &[f64],
        memory: &mut Self::Workspace,
        gradient: &mut [f64],
    ) -> Result<f64, Rejected> {
        let n = self.own_parameters();
        let Memory { target, residuals, jacobian, offset_gradient, values, trainings } = memory;
        let offset = self.target.jacobian(&parameters[..n], target, residuals, jacobian, offset_gradient)?;
        let mut value = offset - self.constant - 0.5 * self.of_alone(residuals);
        values.copy_from_slice(offset_gradient);
        let mut add = |row: usize, slope: f64| {
            let derivatives = &jacobian[row * n..(row + 1) * n];
            values.iter_mut().zip(derivatives).for_each(|(entry, derivative)| *entry += slope * derivative);
        };
        self.alone.iter().for_each(|&row| add(row, -residuals[row]));
        let mut first = n;
        let parts = self.hyperparameters(parameters);
        for ((process, training), part) in self.processes.iter().zip(trainings).zip(parts) {
            Self::take(process, residuals, training)?;
            let own = &mut gradient[first..first + part.len()];
            let factored = factored_with_gradient(training, &process.form, part, own).map_err(rejected)?;
            value += factored.log_likelihood();
            for ((&row, sd), slope) in process.rows.iter().zip(&process.sds).zip(factored.slopes_with_values()) {
                add(row, slope * sd);
            }
            first += part.len();
        }
        gradient[..n].copy_from_slice(values);
        Ok(value)
    }
}
