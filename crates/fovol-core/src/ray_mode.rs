/// Values along a ray that its pixel shows.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum RayMode {
    /// All of them, composited from front to back and lit.
    #[default]
    Composite,
    /// The greatest, by colour and opacity of the transfer function: maximum intensity projection.
    Mip,
    /// The least, in the same way.
    Minip,
    /// Their mean, in the same way.
    Average,
    /// The surface where the ray first crosses this display value, 0…1. It is opaque, has the colour of the transfer
    /// function at the value, is shaded by the gradient, and casts shadows.
    Isosurface(f32),
}

impl RayMode {
    /// Whether one value along the ray is shown, without light.
    pub fn is_projection(self) -> bool {
        matches!(self, Self::Mip | Self::Minip | Self::Average)
    }
}
