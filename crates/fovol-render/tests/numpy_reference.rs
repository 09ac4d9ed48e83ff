//! Every marcher against pictures from an independent float64 implementation of the specification's
//! section on image formation, `tests/reference/render/reference.py`, and the files it wrote.

use flate2::read::GzDecoder;
use fovol_core::{
    Camera, CameraPath, ClipBox, ClipPlane, ClipPlanes, ControlPoint, Dtype, FrameSize, GradientOpacity,
    Grid, Interpolation, Layer, Light, RayMode, Scene, Shading, ShadowMode, SurfaceShading, TransferFunction,
    Volume,
};
use fovol_render::cpu::{RenderOptions, Renderer, available_simd};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// `cases.json`.
#[derive(Deserialize)]
struct Cases {
    /// Levels of a stored channel: value = level / levels.
    levels: f64,
    volumes: BTreeMap<String, VolumeCase>,
    transfer_functions: BTreeMap<String, Vec<ControlPoint>>,
    pictures: BTreeMap<String, PictureCase>,
}

#[derive(Deserialize)]
struct VolumeCase {
    dtype: String,
    dims: [usize; 3],
    spacing: [f64; 3],
    /// The shown range, as `--range` gives it; `None` stands for the volume's own range.
    range: Option<[f64; 2]>,
    /// Whether the voxels lie beside `cases.json`; otherwise in the folder of published volumes.
    stored: bool,
}

#[derive(Deserialize)]
struct PictureCase {
    volume: String,
    transfer_function: String,
    camera: CameraCase,
    light: Light,
    ambient: f64,
    background: [f64; 3],
    size: [u32; 2],
    shadows: bool,
    gradient: bool,
    step: f64,
    mode: Option<String>,
    #[serde(default)]
    interpolation: Interpolation,
    /// The data value of the isosurface.
    iso: Option<f64>,
    /// Planes that clip: a normal and a distance.
    #[serde(default)]
    planes: Vec<[f64; 4]>,
    /// Axes along which the volume is mirrored for red, green and blue of its voxels.
    colours: Option<[usize; 3]>,
    /// Points of gradient and factor of the opacity.
    gradient_opacity: Option<Vec<[f64; 2]>>,
    #[serde(default)]
    layers: Vec<LayerCase>,
}

/// A further volume: the first one, mirrored along an axis.
#[derive(Deserialize)]
struct LayerCase {
    mirrored: usize,
    transfer_function: String,
    interpolation: Interpolation,
    gradient_opacity: Option<Vec<[f64; 2]>>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum CameraCase {
    Along { path: CameraPath, frame: u32 },
    Still(Camera),
}

impl CameraCase {
    fn camera(&self) -> Camera {
        match self {
            Self::Along { path, frame } => path.camera(*frame),
            Self::Still(camera) => *camera,
        }
    }
}

impl VolumeCase {
    fn read(&self, file: &Path) -> Volume {
        let grid = Grid::new(self.dims, self.spacing).unwrap();
        let bytes = gunzip(file);
        let volume = match self.dtype.as_str() {
            "u8" => Volume::from_values(grid, bytes),
            "i16" => Volume::from_values(grid, values(&bytes, i16::from_le_bytes)),
            "f32" => Volume::from_values(grid, values(&bytes, f32::from_le_bytes)),
            other => panic!("cases.json has voxels of type {other}, which this test does not read"),
        }
        .unwrap();
        match self.range {
            Some(range) => volume.with_range(range).unwrap(),
            None => volume,
        }
    }
}

impl PictureCase {
    fn scene(&self, cases: &Cases, volume: &Arc<Volume>) -> Scene {
        let function = |name: &str, gradient: &Option<Vec<[f64; 2]>>| {
            let gradient = gradient.clone().map(|points| GradientOpacity::new(points).unwrap());
            TransferFunction::new(cases.transfer_functions[name].clone()).unwrap().with_gradient(gradient)
        };
        let layer = |layer: &LayerCase| Layer {
            volume: mirrored(volume, layer.mirrored),
            transfer_function: function(&layer.transfer_function, &layer.gradient_opacity),
            colours: None,
            interpolation: layer.interpolation,
        };
        let plane = |[x, y, z, distance]: [f64; 4]| ClipPlane { normal: [x, y, z].into(), distance };
        let planes: Vec<ClipPlane> = self.planes.iter().map(|numbers| plane(*numbers)).collect();
        Scene {
            shading: Shading {
                light: self.light,
                ambient: self.ambient,
                shadows: if self.shadows { ShadowMode::On } else { ShadowMode::Off },
                surface: if self.gradient { SurfaceShading::Gradient } else { SurfaceShading::Flat },
            },
            background: self.background,
            step: self.step,
            interpolation: self.interpolation,
            mode: self.mode(volume),
            clip: Some(ClipBox::whole(volume.grid()).with_planes(ClipPlanes::new(&planes).unwrap())),
            colours: self.colours.map(|axes| axes.map(|axis| mirrored(volume, axis))),
            layers: self.layers.iter().map(layer).collect(),
            ..Scene::new(volume.clone(), function(&self.transfer_function, &self.gradient_opacity))
        }
    }
}

impl PictureCase {
    fn mode(&self, volume: &Volume) -> RayMode {
        match self.mode.as_deref() {
            None => RayMode::Composite,
            Some("mip") => RayMode::Mip,
            Some("minip") => RayMode::Minip,
            Some("average") => RayMode::Average,
            Some("isosurface") => RayMode::Isosurface(volume.normalised(self.iso.unwrap()) as f32),
            Some(other) => panic!("cases.json has mode {other}, which this test does not know"),
        }
    }
}

/// `volume` mirrored along `axis`, shown over the same range.
fn mirrored(volume: &Volume, axis: usize) -> Arc<Volume> {
    let [nx, ny, nz] = volume.grid().dims();
    let mut values = Vec::new();
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                let mut voxel = [x, y, z];
                voxel[axis] = volume.grid().dims()[axis] - 1 - voxel[axis];
                values.push(volume.value(voxel));
            }
        }
    }
    let mirrored = match volume.dtype() {
        Dtype::U8 => Volume::from_values(*volume.grid(), values.iter().map(|v| *v as u8).collect()),
        Dtype::I16 => Volume::from_values(*volume.grid(), values.iter().map(|v| *v as i16).collect()),
        _ => Volume::from_values(*volume.grid(), values.iter().map(|v| *v as f32).collect()),
    };
    Arc::new(mirrored.unwrap().with_range(volume.range()).unwrap())
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/reference/render")
}

