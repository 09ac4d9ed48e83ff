//! A renderer's pixels in lanes of its instruction set, or by the specification.

use super::few_shadow_rays::FewShadowRays;
use super::field::{AnyType, AnyValues, Field, Texel, with_field};
use super::fine::FineKernel;
use super::in_vectors::InVectors;
use super::kernel::{Kernel, Lighting};
use super::march::SampleCount;
use super::march_memory::MarchMemory;
use super::modes::{IsosurfaceKernel, Projection, ProjectionKernel};
use super::renderer::Renderer;
use super::shadow_grid::ShadowGrid;
use super::skip::Skip;
use crate::scene::{BrickData, RayResult, Segments};
use fovol_core::{Pixel, RayBasis, RayMode, ShadowMode, SurfaceShading, stop};
use fovol_simd::Simd;

impl Renderer {
    /// Marches `pixels`; returns one result for each, and the samples taken.
    pub(super) fn march_pixels(
        &self,
        rays: &RayBasis,
        pixels: &[Pixel],
        few: Option<&FewShadowRays<'_>>,
        scratch: &mut MarchMemory,
    ) -> (Vec<RayResult>, SampleCount) {
        stop::point();
        let mut out = Vec::with_capacity(pixels.len());
        let simd = self.options.simd;
        if simd == Simd::Scalar {
            let mut march = self.specification();
            let mut count = SampleCount::default();
            out.extend(pixels.iter().map(|p| {
                march.few = few.map(|few| (few.per_pixel, few.offset(*p)));
                let ray = rays.ray(p.x.into(), p.y.into());
                match &self.prepared.extinction {
                    _ if self.mode != RayMode::Composite => march.mode_ray(&ray, &mut count),
                    None => march.ray(&ray, &mut count),
                    Some(table) => march.fine_ray(table, &ray, &mut count),
                }
            }));
            return (out, count);
        }
        let unit = self.prepared.table.scale();
        let count = match simd {
            Simd::Portable => {
                let field = Field::<AnyType>::new(&self.bricks, AnyValues::new(&self.bricks), unit);
                self.march_field(field, (rays, pixels, few), scratch, &mut out)
            }
            _ => with_field!(&self.bricks, unit, field => {
                self.march_field(field, (rays, pixels, few), scratch, &mut out)
            }),
        };
        (out, count)
    }

    fn march_field<'a, T: Texel>(
        &'a self,
        field: Field<'a, T>,
        (rays, pixels, few): (&RayBasis, &[Pixel], Option<&FewShadowRays<'a>>),
        scratch: &mut MarchMemory,
        out: &mut Vec<RayResult>,
    ) -> SampleCount {
        let (kernel, simd) = (self.kernel(field, few), self.options.simd);
        if let Some(projection) = Projection::of(self.mode) {
            let kernel = &ProjectionKernel { kernel, transfer: &self.transfer, projection };
            let scratch = &mut scratch.packet;
            return T::in_vectors(simd, InVectors { kernel, rays, pixels, scratch, out });
        }
        if let RayMode::Isosurface(iso) = self.mode {
            let kernel = &IsosurfaceKernel { kernel, march: self.specification(), iso };
            let scratch = &mut scratch.packet;
            return T::in_vectors(simd, InVectors { kernel, rays, pixels, scratch, out });
        }
        match &self.prepared.extinction {
            None => {
                let scratch = &mut scratch.plain;
                T::in_vectors(simd, InVectors { kernel: &kernel, rays, pixels, scratch, out })
            }
            Some(extinction) => {
                let (kernel, scratch) = (&FineKernel { kernel, extinction }, &mut scratch.fine);
                T::in_vectors(simd, InVectors { kernel, rays, pixels, scratch, out })
            }
        }
    }

    fn kernel<'a, T: Texel>(&'a self, field: Field<'a, T>, few: Option<&FewShadowRays<'a>>) -> Kernel<'a, T> {
        let skips = self.options.skip_empty && !self.cells.is_dense();
        let rays = Lighting::Rays(self.prepared.light_columns.as_ref().filter(|_| skips), few.copied());
        let lighting = match (self.shading.shadows, &self.shadow_grid) {
            (ShadowMode::Off, _) => Lighting::Full,
            (ShadowMode::Cached, Some(ShadowGrid { voxels, .. })) => match voxels.data() {
                BrickData::U8(values) => Lighting::Cached(Field::<u8>::new(voxels, values, 1.0)),
                BrickData::Corners(_) | BrickData::U16(_) | BrickData::F32(_) | BrickData::Gaps(_) => rays,
            },
            (ShadowMode::On | ShadowMode::Cached, _) => rays,
        };
        let direction = self.shading.light.direction().as_vec3().to_array();
        Kernel {
            field,
            segments: Segments::new(&self.grid, &self.clip, self.prepared.step),
            voxel_size: self.grid.voxel_size().as_vec3().to_array(),
            table: &self.prepared.table,
            visible: self.prepared.table.visible(),
            light: self.light_path(),
            lighting,
            facing: (self.shading.surface == SurfaceShading::Gradient).then_some(direction),
            ambient: self.shading.ambient as f32,
            background: self.background.map(|c| c as f32),
            skip: skips.then(|| Skip::new(&self.cells, self.grid.dims())),
            simd: self.options.simd,
        }
    }
}
