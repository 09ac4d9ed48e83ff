//! How weights follow gradients.
