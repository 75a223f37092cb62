mod bounded;
mod signature;
mod threshold_levels;
