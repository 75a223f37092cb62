mod external;
mod lanes_lu;
mod transient;
