//! Special functions of statistics: normal, gamma and beta families.

mod normal;

pub use normal::{
    ln_normal_cdf, ln_normal_density, ln_normal_interval, normal_cdf, normal_density, normal_quantile,
    normal_quantile_centred, normal_quantile_of_ln,
};
