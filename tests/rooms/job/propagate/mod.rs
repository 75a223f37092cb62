mod block;
mod reached;
mod view;
