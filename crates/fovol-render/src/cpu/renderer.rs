use super::few_shadow_rays::FewShadowRays;
use super::field::readable;
use super::in_turn::in_turn;
use super::light_columns::LightColumns;
use super::march::{March, SampleCount};
use super::march_memory::MarchMemory;
use super::march_order::MarchOrder;
use super::prepared::{OtherSteps, Prepared};
use super::prepared_layer::{PreparedLayer, bricks_of_colours};
use super::shadow_grid::ShadowGrid;
use super::simd::best_simd;
use super::tile_order::{TILE, TILE_ORDER};
use crate::scene::{BrickLayout, Bricks, LightPath, Macrocells, RayResult, SWEEP_STEP};
use fovol_core::memory::{Estimate, Shortage};
use fovol_core::{
    Camera, ClipBox, Frame, FrameSize, Grid, Pixel, RayMode, Region, SampleList, SampleMask, Scene, Shading,
    ShadowMode, TransferFunction,
};
use fovol_simd::Simd;
use rayon::prelude::*;
use std::time::Duration;

/// The choices that change how fast a picture is made, not what it shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RenderOptions {
    /// The instruction set.
    pub simd: Simd,
    /// Whether rays leave empty space at once.
    pub skip_empty: bool,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self { simd: best_simd(), skip_empty: true }
    }
}

/// A scene prepared for marching on the CPU.
///
/// Preparing costs about a second per billion voxels; changing the transfer function or the light
/// afterwards costs a small part of that.
#[derive(Debug)]
pub struct Renderer {
    pub(super) grid: Grid,
    pub(super) clip: ClipBox,
    pub(super) bricks: Bricks,
    pub(super) cells: Macrocells,
    pub(super) transfer: TransferFunction,
    /// Red, green and blue of the voxels, where they have colours.
    pub(super) colours: Option<[Bricks; 3]>,
    /// Lengths of the gradients, once the opacity depended on them.
    pub(super) gradients: Option<Bricks>,
    /// Further volumes at the same points.
    pub(super) layers: Vec<PreparedLayer>,
    pub(super) mode: RayMode,
    pub(super) shading: Shading,
    pub(super) background: [f64; 3],
    /// Tables and light columns for the step of the scene.
    pub(super) prepared: Prepared,
    /// Tables and light columns for other steps.
    others: OtherSteps,
    /// Transmittance towards the light at every voxel, once shadows were cached. No step changes it.
    pub(super) shadow_grid: Option<ShadowGrid>,
    /// Factor from the step of the scene to that of rays; see [`Scene::step_stretch`].
    pub(super) stretch: f64,
    /// Choices that were asked for, and those in force.
    asked: RenderOptions,
    pub(super) options: RenderOptions,
}

/// Rays for which light columns pay.
const PAYS: usize = 65_536;
/// Fewest and most pixels of a list that are marched by one task.
const FEWEST: usize = 8;
const CHUNK: usize = 256;

impl Renderer {
    /// Prepares `scene`.
    ///
    /// # Errors
    /// Numbers of the scene that cannot be rendered with, see [`Scene::check`]; no memory for it.
    pub fn new(scene: &Scene, options: RenderOptions) -> fovol_core::Result<Self> {
        scene.check()?;
        let mut bricks = Bricks::of_volume(&scene.volume)?;
        bricks.set_interpolation(scene.interpolation);
        Self::with_bricks(bricks, scene, options)
    }

    /// `estimate` with the memory that `scene` takes when it is prepared.
    #[must_use]
    pub fn estimate(scene: &Scene, estimate: Estimate) -> Estimate {
        let shadows = match scene.shading.shadows {
            ShadowMode::Cached => {
                let dims = scene.volume.grid().dims();
                BrickLayout::voxels(dims).elements() + dims.iter().product::<usize>()
            }
            ShadowMode::On | ShadowMode::Off => 0,
        };
        let colours =
            scene.colours.iter().chain(scene.layers.iter().filter_map(|layer| layer.colours.as_ref()));
        let volumes = std::iter::once(&scene.volume).chain(scene.layers.iter().map(|layer| &layer.volume));
        let bricks = volumes.chain(colours.flatten()).map(|volume| Bricks::bytes_of(volume)).sum();
        let cells = Macrocells::bytes_of(scene.volume.grid().dims());
        let gradients =
            Self::gradients_of(scene) as u64 * Bricks::bytes_of_gradient_lengths(scene.volume.grid().dims());
        estimate
            .with("voxels in bricks", bricks)
            .with("gradients", gradients)
            .with("empty space", cells * (1 + scene.layers.len() as u64))
            .with("cached shadows", shadows as u64)
    }

