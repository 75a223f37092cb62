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
        let k = sensors.len();
        let row = |sensor: usize| {
            let quantity = sensors[sensor].quantity;
            &tangent[quantity * columns..(quantity + 1) * columns]
        };
        let mut covariance = vec![0.0; k * k];
        for a in 0..k {
            for b in 0..k {
                let terms = row(a).iter().zip(row(b)).zip(&self.sigmas);
                covariance[a * k + b] = terms.map(|((x, y), sigma)| x * y * sigma * sigma).sum();
            }
        }
        Some(covariance)
    }
}
