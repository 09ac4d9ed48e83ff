//! Further volumes of a scene, and colours of voxels, on the device. Twin of shaders/layers.wgsl.

use super::error::Result;
use super::texture::texture;
use super::volume_texture::{ColourTexture, TexelKind, VolumeTexture};
use crate::scene::{BlendTable, Bricks, Macrocells, greatest_gradient};
use bytemuck::{Pod, Zeroable};
use fovol_core::{Interpolation, Layer, MOST_VOLUMES, Scene, TransferFunction, VoxelColours};
use fovol_gpu::Gpu;
use wgpu::{TextureFormat, TextureUsages};

/// Textures of a bind group of layers: three further volumes, the colours of four, and the lengths of their gradients.
pub const TEXTURES: usize = 3 * MOST_VOLUMES - 1;

/// The volumes of a scene and their colours, as shaders are compiled for them. Sets of volumes are one bit each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Layering {
    /// How many volumes there are.
    pub volumes: u8,
    /// Which have voxels with colours.
    coloured: u8,
    /// Which of these are floats.
    colour_floats: u8,
    /// Which further volumes are floats.
    floats: u8,
    /// Which volumes have NaN.
    gaps: u8,
    /// Which volumes show the nearest voxels.
    nearest: u8,
    /// Which volumes have an opacity that depends on the gradient.
    thinned: u8,
    /// Whether shaders of several volumes are used.
    blends: bool,
}

impl Layering {
    /// Whether samples are more than the values and the table of one volume: several volumes, colours of voxels, or opacity
    /// that depends on the gradient.
    pub fn are_blended(self) -> bool {
        self.blends
    }

    /// Whether any opacity depends on the gradient.
    pub fn are_thinned(self) -> bool {
        self.thinned != 0
    }

    /// Values of the shaders' `override` constants; none where nothing is blended.
    pub fn constants(self) -> Vec<(&'static str, f64)> {
        if !self.are_blended() {
            return Vec::new();
        }
        let constants = [
            ("VOLUMES", self.volumes),
            ("COLOURED", self.coloured),
            ("COLOUR_FLOATS", self.colour_floats),
            ("LAYER_FLOATS", self.floats),
            ("LAYER_GAPS", self.gaps),
            ("LAYER_NEAREST", self.nearest),
            ("THINNED", self.thinned),
        ];
        constants.map(|(name, number)| (name, number.into())).to_vec()
    }
}

/// Numbers of a volume. Twin of `LayerNumbers` in shaders/layers.wgsl.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LayerNumbers {
    colour_scale: [f32; 3],
    scale: f32,
    table: u32,
    last_entry: u32,
    factors: u32,
    last_factor: f32,
    length_scale: f32,
    step: f32,
    unused_0: u32,
    unused_1: u32,
}

/// A further volume.
#[derive(Debug)]
struct DeviceLayer {
    volume: VolumeTexture,
    has_gaps: bool,
    cells: Macrocells,
    transfer: TransferFunction,
    interpolation: Interpolation,
}

/// Further volumes of a scene, and colours of voxels.
#[derive(Debug)]
pub struct Layers {
    others: Vec<DeviceLayer>,
    /// Of all volumes.
    colours: Vec<Option<ColourTexture>>,
    /// Lengths of the gradients of all volumes, where opacities depend on them or did.
    lengths: Vec<Option<VolumeTexture>>,
    /// Which opacities depend on them.
    thinned: u8,
    /// Greatest length of a gradient.
    greatest: f64,
    /// Whether shaders of several volumes are used.
    blends: bool,
    /// Bound where there is no other texture.
    none: wgpu::Texture,
}

/// Transfer functions and interpolations of further volumes.
pub type LayerLooks = Vec<(TransferFunction, Interpolation)>;

impl Layers {
    /// Uploads what `scene` has besides its first volume.
    ///
    /// # Errors
    /// A volume that exceeds the device's limits or memory.
    pub fn new(gpu: &Gpu, scene: &Scene) -> Result<Self> {
        let others = scene.layers.iter().map(|layer| DeviceLayer::new(gpu, layer)).collect::<Result<_>>()?;
        let of_first = std::iter::once(&scene.colours);
        let colours = of_first
            .chain(scene.layers.iter().map(|layer| &layer.colours))
            .map(|colours| colours.as_ref().map(|colours| colour_texture(gpu, colours)).transpose())
            .collect::<Result<_>>()?;
        let none = gpu.guarded("uploading the scene", || {
            texture(gpu, "no layer", [1; 3], TextureFormat::R8Uint, TextureUsages::empty())
        })?;
        let lengths = (0..=scene.layers.len()).map(|_| None).collect();
        let greatest = greatest_gradient(scene.volume.grid());
        let blends = blends(scene);
        let mut layers = Self { others, colours, lengths, thinned: 0, greatest, blends, none };
        layers.find_gradients(gpu, scene)?;
        Ok(layers)
    }

