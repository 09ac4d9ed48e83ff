//! Foveated sparse volume rendering with reconstruction.
