mod changes;
mod session;
mod site;
mod state;
