mod csv;
mod npy;
