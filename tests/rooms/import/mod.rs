mod logger;
mod name;
mod parts;
mod reader;
mod resolution;
