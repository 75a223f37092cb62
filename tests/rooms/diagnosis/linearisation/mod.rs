mod between_rows;
mod bounded;
mod signature;
mod threshold_levels;