    /// Finds the lengths of the gradients on which opacities of `scene` depend, unless they are known; returns whether other
    /// opacities depend on them now.
    ///
    /// # Errors
    /// A volume that exceeds the device's memory.
    pub fn find_gradients(&mut self, gpu: &Gpu, scene: &Scene) -> Result<bool> {
        let others = scene.layers.iter().map(|layer| (&layer.volume, &layer.transfer_function));
        let first = (&scene.volume, &scene.transfer_function);
        let all: Vec<_> = std::iter::once(first).chain(others).collect();
        let depend = |transfer: &TransferFunction| {
            scene.has_gradient_opacity() && transfer.gradient_opacity().is_some()
        };
        let thinned = bits(all.iter().map(|(_, transfer)| depend(transfer)));
        for ((volume, transfer), lengths) in all.into_iter().zip(&mut self.lengths) {
            if depend(transfer) && lengths.is_none() {
                let bricks = Bricks::of_volume(volume).map_err(fovol_core::Error::from)?;
                let found = bricks.gradient_lengths(volume.grid()).map_err(fovol_core::Error::from)?;
                *lengths = Some(VolumeTexture::of_voxels(gpu, &found)?);
            }
        }
        let is_changed = self.thinned != thinned;
        self.thinned = thinned;
        Ok(is_changed)
    }

    /// Takes over the transfer functions and interpolations of `scene`; returns whether anything changed.
    pub fn change(&mut self, scene: &Scene) -> bool {
        let mut is_changed = false;
        for (layer, new) in self.others.iter_mut().zip(&scene.layers) {
            if layer.transfer != new.transfer_function || layer.interpolation != new.interpolation {
                layer.transfer = new.transfer_function.clone();
                layer.interpolation = new.interpolation;
                is_changed = true;
            }
        }
        is_changed
    }

    /// Whether shaders of several volumes are used.
    pub fn are_blended(&self) -> bool {
        self.blends
    }

    /// Transfer functions and interpolations of further volumes.
    pub fn looks(&self) -> LayerLooks {
        self.others.iter().map(|layer| (layer.transfer.clone(), layer.interpolation)).collect()
    }

    /// Where further volumes may show anything, and their transfer functions.
    pub fn cells(&self) -> impl Iterator<Item = (&Macrocells, &TransferFunction)> {
        self.others.iter().map(|layer| (&layer.cells, &layer.transfer))
    }

    /// How shaders are compiled for these and a first volume that may have `gaps`, with its `interpolation`.
    pub fn layering(&self, gaps: bool, interpolation: Interpolation) -> Layering {
        let further = |has: fn(&DeviceLayer) -> bool| bits(self.others.iter().map(has)) << 1;
        let is_float =
            |colours: &Option<ColourTexture>| colours.as_ref().is_some_and(ColourTexture::are_floats);
        Layering {
            volumes: 1 + self.others.len() as u8,
            coloured: bits(self.colours.iter().map(Option::is_some)),
            colour_floats: bits(self.colours.iter().map(is_float)),
            floats: further(|layer| matches!(layer.volume.kind(), TexelKind::Stored { floats: true, .. })),
            gaps: further(|layer| layer.has_gaps) | u8::from(gaps),
            nearest: further(|layer| layer.interpolation == Interpolation::Nearest)
                | u8::from(interpolation == Interpolation::Nearest),
            thinned: self.thinned,
            blends: self.blends,
        }
    }

    /// Tables of the `first` volume and of further ones for primary steps of `step` voxels.
    pub fn tables(&self, first: &TransferFunction, step: f64) -> Vec<BlendTable> {
        let all = std::iter::once(first).chain(self.others.iter().map(|layer| &layer.transfer));
        let tables = all.enumerate().map(|(n, transfer)| match self.thinned >> n & 1 {
            0 => BlendTable::new(transfer, step),
            _ => BlendTable::with_gradient(transfer, step, self.greatest),
        });
        tables.collect()
    }

