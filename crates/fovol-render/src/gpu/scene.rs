use super::error::Result;
use super::layers::{LayerLooks, Layering, Layers, blends};
use super::light_columns::{self, ColumnNumbers};
use super::scene_kind::{SceneKind, scene_layout};
use super::scene_numbers::{FAR, SceneNumbers, padded};
use super::shadow_grid::{ShadowGridPass, shadow_texture};
use super::tables::Tables;
use super::texture::{texture, write_slices};
use super::volume_texture::{TexelKind, VolumeTexture};
use crate::Filtering;
use crate::cpu::light_columns::LightColumns;
use crate::scene::{Bricks, LightPath, LightSlices, Macrocells, SWEEP_STEP, Segments};
use bytemuck::Zeroable;
use fovol_core::{
    Camera, ClipBox, FrameSize, Grid, Integration, Interpolation, Light, RayMode, Region, Scene, Shading,
    ShadowMode, TransferFunction,
};
use fovol_gpu::Gpu;
use fovol_gpu::binding::bind_group;
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

/// A scene on the device.
#[derive(Debug)]
pub struct DeviceScene {
    contents: Contents,
    group: wgpu::BindGroup,
}

impl DeviceScene {
    /// Binds `contents`; `shadows` fills the grid where shadows are cached.
    ///
    /// # Errors
    /// A device that is lost or has no memory left.
    pub fn new(mut contents: Contents, shadows: &ShadowGridPass) -> Result<Self> {
        let group = contents.bind(shadows)?;
        Ok(Self { contents, group })
    }

    /// Takes another scene around the same volume.
    ///
    /// # Errors
    /// Numbers of the scene that cannot be rendered with, a device that is lost or has no memory left.
    pub fn set(&mut self, scene: &Scene, shadows: &ShadowGridPass) -> Result<()> {
        scene.check()?;
        if self.contents.change(scene)? {
            self.group = self.contents.bind(shadows)?;
        }
        Ok(())
    }

    /// Skips empty space and keeps a grid of shadows where `other` does.
    ///
    /// # Errors
    /// A device that is lost or has no memory left.
    pub fn choose_as(&mut self, other: &Self, shadows: &ShadowGridPass) -> Result<()> {
        self.contents.skip_empty = other.contents.skip_empty;
        if other.contents.keeps_shadow_grid {
            self.keep_shadow_grid(shadows)?;
        }
        Ok(())
    }

    /// Keeps a grid of shadows from now on, whatever shadows the scene has.
    ///
    /// # Errors
    /// A device that is lost or has no memory left.
    pub fn keep_shadow_grid(&mut self, shadows: &ShadowGridPass) -> Result<()> {
        self.contents.keeps_shadow_grid = true;
        if !self.contents.is_lit {
            self.group = self.contents.bind(shadows)?;
        }
        Ok(())
    }

    /// Lets the grid of shadows go with the next scene that needs none.
    pub fn release_shadow_grid(&mut self) {
        self.contents.keeps_shadow_grid = false;
    }

    /// Switches the skipping of empty space on or off.
    pub fn set_skip_empty(&mut self, skip_empty: bool) {
        self.contents.skip_empty = skip_empty;
    }

    /// The bind group of the scene.
    pub fn group(&self) -> &wgpu::BindGroup {
        &self.group
    }

    /// The properties that are compiled into shaders.
    pub fn kind(&self) -> SceneKind {
        self.contents.kind()
    }

    /// How samples are lit.
    pub fn shading(&self) -> &Shading {
        &self.contents.shading
    }

    /// Changes the shadows of the next frames only. Bindings stay, so this never makes a missing shadow grid; see
    /// [`Self::keep_shadow_grid`].
    pub fn set_shadows_of_next_frames(&mut self, shadows: ShadowMode) {
        self.contents.shading.shadows = shadows;
    }

    /// The region of a frame of `size`, seen by `camera`, that can show more than the background.
    pub fn visible_region(&self, camera: &Camera, size: FrameSize) -> Option<Region> {
        let Contents { cells, grid, clip, .. } = &self.contents;
        cells.visible_region((grid, clip), camera, size)
    }

