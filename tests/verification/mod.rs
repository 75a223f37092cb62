//! Numerics against analytic results, published values and golden numbers.
