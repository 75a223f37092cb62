mod between_rows;
mod dialect;
mod instant;
mod proposal;