    /// Where rays take their samples.
    pub fn segments(&self) -> Segments {
        Segments::new(&self.contents.grid, &self.contents.clip, self.contents.step)
    }
}

/// Sources of a grid of shadows, besides the volume. No step changes it.
#[derive(Debug, Clone, PartialEq)]
struct GridSource {
    light: Light,
    clip: ClipBox,
    transfer: TransferFunction,
    interpolation: Interpolation,
    others: LayerLooks,
    skip_empty: bool,
}

/// The sources of a scene: its volume on the device and the settings from which [`Resources`] are made.
#[derive(Debug)]
pub struct Contents {
    gpu: Gpu,
    layout: wgpu::BindGroupLayout,
    grid: Grid,
    clip: ClipBox,
    volume: VolumeTexture,
    layers: Layers,
    has_gaps: bool,
    cells: Macrocells,
    skip_empty: bool,
    /// Whether columns of the light direction are on the device.
    has_columns: bool,
    /// Whether there is a grid of shadows even if the scene has other shadows.
    keeps_shadow_grid: bool,
    /// Whether a grid of shadows is bound.
    is_lit: bool,
    /// The last grid of shadows, and what it was made of.
    shadow_grid: Option<(GridSource, wgpu::Texture)>,
    transfer: TransferFunction,
    shading: Shading,
    background: [f64; 3],
    step: f64,
    integration: Integration,
    interpolation: Interpolation,
    mode: RayMode,
}

impl Contents {
    /// Uploads the volumes of `scene`.
    ///
    /// # Errors
    /// Numbers of the scene that cannot be rendered with, a volume that exceeds the device's limits or memory.
    pub fn new(gpu: &Gpu, scene: &Scene, filtering: Filtering) -> Result<Self> {
        scene.check()?;
        // Bricks are freed after the upload.
        let bricks = Bricks::of_volume(&scene.volume).map_err(fovol_core::Error::from)?;
        let cells = Macrocells::new(&bricks).map_err(fovol_core::Error::from)?;
        // Shaders of several volumes interpolate voxels themselves.
        let filtering = if blends(scene) { Filtering::Exact } else { filtering };
        let volume = VolumeTexture::new(gpu, &bricks, filtering)?;
        let layers = Layers::new(gpu, scene)?;
        let layering = layers.layering(bricks.has_gaps(), scene.interpolation);
        let mut contents = Self {
            gpu: gpu.clone(),
            layout: gpu.guarded("uploading the scene", || scene_layout(gpu, volume.kind(), layering))?,
            grid: *scene.volume.grid(),
            clip: scene.clip_box(),
            has_gaps: bricks.has_gaps(),
            volume,
            layers,
            cells,
            skip_empty: true,
            has_columns: false,
            keeps_shadow_grid: false,
            is_lit: false,
            shadow_grid: None,
            transfer: scene.transfer_function.clone(),
            shading: scene.shading,
            background: scene.background,
            step: scene.marching_step(),
            integration: scene.marching_integration(),
            interpolation: scene.interpolation,
            mode: scene.mode,
        };
        contents.classify();
        Ok(contents)
    }

    /// Finds what is empty.
    fn classify(&mut self) {
        self.cells.classify_with(&self.transfer, self.mode, self.layers.cells());
    }

    /// Takes over all of `scene` but its volumes; returns whether anything changed.
    ///
    /// # Errors
    /// A device that has no memory for lengths of gradients.
    fn change(&mut self, scene: &Scene) -> Result<bool> {
        let thinned = self.layers.find_gradients(&self.gpu, scene)?;
        let recoloured = self.layers.change(scene) || thinned || self.transfer != scene.transfer_function;
        let is_other_mode = self.mode != scene.mode;
        if recoloured || is_other_mode {
            self.transfer = scene.transfer_function.clone();
            self.mode = scene.mode;
            self.classify();
        }
        let integration = (self.integration, self.interpolation);
        let before = (self.shading, self.background, self.step, integration, self.clip);
        let integration = (scene.marching_integration(), scene.interpolation);
        let after = (scene.shading, scene.background, scene.marching_step(), integration, scene.clip_box());
        (self.shading, self.background, self.step, _, self.clip) = after;
        (self.integration, self.interpolation) = integration;
        Ok(recoloured || is_other_mode || before != after)
    }

