mod distribution;
mod points;
mod sobol;
mod stream;
