mod dialect;
mod instant;
mod proposal;
