//! Cooperative matrices: matrix products that the threads of a subgroup compute together, on tensor cores.

use std::fmt;
use wgpu::{CooperativeMatrixProperties, CooperativeScalarType, Features};

/// Environment variable that switches cooperative matrices off, with the value `off`.
pub const MATRICES_VARIABLE: &str = "FOVOLNET_GPU_MATRICES";

/// Device features that shaders with cooperative matrices need.
const NEEDED: Features =
    Features::EXPERIMENTAL_COOPERATIVE_MATRIX.union(Features::SHADER_F16).union(Features::SUBGROUP);

/// Square cooperative matrices: f16 operands, products accumulated in f32.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Matrices {
    edge: u32,
    subgroup: (u32, u32),
}

impl Matrices {
    /// Describes matrices of `edge` × `edge` elements, `edge` being 8 or 16. `subgroup` is the smallest and the
    /// largest subgroup of the device, in threads. For devices that another program opened; [`Self::of`] asks an
    /// adapter.
    pub const fn new(edge: u32, subgroup: (u32, u32)) -> Self {
        Self { edge, subgroup }
    }

    /// Returns the largest matrices that `adapter` offers, if any.
    pub fn of(adapter: &wgpu::Adapter) -> Option<Self> {
        let info = adapter.get_info();
        let edge = largest(&adapter.cooperative_matrix_properties())?;
        let (least, most) = (info.subgroup_min_size, info.subgroup_max_size);
        let has_all = adapter.features().contains(NEEDED) && 0 < least && least <= most;
        has_all.then_some(Self::new(edge, (least, most)))
    }

    /// Returns [`Self::of`], or `None` if [`MATRICES_VARIABLE`] says `off`.
    pub fn wanted_of(adapter: &wgpu::Adapter) -> Option<Self> {
        match std::env::var(MATRICES_VARIABLE) {
            Ok(text) if text.trim() == "off" => None,
            _ => Self::of(adapter),
        }
    }

    /// Number of rows, equal to the number of columns: 8 or 16.
    pub fn edge(&self) -> u32 {
        self.edge
    }

    /// Smallest and largest number of threads in a subgroup.
    pub fn subgroup(&self) -> (u32, u32) {
        self.subgroup
    }

    /// Features with which a device has to be opened to use `matrices`; none for `None`.
    pub fn features(matrices: Option<Self>) -> Features {
        matrices.map_or(Features::empty(), |_| NEEDED)
    }

    /// Consent to experimental features with which a device has to be opened to use `matrices`. wgpu calls
    /// cooperative matrices an experiment.
    pub fn experiments(matrices: Option<Self>) -> wgpu::ExperimentalFeatures {
        match matrices {
            None => wgpu::ExperimentalFeatures::disabled(),
            // SAFETY: only this project's own shaders use them, and these load and store within arrays of known
            // length.
            Some(_) => unsafe { wgpu::ExperimentalFeatures::enabled() },
        }
    }
}

impl fmt::Display for Matrices {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{0}x{0} f16", self.edge)
    }
}

/// Returns the largest edge among `offers` of square matrices with f16 operands and f32 accumulators.
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