    /// The kind of the volume's texels.
    pub fn texels(&self) -> TexelKind {
        self.volume.kind()
    }

    /// The volumes and their colours.
    pub fn layering(&self) -> Layering {
        self.layers.layering(self.has_gaps, self.interpolation)
    }

    fn kind(&self) -> SceneKind {
        let skip = self.skip_empty && !self.cells.is_dense();
        SceneKind {
            texels: self.texels(),
            gaps: self.has_gaps,
            planes: self.clip.planes().as_slice().len() as u32,
            skip,
            columns: skip && self.has_columns,
            integration: self.integration,
            interpolation: self.interpolation,
            mode: self.mode.into(),
            layers: self.layering(),
        }
    }

    /// The shadows of composited pictures; other modes need nothing of what these prepare.
    fn shadows(&self) -> ShadowMode {
        if self.mode == RayMode::Composite { self.shading.shadows } else { ShadowMode::Off }
    }

    /// Uploads the [`Resources`] and binds them; fills the shadow grid where shadows are cached.
    fn bind(&mut self, shadows: &ShadowGridPass) -> Result<wgpu::BindGroup> {
        const DOING: &str = "uploading the scene";
        let columns = self.light_columns();
        self.has_columns = columns.is_some();
        let (resources, unlit) = self.gpu.guarded(DOING, || {
            let resources = Resources::new(self, columns.as_ref());
            let unlit = self.bound(&resources, &shadow_texture(&self.gpu, [1; 3]));
            (resources, unlit)
        })?;
        let may_be_lit = self.mode == RayMode::Composite;
        self.is_lit = may_be_lit && (self.keeps_shadow_grid || self.shading.shadows == ShadowMode::Cached);
        if !self.is_lit {
            self.shadow_grid = None;
            return Ok(unlit);
        }
        let lit = self.lit(shadows, &unlit)?;
        Ok(self.gpu.guarded(DOING, || self.bound(&resources, &lit))?)
    }

    /// The grid of shadows: the last one, if it still holds. `unlit` binds the scene.
    fn lit(&mut self, shadows: &ShadowGridPass, unlit: &wgpu::BindGroup) -> Result<wgpu::Texture> {
        let source = GridSource {
            light: self.shading.light,
            clip: self.clip,
            transfer: self.transfer.clone(),
            interpolation: self.interpolation,
            others: self.layers.looks(),
            skip_empty: self.skip_empty,
        };
        if let Some((_, grid)) = self.shadow_grid.as_ref().filter(|(known, _)| *known == source) {
            return Ok(grid.clone());
        }
        let path = LightPath::new(&self.shading.light, &self.grid, &self.clip, SWEEP_STEP);
        let slices = LightSlices::new(self.grid.dims(), &path).with_longer_steps(self.step / SWEEP_STEP);
        let lit = shadows.fill(&self.gpu, self.kind(), unlit, (&slices, self.grid.dims()))?;
        self.shadow_grid = Some((source, lit.clone()));
        Ok(lit)
    }

    fn light_path(&self) -> LightPath {
        LightPath::new(&self.shading.light, &self.grid, &self.clip, self.step)
    }

    /// The columns of the light direction, where shadow rays are followed and can skip anything.
    fn light_columns(&self) -> Option<LightColumns> {
        if self.shadows() != ShadowMode::On || self.cells.is_dense() {
            return None;
        }
        let columns = LightColumns::new(&self.cells, self.grid.dims(), &self.light_path());
        light_columns::fit(&self.gpu, &columns).then_some(columns)
    }

    fn bound(&self, resources: &Resources, shadow_grid: &wgpu::Texture) -> wgpu::BindGroup {
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let textures =
            [self.volume.texture(), &resources.distances, shadow_grid, &resources.column_words].map(view);
        let [volume, distances, shadow_grid, column_words] =
            textures.each_ref().map(wgpu::BindingResource::TextureView);
        let others = self.layers.textures().map(view);
        let mut bindings = vec![
            resources.numbers.as_entire_binding(),
            volume,
            distances,
            resources.appearance.as_entire_binding(),
            resources.shadow_alpha.as_entire_binding(),
            shadow_grid,
            wgpu::BindingResource::Sampler(&resources.linear),
            resources.extinction.as_entire_binding(),
            column_words,
        ];
        if self.layering().are_blended() {
            bindings.push(resources.layers.as_entire_binding());
            bindings.extend(others.iter().map(wgpu::BindingResource::TextureView));
        }
        bind_group(&self.gpu, "scene", &self.layout, &bindings)
    }

