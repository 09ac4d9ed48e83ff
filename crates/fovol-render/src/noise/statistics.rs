//! Checks of noise.
