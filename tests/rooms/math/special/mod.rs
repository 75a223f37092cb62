mod beta;
mod gamma;
mod normal;
mod weighted_chi_square;
