//! Priors: unconstrained coordinates of one parameter (`transform`), normal scores (`score`), densities of several that draws
//! describe (`joint_prior`), a triangular map that makes such a density normal (`triangular_transport`).

pub mod joint_prior;
pub mod score;
pub mod transform;
pub mod triangular_transport;
