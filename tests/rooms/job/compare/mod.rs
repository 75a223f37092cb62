mod deviation;
mod stretch;
mod tuned;
mod view;
