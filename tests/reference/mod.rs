//! Results against stored references made by other programs.
