mod between_rows;
mod dialect;
mod instant;
mod map_template;
mod proposal;