    fn numbers(&self, tables: &Tables) -> SceneNumbers {
        let light = self.light_path();
        let delta = self.step * self.grid.smallest_voxel();
        let [box_low, box_high] = self.clip.in_voxels();
        SceneNumbers {
            last: self.grid.dims().map(|d| (d - 1) as f32),
            delta: delta as f32,
            to_voxels: self.grid.voxel_size().recip().as_vec3().to_array(),
            scale: self.volume.value_scale() * tables.scale,
            background: self.background.map(|c| c as f32),
            ambient: self.shading.ambient as f32,
            light_delta: light.delta,
            cell_shift: self.cells.shift(),
            light_exit: light.exit,
            extinction_unit: tables.extinction_unit,
            bin_bits: tables.bin_bits,
            last_entry: tables.last as u32,
            // Shaders need not know infinity.
            light_inverse: light.inverse.map(|i| if i.is_finite() { i } else { 0.0 }),
            light_direction: self.shading.light.direction().as_vec3().to_array(),
            box_low,
            box_high,
            planes: padded(
                self.clip.planes().in_voxels(&self.grid).map(|plane| plane.map(|x| x as f32)),
                0.0,
            ),
            light_planes: padded(light.planes.as_slice().iter().copied(), FAR),
            iso: if let RayMode::Isosurface(iso) = self.mode { iso * tables.scale } else { 0.0 },
            ..SceneNumbers::zeroed()
        }
    }
}

/// The buffers and textures that change with the transfer function and the light.
struct Resources {
    numbers: wgpu::Buffer,
    distances: wgpu::Texture,
    appearance: wgpu::Buffer,
    shadow_alpha: wgpu::Buffer,
    linear: wgpu::Sampler,
    extinction: wgpu::Buffer,
    column_words: wgpu::Texture,
    layers: wgpu::Buffer,
}

impl Resources {
    fn new(contents: &Contents, columns: Option<&LightColumns>) -> Self {
        let gpu = &contents.gpu;
        // Projections take the opacity of one voxel.
        let step = if contents.mode.is_projection() { 1.0 } else { contents.step };
        let tables = Tables::new(&contents.transfer, (step, contents.integration), &contents.layers);
        let cells = &contents.cells;
        let distances =
            texture(gpu, "distances", cells.cells(), TextureFormat::R8Uint, TextureUsages::COPY_DST);
        let count = cells.cells().iter().product();
        write_slices(gpu, &distances, 0, &cells.distances()[..count]);
        let numbers = SceneNumbers { columns: ColumnNumbers::new(columns), ..contents.numbers(&tables) };
        let table = |label: &str, bytes: &[u8]| filled_buffer(gpu, label, BufferUsages::STORAGE, bytes);
        let uniform = |label: &str, bytes: &[u8]| filled_buffer(gpu, label, BufferUsages::UNIFORM, bytes);
        Self {
            numbers: uniform("scene", bytemuck::bytes_of(&numbers)),
            distances,
            appearance: table("appearance", bytemuck::cast_slice(&tables.appearance)),
            shadow_alpha: table("shadow opacities", bytemuck::cast_slice(&tables.shadow_alpha)),
            extinction: table("extinction", bytemuck::cast_slice(&tables.extinction)),
            column_words: light_columns::words(gpu, columns),
            layers: uniform("layers", bytemuck::cast_slice(&tables.layers)),
            linear: gpu.device().create_sampler(&wgpu::SamplerDescriptor {
                label: Some("linear"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            }),
        }
    }
}

fn filled_buffer(gpu: &Gpu, label: &str, usage: BufferUsages, bytes: &[u8]) -> wgpu::Buffer {
    let buffer = gpu.device().create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: bytes.len() as u64,
        usage: usage | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    gpu.queue().write_buffer(&buffer, 0, bytes);
    buffer
}
