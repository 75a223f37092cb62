mod absolute_error;
mod between_rows;
mod dead;
mod dialect;
mod instant;
mod map_template;
mod proposal;
