//! What the known errors of the inputs add to the readings of a steady phase: `F S F'`, `F` the derivatives of the
//! readings with respect to the inputs at nominal parameters, `S` the diagonal of the errors' variances.

use super::SensorPart;
use crate::thermal::{Network, Start, Workspace};

/// Inputs with known errors, and a network to differentiate by them.
#[derive(Debug)]
pub(super) struct InputErrors {
    network: Network,
    /// Standard deviation of each differentiated input, SI.
    sigmas: Vec<f64>,
}

impl InputErrors {
    /// `network` has the inputs with errors as its differentiated symbols, in the order of `sigmas`.
    pub fn new(network: Network, sigmas: Vec<f64>) -> Self {
        Self { network, sigmas }
    }

    /// Memory at these parameters.
    pub fn workspace(&self, parameters: &[f64]) -> Workspace {
        let mut workspace = self.network.workspace();
        self.network.set_parameters(&mut workspace, parameters);
        workspace
    }

    /// Covariance that they give to readings of these sensors at these inputs, SI, row by row; `None` where there is no
    /// solution or no finite derivative.
    pub fn covariance(&self, workspace: &mut Workspace, inputs: &[f64], sensors: &[SensorPart]) -> Option<Vec<f64>> {
        let columns = self.sigmas.len();
        let mut tangent = vec![0.0; self.network.quantities() * columns];
        self.network.set_inputs(workspace, inputs);
        self.network.solve_steady(workspace, Start::Default).ok()?;
        self.network.quantity_tangent(workspace, &mut tangent).ok()?;
        if tangent.iter().any(|slope| !slope.is_finite()) {
            return None;
        }
        let quantities: Vec<usize> = sensors.iter().map(|sensor| sensor.quantity).collect();
        Some(covariance_by_inputs(&tangent, &self.sigmas, &quantities))
    }
}

/// `F S F'` of readings of these quantities, row by row: `slopes` of all quantities by the inputs, and the inputs' standard
/// deviations.
pub fn covariance_by_inputs(slopes: &[f64], sigmas: &[f64], quantities: &[usize]) -> Vec<f64> {
    let row = |quantity: usize| &slopes[quantity * sigmas.len()..][..sigmas.len()];
    let mut covariance = Vec::with_capacity(quantities.len() * quantities.len());
    for &a in quantities {
        for &b in quantities {
            let terms = row(a).iter().zip(row(b)).zip(sigmas);
            covariance.push(terms.map(|((x, y), sigma)| x * y * sigma * sigma).sum());
        }
    }
    covariance
}
