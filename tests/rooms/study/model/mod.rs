mod implied_groups;
mod resolve;
