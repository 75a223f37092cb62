mod deviation;
mod readings;
mod stretch;
mod tuned;
mod view;
