//! Cooperative matrices: products that the threads of a subgroup make together, on units made for that ("tensor cores").

use std::fmt;
use wgpu::{CooperativeMatrixProperties, CooperativeScalarType, Features};

/// The environment variable by which cooperative matrices are done without, with the value `off`.
pub const MATRICES_VARIABLE: &str = "FOVOLNET_GPU_MATRICES";

/// What shaders need for them.
const NEEDED: Features =
    Features::EXPERIMENTAL_COOPERATIVE_MATRIX.union(Features::SHADER_F16).union(Features::SUBGROUP);

/// Square cooperative matrices of halves whose products are added up in f32.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Matrices {
    edge: u32,
    subgroup: (u32, u32),
}

impl Matrices {
    /// Those of `edge` rows and columns, 8 or 16, of a device whose subgroups have from the one to the other number of threads:
    /// for devices that somebody else opened. [`Self::of`] finds out.
    pub const fn new(edge: u32, subgroup: (u32, u32)) -> Self {
        Self { edge, subgroup }
    }

    /// The largest that `adapter` offers, if any.
    pub fn of(adapter: &wgpu::Adapter) -> Option<Self> {
        let info = adapter.get_info();
        let edge = largest(&adapter.cooperative_matrix_properties())?;
        let (least, most) = (info.subgroup_min_size, info.subgroup_max_size);
        let has_all = adapter.features().contains(NEEDED) && 0 < least && least <= most;
        has_all.then_some(Self::new(edge, (least, most)))
    }

    /// Those of [`Self::of`], unless [`MATRICES_VARIABLE`] says `off`.
    pub fn wanted_of(adapter: &wgpu::Adapter) -> Option<Self> {
        match std::env::var(MATRICES_VARIABLE) {
            Ok(text) if text.trim() == "off" => None,
            _ => Self::of(adapter),
        }
    }

    /// Their rows, which are as many as their columns: 8 or 16.
    pub fn edge(&self) -> u32 {
        self.edge
    }

    /// The fewest and the most threads of a subgroup.
    pub fn subgroup(&self) -> (u32, u32) {
        self.subgroup
    }

    /// The features with which a device has to be opened where there are `matrices`.
    pub fn features(matrices: Option<Self>) -> Features {
        matrices.map_or(Features::empty(), |_| NEEDED)
    }

    /// The consent that a device has to be opened with where there are `matrices`: wgpu calls them an experiment.
    pub fn experiments(matrices: Option<Self>) -> wgpu::ExperimentalFeatures {
        match matrices {
            None => wgpu::ExperimentalFeatures::disabled(),
            // SAFETY: shaders that use them are this project's own; they load and store within arrays whose length they know.
            Some(_) => unsafe { wgpu::ExperimentalFeatures::enabled() },
        }
    }
}

impl fmt::Display for Matrices {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{0}x{0} f16", self.edge)
    }
}

/// The largest edge among `offers` of squares of halves that are added up in f32.
fn largest(offers: &[CooperativeMatrixProperties]) -> Option<u32> {
    let is_square = |offer: &&CooperativeMatrixProperties| {
        offer.m_size == offer.n_size && offer.n_size == offer.k_size && [8, 16].contains(&offer.m_size)
    };
    let is_mixed = |offer: &&CooperativeMatrixProperties| {
        offer.ab_type == CooperativeScalarType::F16 && offer.cr_type == CooperativeScalarType::F32
    };
    offers.iter().filter(is_square).filter(is_mixed).map(|offer| offer.m_size).max()
}

#[cfg(test)]
mod tests {
    use super::*;
    use CooperativeScalarType::{F16, F32};

    fn offer(sizes: [u32; 3], types: [CooperativeScalarType; 2]) -> CooperativeMatrixProperties {
        let ([m_size, n_size, k_size], [ab_type, cr_type]) = (sizes, types);
        CooperativeMatrixProperties {
            m_size,
            n_size,
            k_size,
            ab_type,
            cr_type,
            saturating_accumulation: false,
        }
    }

    #[test]
    fn squares_of_halves_added_up_in_f32_are_taken() {
        let few = [offer([8; 3], [F16, F16]), offer([16; 3], [F32, F32]), offer([16, 8, 16], [F16, F32])];
        assert_eq!(largest(&few), None);
        let more = [&few[..], &[offer([8; 3], [F16, F32])]].concat();
        assert_eq!(largest(&more), Some(8));
        let all = [&[offer([16; 3], [F16, F32])], &more[..]].concat();
        assert_eq!(largest(&all), Some(16));
    }
}
