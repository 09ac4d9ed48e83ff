//! Further volumes of a scene, and colours of voxels, on the device. Twin of shaders/layers.wgsl.

use super::error::Result;
use super::texture::texture;
use super::volume_texture::{ColourTexture, TexelKind, VolumeTexture};
use crate::scene::{BlendTable, Bricks, Macrocells};
use bytemuck::{Pod, Zeroable};
use fovol_core::{Interpolation, Layer, MOST_VOLUMES, Scene, TransferFunction, VoxelColours};
use fovol_gpu::Gpu;
use wgpu::{TextureFormat, TextureUsages};

/// Textures of a bind group of layers: three further volumes, and the colours of four.
pub const TEXTURES: usize = 2 * MOST_VOLUMES - 1;

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
}

impl Layering {
    /// Whether samples blend several volumes, or have colours of their own.
    pub fn are_blended(self) -> bool {
        self.volumes > 1 || self.coloured != 0
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
    unused_0: u32,
    unused_1: u32,
}

/// A further volume.
#[derive(Debug)]
struct DeviceLayer {
    volume: VolumeTexture,
    /// The factor from texels to display values.
    value_scale: f32,
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
        Ok(Self { others, colours, none })
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

    /// Whether samples blend several volumes, or have colours of their own.
    pub fn are_blended(&self) -> bool {
        !self.others.is_empty() || self.colours.iter().any(Option::is_some)
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
        }
    }

    /// Tables of the further volumes for primary steps of `step` voxels.
    pub fn tables(&self, step: f64) -> impl Iterator<Item = BlendTable> {
        self.others.iter().map(move |layer| BlendTable::new(&layer.transfer, step))
    }

    /// Numbers of all volumes, whose `tables` lie one after the other. The scale of the first is the scene's.
    pub fn numbers(&self, tables: &[BlendTable]) -> [LayerNumbers; MOST_VOLUMES] {
        let mut numbers = [LayerNumbers::zeroed(); MOST_VOLUMES];
        let scales = std::iter::once(0.0).chain(self.others.iter().map(|layer| layer.value_scale));
        let mut begin = 0;
        for (((to, scale), colours), table) in numbers.iter_mut().zip(scales).zip(&self.colours).zip(tables) {
            *to = LayerNumbers {
                colour_scale: colours.as_ref().map_or([0.0; 3], ColourTexture::scale),
                scale: scale * table.transfer.scale(),
                table: begin,
                last_entry: table.transfer.last() as u32,
                ..LayerNumbers::zeroed()
            };
            begin += table.extinction.len() as u32;
        }
        numbers
    }

    /// The textures of a bind group, in the order of shaders/layers.wgsl.
    pub fn textures(&self) -> [&wgpu::Texture; TEXTURES] {
        std::array::from_fn(|i| {
            let volume = self.others.get(i).map(|layer| layer.volume.texture());
            let colours = || self.colours.get(i + 1 - MOST_VOLUMES)?.as_ref().map(ColourTexture::texture);
            let found = if i + 1 < MOST_VOLUMES { volume } else { colours() };
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
            value_scale: bricks.scale() * volume.unit(),
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
                LayerNumbers { colour_scale, scale, table, last_entry, unused_0, unused_1 }
            );
        }
    }

    #[test]
    fn sets_have_a_bit_for_each_volume() {
        assert_eq!(bits([true, false, true].into_iter()), 0b101);
        assert_eq!(bits([].into_iter()), 0);
    }
}
