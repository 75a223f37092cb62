mod coordinates;
mod estimate;
mod linear;
mod mixture;
mod nested;
mod search;
mod separation;
