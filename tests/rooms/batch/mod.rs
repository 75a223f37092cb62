mod export;
mod live;
mod memory;
mod next_pass;
mod print;