    fn with_bricks(bricks: Bricks, scene: &Scene, options: RenderOptions) -> fovol_core::Result<Self> {
        let cells = Macrocells::new(&bricks)?;
        let mut renderer = Self {
            grid: *scene.volume.grid(),
            clip: scene.clip_box(),
            bricks,
            cells,
            transfer: scene.transfer_function.clone(),
            colours: scene.colours.as_ref().map(bricks_of_colours).transpose()?,
            gradients: None,
            layers: scene.layers.iter().map(PreparedLayer::new).collect::<fovol_core::Result<_>>()?,
            mode: scene.mode,
            shading: scene.shading,
            background: scene.background,
            prepared: Prepared::new(
                &scene.transfer_function,
                scene.marching_step(),
                scene.marching_integration(),
            ),
            others: OtherSteps::default(),
            shadow_grid: None,
            stretch: scene.step_stretch(),
            asked: options,
            options,
        };
        renderer.set_options(options);
        renderer.find_gradients(scene)?;
        renderer.classify();
        renderer.prepare_blending();
        renderer.prepare_shadows()?;
        Ok(renderer)
    }

    /// Replaces the scene by `scene`, which must show the same volumes; only parts that differ are prepared again.
    ///
    /// # Errors
    /// Numbers of the scene that cannot be rendered; the old scene then stays. Too little memory for cached shadows;
    /// the new scene then has none.
    pub fn set_scene(&mut self, scene: &Scene) -> fovol_core::Result<()> {
        self.change_scene(scene)?;
        Ok(self.prepare_shadows()?)
    }

    /// Replaces the scene as [`Self::set_scene`] does, for frames of which each is announced by [`Self::expect_rays`].
    ///
    /// # Errors
    /// As [`Self::set_scene`].
    pub fn change_scene(&mut self, scene: &Scene) -> fovol_core::Result<()> {
        scene.check()?;
        self.find_gradients(scene)?;
        let clip = scene.clip_box();
        if self.shading.light != scene.shading.light || self.clip != clip {
            self.prepared.forget_light();
            self.others.forget_light();
            self.shadow_grid = None;
        }
        (self.shading, self.background, self.clip) = (scene.shading, scene.background, clip);
        if self.bricks.interpolation() != scene.interpolation {
            self.bricks.set_interpolation(scene.interpolation);
            self.gradients.iter_mut().for_each(|lengths| lengths.set_interpolation(scene.interpolation));
            self.set_options(self.asked);
            self.shadow_grid = None;
        }
        let integration = scene.marching_integration();
        let others = self.layers.iter_mut().zip(&scene.layers);
        let others_changed = others.fold(false, |changed, (layer, new)| layer.change(new) || changed);
        let recoloured = others_changed || self.transfer != scene.transfer_function;
        if recoloured || self.mode != scene.mode {
            self.transfer = scene.transfer_function.clone();
            self.mode = scene.mode;
            self.classify();
            self.prepared.forget_light();
            self.others.forget_light();
        }
        if recoloured {
            self.prepared = Prepared::new(&self.transfer, scene.marching_step(), integration);
            self.prepare_blending();
            self.others.clear();
            self.shadow_grid = None;
        } else if self.prepared.integration() != integration {
            self.prepared.integrate(&self.transfer, integration);
            self.others.clear();
        }
        self.take_step(scene.marching_step());
        if self.shadows() == ShadowMode::Cached {
            self.make_shadow_grid()?;
        }
        Ok(())
    }

    /// Takes other speed choices.
    pub fn set_options(&mut self, options: RenderOptions) {
        let are_readable = readable(&self.bricks) && self.layers.iter().all(|layer| readable(&layer.bricks));
        let simd = if are_readable { options.simd } else { Simd::Scalar };
        (self.asked, self.options) = (options, RenderOptions { simd, ..options });
    }

    /// The choices in force; the instruction set is `scalar` where a volume is too large for lanes,
    /// or has NaN between labels.
    pub fn options(&self) -> RenderOptions {
        self.options
    }

    /// How long the cached shadows of this scene took to make; nothing where it has none.
    pub fn shadow_grid_time(&self) -> Duration {
        match (self.shadows(), &self.shadow_grid) {
            (ShadowMode::Cached, Some(grid)) => grid.took,
            _ => Duration::ZERO,
        }
    }

    /// How long the last cached shadows took to make, whatever shadows the scene has; `None` if there are none.
    pub fn cached_shadows_time(&self) -> Option<Duration> {
        self.shadow_grid.as_ref().map(|grid| grid.took)
    }

    /// The macrocells, for figures about empty space.
    pub fn macrocells(&self) -> &Macrocells {
        &self.cells
    }

