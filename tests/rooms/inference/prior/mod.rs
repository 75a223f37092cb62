mod joint_prior;
mod score;
mod transform;
mod triangular_transport;