/// The folder of published volumes, where it is there.
fn published() -> Option<PathBuf> {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");
    let folder = std::env::var_os("FOVOL_TEST_DATA").map_or_else(|| beside.into(), PathBuf::from);
    Some(folder.join("volumes")).filter(|f| f.is_dir())
}

fn gunzip(file: &Path) -> Vec<u8> {
    let mut bytes = Vec::new();
    let open = File::open(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    GzDecoder::new(open).read_to_end(&mut bytes).unwrap();
    bytes
}

fn values<const N: usize, T>(bytes: &[u8], value: fn([u8; N]) -> T) -> Vec<T> {
    let (chunks, rest) = bytes.as_chunks::<N>();
    assert!(rest.is_empty());
    chunks.iter().map(|&chunk| value(chunk)).collect()
}

fn cases() -> Cases {
    serde_json::from_slice(&std::fs::read(folder().join("cases.json")).unwrap()).unwrap()
}

/// How far a picture is from the reference, over all channels.
struct Difference {
    p999: f64,
    most: f64,
    mean: f64,
}

impl Difference {
    fn between(expected: &[f64], pixels: &[[f32; 4]]) -> Self {
        assert_eq!(expected.len(), pixels.len() * 3);
        let channels = pixels.iter().flat_map(|p| &p[..3]);
        let mut all: Vec<f64> =
            expected.iter().zip(channels).map(|(e, &c)| (e - f64::from(c)).abs()).collect();
        all.sort_by(f64::total_cmp);
        Self {
            p999: all[all.len() * 999 / 1000],
            most: all[all.len() - 1],
            mean: all.iter().sum::<f64>() / all.len() as f64,
        }
    }

    /// The specification's tolerance.
    fn is_small(&self) -> bool {
        self.p999 <= 1.0 / 255.0 && self.most <= 8.0 / 255.0 && self.mean <= 1e-3
    }
}

/// Renders a picture in every way that the CPU has, and says what is out of tolerance.
fn compare(cases: &Cases, name: &str, volume: &Arc<Volume>, failures: &mut Vec<String>) {
    let case = &cases.pictures[name];
    let stored = gunzip(&folder().join(format!("picture_{name}.gz")));
    let expected: Vec<f64> = values(&stored, u16::from_le_bytes)
        .into_iter()
        .map(|level| f64::from(level) / cases.levels)
        .collect();
    let size = FrameSize::new(case.size[0], case.size[1]).unwrap();
    let camera = case.camera.camera();
    let mut renderer = Renderer::new(&case.scene(cases, volume), RenderOptions::default()).unwrap();
    for simd in available_simd() {
        for skip_empty in [false, true] {
            renderer.set_options(RenderOptions { simd, skip_empty });
            let (frame, _) = renderer.march_full(&camera, size);
            let difference = Difference::between(&expected, frame.pixels());
            let line = format!(
                "{name:24} {:9} {:8} p99.9 {:.6}  most {:.6}  mean {:.7}",
                simd.name(),
                if skip_empty { "skipping" } else { "" },
                difference.p999,
                difference.most,
                difference.mean,
            );
            println!("{line}");
            if !difference.is_small() {
                failures.push(line);
            }
        }
    }
}

/// Compares the pictures of the volumes whose voxels `locate` finds.
fn compare_all(locate: impl Fn(&str, &VolumeCase) -> Option<PathBuf>) {
    let cases = cases();
    let mut failures = Vec::new();
    let mut compared = 0;
    for (volume_name, volume_case) in &cases.volumes {
        let Some(file) = locate(volume_name, volume_case) else { continue };
        let volume = Arc::new(volume_case.read(&file));
        for (name, _) in cases.pictures.iter().filter(|(_, picture)| picture.volume == *volume_name) {
            compare(&cases, name, &volume, &mut failures);
            compared += 1;
        }
    }
    assert!(compared > 0, "no picture was compared");
    assert!(failures.is_empty(), "out of tolerance:\n{}", failures.join("\n"));
}

#[test]
fn volumes_by_formula_look_as_in_numpy() {
    compare_all(|name, case| case.stored.then(|| folder().join(format!("volume_{name}.gz"))));
}

#[test]
fn published_volumes_look_as_in_numpy() {
    let Some(data) = published() else {
        println!("skipped: no data; set FOVOL_TEST_DATA to a folder that has volumes/NAME.raw.gz");
        return;
    };
    compare_all(|name, case| {
        let file = data.join(format!("{name}.raw.gz"));
        if !case.stored && !file.exists() {
            println!("skipped: no data at {}", file.display());
        }
        (!case.stored && file.exists()).then_some(file)
    });
}
