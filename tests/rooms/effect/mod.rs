mod candidate;
mod catalogue;
mod law;
mod parameter;
