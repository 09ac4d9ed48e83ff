//! How close one picture or clip is to another.