    /// The region of a frame of `size`, seen by `camera`, that can show more than the background.
    ///
    /// It may be somewhat too large, never too small. `None` where only the background shows.
    pub fn visible_region(&self, camera: &Camera, size: FrameSize) -> Option<Region> {
        self.cells.visible_region((&self.grid, &self.clip), camera, size)
    }

    /// The background colour, RGB.
    pub fn background(&self) -> [f32; 3] {
        self.background.map(|v| v as f32)
    }

    /// Goes over to `step`. What the step before needs is kept.
    pub(super) fn take_step(&mut self, step: f64) {
        if self.prepared.step == step {
            return;
        }
        let taken = self.others.take(step);
        let is_new = taken.is_none();
        let anew = taken.unwrap_or_else(|| Prepared::new(&self.transfer, step, self.prepared.integration()));
        self.others.keep(std::mem::replace(&mut self.prepared, anew));
        if is_new {
            self.prepare_blending();
        }
    }

    /// Makes what the shadows of the scene need, unless it exists. What other shadows need stays: a viewer goes back and forth.
    pub(super) fn prepare_shadows(&mut self) -> Result<(), Shortage> {
        match self.shadows() {
            ShadowMode::Cached => self.make_shadow_grid()?,
            ShadowMode::On => self.make_light_columns(),
            ShadowMode::Off => {}
        }
        Ok(())
    }

    pub(super) fn make_shadow_grid(&mut self) -> Result<(), Shortage> {
        if self.shadow_grid.is_none() {
            let Self { grid, clip, shading, .. } = &*self;
            let path = LightPath::new(&shading.light, grid, clip, SWEEP_STEP);
            let volumes: Vec<_> = self.volumes().collect();
            self.shadow_grid = Some(ShadowGrid::new(&volumes, (grid, clip), &path, self.options.simd)?);
        }
        Ok(())
    }

    /// The shadows of composited pictures; other modes need nothing of what these prepare.
    fn shadows(&self) -> ShadowMode {
        if self.mode == RayMode::Composite { self.shading.shadows } else { ShadowMode::Off }
    }

    /// Prepares for `rays` rays of this scene, which come next. Light columns make shadow rays quicker; where light moves and frames
    /// are small, making them takes longer than they save.
    pub fn expect_rays(&mut self, rays: usize) {
        if self.shadows() == ShadowMode::On {
            self.prepared.rays = self.prepared.rays.saturating_add(rays);
            if self.prepared.rays >= PAYS {
                self.make_light_columns();
            }
        }
    }

    /// Makes the light columns unless they exist or would not pay.
    fn make_light_columns(&mut self) {
        if self.prepared.light_columns.is_none() && !self.cells.is_dense() {
            let columns = LightColumns::new(&self.cells, self.grid.dims(), &self.light_path());
            self.prepared.light_columns = Some(columns);
        }
    }

    /// Runs `march` with shadow rays in place of cached shadows; other scenes are marched unchanged.
    ///
    /// The first such call after a change of the scene prepares the shadow rays. Later calls cost no more than `march`.
    pub fn with_exact_shadows<T>(&mut self, march: impl FnOnce(&Self) -> T) -> T {
        if self.shading.shadows != ShadowMode::Cached {
            return march(self);
        }
        self.make_light_columns();
        self.with_shadows(ShadowMode::On, |renderer| march(renderer))
    }

    /// Runs `march` with `shadows` in place of those of the scene.
    pub(super) fn with_shadows<T>(&mut self, shadows: ShadowMode, march: impl FnOnce(&mut Self) -> T) -> T {
        let own = std::mem::replace(&mut self.shading.shadows, shadows);
        let marched = march(self);
        self.shading.shadows = own;
        marched
    }

    pub(super) fn light_path(&self) -> LightPath {
        LightPath::new(&self.shading.light, &self.grid, &self.clip, self.prepared.step)
    }

