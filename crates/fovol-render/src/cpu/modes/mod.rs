//! Other pictures than composited ones: greatest, least and mean values along rays, and isosurfaces.

mod isosurface;
mod march;
mod projected;
mod projection;

pub use isosurface::IsosurfaceKernel;
pub use projection::{Projection, ProjectionKernel};
