mod share;
mod stop;
