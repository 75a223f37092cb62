mod axis;
mod bars;
mod canvas;
mod contours;
mod heat_map;
mod layout;
mod network;
mod sheet;
