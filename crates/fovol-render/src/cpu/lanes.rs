//! A renderer's pixels in lanes of its instruction set, or by the specification.

use super::few_shadow_rays::FewShadowRays;
use super::field::{AnyType, AnyValues, Field, Texel, with_field};
use super::fine::FineKernel;
use super::in_vectors::InVectors;
use super::kernel::{Kernel, Lighting};
use super::layered::{Layer, LayerVoxels, Layered};
use super::march::SampleCount;
use super::march_memory::MarchMemory;
use super::medium::{Medium, OneVolume};
use super::modes::{IsosurfaceKernel, Projection, ProjectionKernel};
use super::prepared::ColouredVolume;
use super::renderer::Renderer;
use super::shadow_grid::ShadowGrid;
use super::skip::Skip;
use crate::scene::{BrickData, RayResult, Segments, blended_results};
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
        let count = match self.mode {
            RayMode::Composite if self.blends() => {
                let kernel = &self.kernel(self.layered(), few);
                let scratch = &mut scratch.plain;
                Layered::in_vectors(simd, InVectors { kernel, rays, pixels, scratch, out: &mut out })
            }
            _ if !self.is_layered() => {
                let volume = self.first();
                self.march_volume(volume, (rays, pixels, few), scratch, &mut out)
            }
            _ => self.march_projections((rays, pixels), scratch, &mut out),
        };
        (out, count)
    }

    /// Projects each volume on its own, and blends what they show.
    fn march_projections(
        &self,
        (rays, pixels): (&RayBasis, &[Pixel]),
        scratch: &mut MarchMemory,
        out: &mut Vec<RayResult>,
    ) -> SampleCount {
        let mut count = SampleCount::default();
        let of_volumes: Vec<Vec<RayResult>> = self
            .volumes()
            .map(|volume| {
                let mut results = Vec::with_capacity(pixels.len());
                count += self.march_volume(volume, (rays, pixels, None), scratch, &mut results);
                results
            })
            .collect();
        let background = self.background();
        out.extend((0..pixels.len()).map(|pixel| {
            let results: Vec<RayResult> = of_volumes.iter().map(|results| results[pixel]).collect();
            blended_results(&results, background)
        }));
        count
    }

    /// Marches one volume.
    fn march_volume<'a>(
        &'a self,
        volume: ColouredVolume<'a>,
        (rays, pixels, few): (&RayBasis, &[Pixel], Option<&FewShadowRays<'a>>),
        scratch: &mut MarchMemory,
        out: &mut Vec<RayResult>,
    ) -> SampleCount {
        let ColouredVolume { bricks, table, .. } = volume;
        let unit = table.scale();
        match self.options.simd {
            Simd::Portable => {
                let field = Field::<AnyType>::new(bricks, AnyValues::new(bricks), unit);
                self.march_field((field, volume), (rays, pixels, few), scratch, out)
            }
            _ => with_field!(bricks, unit, field => {
                self.march_field((field, volume), (rays, pixels, few), scratch, out)
            }),
        }
    }

    fn march_field<'a, T: Texel>(
        &'a self,
        (field, volume): (Field<'a, T>, ColouredVolume<'a>),
        (rays, pixels, few): (&RayBasis, &[Pixel], Option<&FewShadowRays<'a>>),
        scratch: &mut MarchMemory,
        out: &mut Vec<RayResult>,
    ) -> SampleCount {
        let medium = OneVolume::new(field, self.voxel_size(), volume.table);
        let (kernel, simd) = (self.kernel(medium, few), self.options.simd);
        if let Some(projection) = Projection::of(self.mode) {
            let kernel = &ProjectionKernel { kernel, transfer: volume.transfer, projection };
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

    /// All volumes as one medium.
    fn layered(&self) -> Layered<'_> {
        let first = LayerVoxels {
            bricks: &self.bricks,
            colours: self.colours.as_ref(),
            gradients: self.gradients.as_ref(),
        };
        let others = self.layers.iter().map(|layer| LayerVoxels {
            bricks: &layer.bricks,
            colours: layer.colours.as_ref(),
            gradients: layer.gradients.as_ref(),
        });
        let all = std::iter::once(first).chain(others).zip(&self.prepared.blending);
        Layered(all.map(|(voxels, table)| Layer::new(voxels, self.voxel_size(), table)).collect())
    }

    /// The edges of a voxel in world units.
    fn voxel_size(&self) -> [f32; 3] {
        self.grid.voxel_size().as_vec3().to_array()
    }

    fn kernel<'a, M: Medium>(&'a self, medium: M, few: Option<&FewShadowRays<'a>>) -> Kernel<'a, M> {
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
            medium,
            segments: Segments::new(&self.grid, &self.clip, self.prepared.step),
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
