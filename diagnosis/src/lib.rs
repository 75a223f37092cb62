//! Which effects a model lacks: the rooms `diagnosis`, and above it `twin`, cases whose truth is known.
//!
//! Networks, likelihoods and samplers are in the crate `bmv-core` below; what is here screens, fits, weighs and words.

pub mod diagnosis;
pub mod twin;

use bmv_core::{document, effect, expression, inference, math, measurement, random, statistics, thermal, watch};
