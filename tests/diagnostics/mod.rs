//! Wrong input: the message, at its place.
