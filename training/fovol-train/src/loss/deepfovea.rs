//! The losses of DeepFovea (Kaplanyan et al. 2019), which FoVolNet is compared with.

/// The weights of the first frames of a clip in DeepFovea's own graph; later frames count 1.
pub const FRAME_WEIGHTS: [f64; 10] = [1e-5, 5e-5, 1e-4, 5e-4, 1e-3, 5e-3, 0.01, 0.05, 0.1, 0.5];
