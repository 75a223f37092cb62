mod evidence;
mod exchange;
mod held_out;
mod other_noise;
mod size;
