//! The thermal network: model, compiled network, steady and transient solutions, exact derivatives.

mod balance;
pub mod batch;
mod batch_tangent;
pub mod clock;
mod connectivity;
pub mod element;
mod equations;
pub mod external;
mod external_slopes;
mod fault;
pub mod identity;
pub mod lanes_lu;
mod linear;
pub mod model;
pub mod network;
pub mod newton;
mod size;
pub mod steady;
pub mod tangent;
pub mod transient;

pub use balance::{HeatBalance, NodeHeat};
pub use batch::{Batch, LANES, SampleBatch};
pub use clock::{Clock, Clocks};
pub use connectivity::isolated_nodes_beside;
pub use external::{Derivatives, Evaluator, External, Fault, Point, SlopesAt};
pub use model::{Input, Limits, Model, Node, NodeKind, Parameter, Quantity, QuantityValue};
pub use network::{Network, NetworkError, Workspace};
pub use newton::SteadyStats;
pub use size::Size;
pub use steady::{Start, SteadyError};
pub use tangent::UnsolvedError;
pub use transient::{
    InitialState, InputColumn, InputTable, Transient, TransientError, TransientOptions, TransientRequest,
    TransientStats,
};
