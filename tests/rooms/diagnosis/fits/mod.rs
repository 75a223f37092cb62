mod controlled_heat;
mod evidence;
mod exchange;
mod held_level;
mod held_out;
mod other_noise;
mod size;
