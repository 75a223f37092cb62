mod arrangement;
mod places;