    /// Numbers of all volumes, whose `tables` lie one after the other; factors by gradient follow the extinctions of all. The scale
    /// of the first is the scene's.
    pub fn numbers(&self, tables: &[BlendTable]) -> [LayerNumbers; MOST_VOLUMES] {
        let mut numbers = [LayerNumbers::zeroed(); MOST_VOLUMES];
        let scales = std::iter::once(0.0).chain(self.others.iter().map(|layer| layer.volume.value_scale()));
        let mut begin = 0;
        let mut factors = tables.iter().map(|table| table.extinction.len() as u32).sum::<u32>();
        let volumes = scales.zip(&self.colours).zip(&self.lengths).zip(tables);
        for (to, (((scale, colours), lengths), table)) in numbers.iter_mut().zip(volumes) {
            *to = LayerNumbers {
                colour_scale: colours.as_ref().map_or([0.0; 3], ColourTexture::scale),
                scale: scale * table.transfer.scale(),
                table: begin,
                last_entry: table.transfer.last() as u32,
                factors,
                step: table.step,
                ..LayerNumbers::zeroed()
            };
            if let (Some(gradient), Some(lengths)) = (&table.gradient, lengths) {
                to.last_factor = gradient.last();
                to.length_scale = gradient.scale * lengths.value_scale();
                factors += gradient.factors.len() as u32;
            }
            begin += table.extinction.len() as u32;
        }
        numbers
    }

    /// The textures of a bind group, in the order of shaders/layers.wgsl.
    pub fn textures(&self) -> [&wgpu::Texture; TEXTURES] {
        std::array::from_fn(|i| {
            let volume = self.others.get(i).map(|layer| layer.volume.texture());
            let colours = |n: usize| self.colours.get(n)?.as_ref().map(ColourTexture::texture);
            let lengths = |n: usize| self.lengths.get(n)?.as_ref().map(VolumeTexture::texture);
            let found = match (i + 1) / MOST_VOLUMES {
                0 => volume,
                1 => colours(i + 1 - MOST_VOLUMES),
                _ => lengths(i + 1 - 2 * MOST_VOLUMES),
            };
            found.unwrap_or(&self.none)
        })
    }
}

impl DeviceLayer {
    fn new(gpu: &Gpu, layer: &Layer) -> Result<Self> {
        // Bricks are freed after the upload.
        let bricks = Bricks::of_volume(&layer.volume).map_err(fovol_core::Error::from)?;
        let cells = Macrocells::new(&bricks).map_err(fovol_core::Error::from)?;
        let volume = VolumeTexture::of_voxels(gpu, &bricks)?;
        Ok(Self {
            has_gaps: bricks.has_gaps(),
            volume,
            cells,
            transfer: layer.transfer_function.clone(),
            interpolation: layer.interpolation,
        })
    }
}

fn colour_texture(gpu: &Gpu, colours: &VoxelColours) -> Result<ColourTexture> {
    let [r, g, b] =
        colours.each_ref().map(|channel| Bricks::of_volume(channel).map_err(fovol_core::Error::from));
    ColourTexture::new(gpu, &[r?, g?, b?])
}

/// Whether shaders of several volumes are needed for `scene`.
pub fn blends(scene: &Scene) -> bool {
    scene.is_layered() || scene.has_gradient_opacity()
}

/// The set of the volumes that have something, in order.
fn bits(have: impl Iterator<Item = bool>) -> u8 {
    have.enumerate().fold(0, |bits, (n, has)| bits | u8::from(has) << n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::shader::{MARCH_LAYERED, SHADOW_GRID_LAYERED};
    use fovol_gpu::assert_twins;

    #[test]
    fn shaders_read_the_same_struct() {
        for shader in [MARCH_LAYERED, SHADOW_GRID_LAYERED] {
            assert_twins!(
                shader,
                "LayerNumbers",
                LayerNumbers {
                    colour_scale,
                    scale,
                    table,
                    last_entry,
                    factors,
                    last_factor,
                    length_scale,
                    step,
                    unused_0,
                    unused_1
                }
            );
        }
    }

    #[test]
    fn sets_have_a_bit_for_each_volume() {
        assert_eq!(bits([true, false, true].into_iter()), 0b101);
        assert_eq!(bits([].into_iter()), 0);
    }
}
