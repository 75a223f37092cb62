mod fewer_rows;
mod noise;
