//! Memory layout of bricks.

/// Edge of a brick in interpolation cells. A brick stores one voxel more along each axis, so that the
/// eight corners of any cell lie in one brick.
pub const BRICK: usize = 8;
/// Voxels along the edge of a stored brick.
const EDGE: usize = BRICK + 1;
/// Elements after the last brick: wide loads may read past the last voxel.
const PADDING: usize = 16;

/// Where voxel (x, y, z) of a brick grid lies: a sum of one term per axis.
///
/// With i the voxel's index along an axis and i/8 its brick, each term is i·`unit` + (i/8)·`jump`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BrickLayout {
    /// Voxels along x, y, z.
    pub dims: [usize; 3],
    /// Elements between neighbours inside a brick, along x, y, z.
    pub unit: [usize; 3],
    /// Elements added per brick boundary crossed along x, y, z, on top of `unit`.
    pub jump: [usize; 3],
    bricks: [usize; 3],
    /// Stored elements of a brick along x, y, z.
    pub(super) edges: [usize; 3],
    /// Stored elements per brick, a multiple of 16.
    pub(super) stride: usize,
}

impl BrickLayout {
    /// One element a voxel, corners shared between bricks stored in each: 9³ elements to a brick.
    pub fn voxels(dims: [usize; 3]) -> Self {
        Self::new(dims, [EDGE; 3])
    }

    /// Elements that hold the neighbours along y and z too: 9·8·8 elements to a brick.
    pub fn corners(dims: [usize; 3]) -> Self {
        Self::new(dims, [EDGE, BRICK, BRICK])
    }

    fn new(dims: [usize; 3], edges: [usize; 3]) -> Self {
        // Cells run from voxel 0 to dims − 1; the last voxel starts a (degenerate) cell of its own.
        let bricks = dims.map(|d| d.div_ceil(BRICK));
        let stride = edges.iter().product::<usize>().next_multiple_of(16);
        let unit = [1, edges[0], edges[0] * edges[1]];
        let pitch = [stride, stride * bricks[0], stride * bricks[0] * bricks[1]];
        let jump = std::array::from_fn(|a| pitch[a] - BRICK * unit[a]);
        Self { dims, unit, jump, bricks, edges, stride }
    }

    /// Bricks along x, y, z.
    pub fn bricks(&self) -> [usize; 3] {
        self.bricks
    }

    /// The element that holds voxel (x, y, z) as the low corner of its cell; the other corners are
    /// `unit` further along each axis.
    #[inline]
    pub fn index(&self, voxel: [usize; 3]) -> usize {
        (0..3).map(|a| voxel[a] * self.unit[a] + voxel[a] / BRICK * self.jump[a]).sum()
    }

    /// Stored elements, padding included.
    pub fn elements(&self) -> usize {
        self.bricks.iter().product::<usize>() * self.stride + PADDING
    }
}
