mod candidate;
mod catalogue;
mod law;
mod parameter;
mod same_law;
mod thermometers;
