//! Plots: data in, a drawing out. Nothing here knows a job or a model beyond the network's shape.
//!
//! Every plot is drawn on a canvas of fixed width in whole pixels and scaled by the page, so that the same data give
//! the same bytes everywhere. No system font is read: widths of texts are estimated. What is drawn is recorded in the same
//! pass, so that the numbers behind a drawing are those that it shows.

pub mod axis;
mod bars;
pub mod canvas;
mod chart;
pub mod contours;
pub mod heat_map;
mod history;
pub mod layout;
pub mod network;
mod pairs;
pub mod palette;
mod passes;
pub mod sheet;
mod strip;

pub use axis::Axis;
pub use bars::{Bar, bar_chart};
pub use canvas::Drawing;
pub use chart::{Along, Chart, Layer, Limit, Mark, Patch, Shade, Stroke};
pub use contours::{Contours, Node as SurfaceNode, contours};
pub use heat_map::{HeatMap, heat_map};
pub use history::{History, history};
pub use network::{Diagram, Missing, NodeShape, Path, Source, network};
pub use pairs::{PairAxis, pairs};
pub use passes::{PassCurves, pass_curves};
pub use sheet::Numbers;
pub use strip::{Strip, residual_strips};
