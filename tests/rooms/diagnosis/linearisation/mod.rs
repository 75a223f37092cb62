mod bounded;
mod signature;
