mod adaptation;
mod metric;
mod student;
