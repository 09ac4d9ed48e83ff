//! Reconstruction of full frames from sparse ones.
