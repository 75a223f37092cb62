mod gaps;
mod parts;
