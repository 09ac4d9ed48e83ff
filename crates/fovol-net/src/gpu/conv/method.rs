//! Choice of the method for a convolution: cooperative matrices or plain threads.

use crate::gpu::kernel::shader::{CONV, CONV_MATRICES_8, CONV_MATRICES_16};
use crate::gpu::tensor::BLOCK;
use crate::plan::Conv;
use fovol_gpu::{Matrices, Shader};

/// Columns of pixels of a workgroup, as in shaders/convolution.wgsl.
pub const COLUMNS: u32 = 16;
/// Padding after the channels of a pixel in workgroup memory, as in shaders/conv_matrices.wgsl.
const PADDING: u32 = 8;

/// Method by which a workgroup computes its part of a convolution.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Method {
    pub shader: Shader,
    /// Channels that are multiplied together: those of a block for threads, or the edge of a matrix.
    pub edge: usize,
    /// Rows of pixels of a workgroup.
    pub rows: u32,
    /// Further constants of the shader.
    pub constants: Vec<(&'static str, u32)>,
}

impl Method {
    /// Method with plain threads, for any device.
    fn threads(conv: &Conv) -> Self {
        let fours = if conv.stride == 1 { 4 } else { 2 };
        Self { shader: CONV, edge: BLOCK, rows: 4 * fours, constants: vec![("ROWS", fours)] }
    }

    /// Method with `matrices`, with as many rows as the threads and workgroup memory in `limits` allow. `None` if
    /// not even two rows fit.
    fn matrices(matrices: Matrices, conv: &Conv, limits: &wgpu::Limits) -> Option<Self> {
        let (edge, (least, most)) = (matrices.edge(), matrices.subgroup());
        let shader = if edge == 8 { CONV_MATRICES_8 } else { CONV_MATRICES_16 };
        let (size, stride) = (conv.size as u32, conv.stride as u32);
        let with = |rows: u32| {
            let threads = COLUMNS / edge * rows / 2 * most;
            let subgroups = threads.div_ceil(least);
            let patch = ((COLUMNS - 1) * stride + size) * ((rows - 1) * stride + size);
            let bytes = 2 * patch * (edge + PADDING) + 4 * subgroups * edge * edge;
            let fits = threads <= limits.max_compute_invocations_per_workgroup
                && threads <= limits.max_compute_workgroup_size_x
                && bytes <= limits.max_compute_workgroup_storage_size;
            let constants = vec![("ROWS", rows), ("THREADS", threads), ("SUBGROUPS", subgroups)];
            fits.then_some(Self { shader, edge: edge as usize, rows, constants })
        };
        [8, 4, 2].into_iter().find_map(with)
    }
}

/// Capabilities of a device.
#[derive(Debug, Clone)]
pub struct Units {
    pub matrices: Option<Matrices>,
    pub limits: wgpu::Limits,
}

impl Units {
    /// Chooses the method for `conv` from `inputs` to `outputs` channels: matrices, unless padding would more than
    /// double the products.
    pub fn method(&self, conv: &Conv, inputs: usize, outputs: usize) -> Method {
        let padded = |edge: usize| inputs.next_multiple_of(edge) * outputs.next_multiple_of(edge);
        let is_worth = |matrices: &Matrices| padded(matrices.edge() as usize) <= 2 * inputs * outputs;
        let matrices = self.matrices.filter(is_worth);
        let method = matrices.and_then(|matrices| Method::matrices(matrices, conv, &self.limits));
        method.unwrap_or_else(|| Method::threads(conv))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Layer, Named, TensorId};

    fn units(edge: u32, subgroup: (u32, u32)) -> Units {
        Units { matrices: Some(Matrices::new(edge, subgroup)), limits: wgpu::Limits::default() }
    }

    /// Share of all products of a network that use matrices.
    fn share(named: Named, units: &Units) -> f64 {
        let plan = named.config().plan().unwrap();
        let channels = |id: TensorId| plan.tensor(id).channels;
        let mut made = [0.0; 2];
        for layer in plan.layers() {
            let Layer::Conv(conv) = layer else { continue };
            let inputs = conv.inputs.iter().map(|read| channels(read.tensor)).sum();
            let products = inputs * channels(conv.output) * conv.size * conv.size;
            let at = plan.tensor(conv.output).level;
            let by_threads = units.method(conv, inputs, channels(conv.output)).shader == CONV;
            made[usize::from(by_threads)] += (products as f64) / f64::from(1 << (2 * at));
        }
        made[0] / (made[0] + made[1])
    }

    #[test]
    fn most_products_of_every_network_are_made_by_matrices() {
        for units in [units(8, (8, 8)), units(8, (32, 32)), units(16, (32, 32)), units(16, (32, 64))] {
            for named in Named::ALL {
                assert!(share(named, &units) >= 0.85, "{named} {units:?}: {}", share(named, &units));
            }
        }
        let none = Units { matrices: None, limits: wgpu::Limits::default() };
        assert_eq!(share(Named::WNetFast, &none), 0.0);
    }

    #[test]
    fn workgroups_keep_within_what_a_device_has() {
        let plan = Named::DeepFoveaOrig.config().plan().unwrap();
        let conv = plan.layers().iter().find_map(|layer| match layer {
            Layer::Conv(conv) if conv.stride == 2 => Some(conv),
            _ => None,
        });
        let limits = wgpu::Limits::default();
        let rows =
            |subgroup| Method::matrices(Matrices::new(16, subgroup), conv.unwrap(), &limits).map(|m| m.rows);
        assert_eq!([(32, 32), (8, 32), (64, 64), (8, 128)].map(rows), [Some(4), Some(2), Some(4), None]);
    }
}
