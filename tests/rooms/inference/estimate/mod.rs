mod box_probability;
mod laplace;
mod optimise;
mod truncated_moments;
