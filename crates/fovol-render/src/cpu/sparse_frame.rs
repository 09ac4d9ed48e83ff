use crate::scene::RayResult;
use fovol_core::{SampleList, SparseFrame};

/// Sparse frame of the pixels of `list` with their ray results `marched`.
///
/// # Panics
/// If there is not one result for every pixel.
pub fn sparse_frame(list: SampleList, marched: &[RayResult]) -> SparseFrame {
    let (colours, depths) = marched.iter().map(|result| (result.colour, result.depth)).unzip();
    SparseFrame::new(list, colours, depths)
}
