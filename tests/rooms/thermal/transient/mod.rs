mod inputs;
mod tableau;
