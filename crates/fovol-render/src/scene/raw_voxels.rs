use fovol_core::{Endian, Volume, Voxel};

/// Random access to the first components of a volume.
pub(super) struct RawVoxels<'a, T> {
    bytes: &'a [u8],
    stride: usize,
    dims: [usize; 3],
    endian: Endian,
    kind: std::marker::PhantomData<T>,
}

impl<'a, T: Voxel> RawVoxels<'a, T> {
    /// The voxels of `volume`, whose type is `T`.
    pub(super) fn new(volume: &'a Volume) -> Self {
        Self {
            bytes: volume.data(),
            stride: volume.components() * size_of::<T>(),
            dims: volume.grid().dims(),
            endian: volume.endian(),
            kind: std::marker::PhantomData,
        }
    }

    #[inline(always)]
    fn at(&self, [x, y, z]: [usize; 3]) -> usize {
        ((z * self.dims[1] + y) * self.dims[0] + x) * self.stride
    }

    /// The first component of `voxel` as it is stored.
    #[inline(always)]
    pub(super) fn get(&self, voxel: [usize; 3]) -> T {
        let at = self.at(voxel);
        T::decode(&self.bytes[at..at + size_of::<T>()], self.endian)
    }
}
