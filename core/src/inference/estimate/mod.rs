//! Estimates about a point. `natural` coordinates, `optimise` (descents between bounds), `point_estimate` (the most probable
//! point and its evidence: `laplace`, `box_probability`, `truncated_moments`), `identifiability` (what the data leave open),
//! `informed` (how much they say beyond the prior).

pub mod box_probability;
pub mod identifiability;
pub mod informed;
pub mod laplace;
pub mod natural;
pub mod optimise;
pub mod point_estimate;
pub mod truncated_moments;
