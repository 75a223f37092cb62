mod block;
mod monte_carlo;
mod predictive;
mod summary;
