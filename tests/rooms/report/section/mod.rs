mod margins;
mod propagation;
mod summary;