    /// This scene for the scalar specification in [`super::march`].
    pub fn specification(&self) -> March<'_> {
        March {
            bricks: &self.bricks,
            grid: &self.grid,
            clip: self.clip,
            transfer: &self.transfer,
            colours: self.colours.as_ref(),
            gradients: self.gradients.as_ref(),
            layers: &self.layers,
            mode: self.mode,
            shading: &self.shading,
            shadow_grid: self
                .shadow_grid
                .as_ref()
                .filter(|_| self.shading.shadows == ShadowMode::Cached)
                .map(|grid| &grid.voxels),
            background: self.background,
            step: self.prepared.step,
            few: None,
        }
    }

    /// Marches the pixels of `list`; returns one result per ray, in list order, and the samples taken.
    pub fn march_list(&self, camera: &Camera, list: &SampleList) -> (Vec<RayResult>, SampleCount) {
        self.march_list_with(camera, list, None)
    }

    /// [`Self::march_list`] with shadow rays as `few` says, if they are to be few. Colours then have noise, whose mean is 0.
    pub fn march_list_with(
        &self,
        camera: &Camera,
        list: &SampleList,
        few: Option<&FewShadowRays<'_>>,
    ) -> (Vec<RayResult>, SampleCount) {
        let rays = camera.rays(list.size());
        let order = MarchOrder::new(list);
        let chunk = list.len().div_ceil(4 * rayon::current_num_threads()).clamp(FEWEST, CHUNK);
        let chunks = order.pixels().chunks(chunk);
        let parts = in_turn(chunks, MarchMemory::default, |scratch, chunk| {
            self.march_pixels(&rays, chunk, few, scratch)
        });
        let mut count = SampleCount::default();
        parts.iter().for_each(|(_, samples)| count += *samples);
        (order.in_list_order(parts.iter().flat_map(|(part, _)| part)), count)
    }

    /// Marches every pixel: a frame with alpha 1.
    pub fn march_full(&self, camera: &Camera, size: FrameSize) -> (Frame, SampleCount) {
        self.march_full_with(camera, size, None)
    }

    /// [`Self::march_full`] with shadow rays as `few` says, if they are to be few.
    pub fn march_full_with(
        &self,
        camera: &Camera,
        size: FrameSize,
        few: Option<&FewShadowRays<'_>>,
    ) -> (Frame, SampleCount) {
        let tiles = self.march_tiles((camera, size, few), |_, _| true, |ray| ray.colour);
        let mut frame = Frame::new(size);
        let columns = size.width.div_ceil(TILE) as usize;
        let rows = frame.pixels_mut().par_chunks_mut((TILE * size.width) as usize);
        rows.zip(tiles.par_chunks(columns)).enumerate().for_each(|(row, (out, tiles))| {
            let before = row * (TILE * size.width) as usize;
            for Tile { pixels, kept, .. } in tiles {
                for (pixel, [r, g, b]) in pixels.iter().zip(kept) {
                    out[pixel.index(size.width) - before] = [*r, *g, *b, 1.0];
                }
            }
        });
        (frame, samples_of(&tiles))
    }

    /// Visits every pixel and marches the pixels of `mask` at once, without packing: the paper's `reject`. Shadow rays are
    /// as `few` says, if they are to be few.
    ///
    /// Returns the marched pixels, tile by tile, one result for each, and the samples taken.
    pub fn march_rejecting(
        &self,
        camera: &Camera,
        mask: &SampleMask,
        few: Option<&FewShadowRays<'_>>,
    ) -> (SampleList, Vec<RayResult>, SampleCount) {
        let view = (camera, mask.size(), few);
        let tiles = self.march_tiles(view, |x, y| mask.contains(x, y), |ray| ray);
        let count = samples_of(&tiles);
        let mut pixels = Vec::with_capacity(mask.count());
        let mut marched = Vec::with_capacity(mask.count());
        for tile in tiles {
            pixels.extend(tile.pixels);
            marched.extend(tile.kept);
        }
        (SampleList::new(mask.size(), pixels), marched, count)
    }

    /// Marches the wanted pixels, and keeps a part of each result.
    fn march_tiles<T: Send>(
        &self,
        (camera, size, few): (&Camera, FrameSize, Option<&FewShadowRays<'_>>),
        wanted: impl Fn(u32, u32) -> bool + Sync,
        keep: impl Fn(RayResult) -> T + Sync,
    ) -> Vec<Tile<T>> {
        let rays = camera.rays(size);
        let (columns, rows) = (size.width.div_ceil(TILE), size.height.div_ceil(TILE));
        in_turn(0..columns * rows, MarchMemory::default, |scratch, tile| {
            let (x0, y0) = (tile % columns * TILE, tile / columns * TILE);
            let mut pixels = Vec::with_capacity((TILE * TILE) as usize);
            for (x, y) in TILE_ORDER.map(|[x, y]| (x0 + x, y0 + y)) {
                if x < size.width && y < size.height && wanted(x, y) {
                    pixels.push(Pixel { x: x as u16, y: y as u16 });
                }
            }
            let (marched, samples) = self.march_pixels(&rays, &pixels, few, scratch);
            Tile { pixels, kept: marched.into_iter().map(&keep).collect(), samples }
        })
    }
}

/// A part of a picture.
struct Tile<T> {
    pixels: Vec<Pixel>,
    /// The kept part of each pixel's result.
    kept: Vec<T>,
    samples: SampleCount,
}

fn samples_of<T>(tiles: &[Tile<T>]) -> SampleCount {
    let mut count = SampleCount::default();
    tiles.iter().for_each(|tile| count += tile.samples);
    count
}
