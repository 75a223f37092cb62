//! The first law over a whole network: what sources give is stored or flows into boundaries.

use super::equations::segment;
use super::network::{Network, Workspace};

/// Heat balance of a network at an instant.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct HeatBalance {
    /// Heat of each element that is a source (loads, heaters, a cooler's electrical power): its index in the model's
    /// list and its power, W.
    pub sources: Vec<(usize, f64)>,
    /// Their sum, W.
    pub source_w: f64,
    /// Heat into each boundary that an element touches: node index and W.
    pub into_boundaries: Vec<(usize, f64)>,
    /// Their sum, W.
    pub boundary_w: f64,
    /// Net heat into all other nodes, stored there, W; 0 in a steady state.
    pub stored_w: f64,
}

/// Net heat of a node at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeHeat {
    /// Its index in the model's list.
    pub node: usize,
    /// Net heat into it, W.
    pub heat_w: f64,
    /// Its heat capacity, J/K; `None` for a node without.
    pub capacity_j_per_k: Option<f64>,
}

impl Network {
    /// Puts temperatures of all nodes in place, K, for asking what follows from them (boundaries' entries are ignored:
    /// they follow from the inputs).
    pub fn set_temperatures(&self, workspace: &mut Workspace, temperatures: &[f64]) {
        self.refresh(workspace);
        let first = self.steady.temperatures().start;
        for (position, &node) in self.steady.unknowns.iter().enumerate() {
            workspace.temperatures[node] = temperatures[node];
            workspace.state.file[first + position] = temperatures[node];
        }
        workspace.solved = false;
    }

    /// Net heat into every node that is no boundary, at the present temperatures.
    pub fn node_heat(&self, workspace: &mut Workspace) -> Vec<NodeHeat> {
        let file = &mut workspace.state.file;
        self.steady.program.run(segment::RESIDUAL, file);
        self.steady.program.run(segment::CAPACITY, file);
        let node_heat = |(row, &node): (usize, &usize)| NodeHeat {
            node,
            heat_w: file[self.steady.residual[row].index()],
            capacity_j_per_k: self.steady.capacity[row].map(|register| file[register.index()]),
        };
        self.steady.unknowns.iter().enumerate().map(node_heat).collect()
    }

    /// How fast the net heat out of a node rises with its own temperature, at the present temperatures, W/K: the sum of
    /// the conductances that meet there, radiation linearised. By node of the model; 0 for boundaries.
    pub fn node_conductances(&self, workspace: &mut Workspace) -> Vec<f64> {
        let file = &mut workspace.state.file;
        self.steady.program.run(segment::RESIDUAL, file);
        self.steady.program.run(segment::JACOBIAN, file);
        let mut conductances = vec![0.0; self.nodes()];
        for entry in self.steady.jacobian.iter().filter(|entry| entry.row == entry.column) {
            conductances[self.steady.unknowns[entry.row]] = -file[entry.register.index()];
        }
        conductances
    }

    /// The heat balance of the present temperatures.
    pub fn heat_balance(&self, workspace: &mut Workspace) -> HeatBalance {
        let file = &mut workspace.state.file;
        self.steady.program.run(segment::RESIDUAL, file);
        self.steady.program.run(segment::BALANCE, file);
        let read = |list: &[(usize, crate::expression::Register)]| -> Vec<(usize, f64)> {
            list.iter().map(|&(index, register)| (index, file[register.index()])).collect()
        };
        let sources = read(&self.steady.sources);
        let into_boundaries = read(&self.steady.into_boundary);
        HeatBalance {
            source_w: sources.iter().map(|s| s.1).sum(),
            boundary_w: into_boundaries.iter().map(|b| b.1).sum(),
            stored_w: self.steady.residual.iter().map(|r| file[r.index()]).sum(),
            sources,
            into_boundaries,
        }
    }
}
