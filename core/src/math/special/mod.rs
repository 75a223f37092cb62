//! Special functions of statistics: normal, gamma and beta families.

pub mod beta;
pub mod gamma;
pub mod normal;
pub mod weighted_chi_square;

pub use beta::{beta_quantile, beta_regularised, fisher_f_cdf, fisher_f_sf, student_t_cdf, student_t_quantile};
pub use gamma::{chi_square_cdf, chi_square_quantile, chi_square_sf, gamma_p, gamma_q};
pub use normal::{
    ln_normal_cdf, ln_normal_density, ln_normal_interval, normal_cdf, normal_density, normal_quantile,
    normal_quantile_centred, normal_quantile_of_ln,
};
pub use weighted_chi_square::{weighted_chi_square_sf, weighted_chi_square_upper};
