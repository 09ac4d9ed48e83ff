//! The model of a GPU: its rays are those of the specification, and its figures for the head stay within limits.

use fovolnet::core::{
    CameraPath, Fovea, FrameSize, Grid, Integration, Pixel, Scene, TransferFunction, Volume,
};
use fovolnet::render::cpu::{self, RenderOptions, Simd};
use fovolnet::render::model::{GpuModel, MarchCost, Order, Replay, Work, cost};
use fovolnet::render::noise::{Noise, NoiseKind};
use fovolnet::{RenderSettings, VolumeSettings, open_volume, scene};
use std::sync::LazyLock;

const POOL: Work = Work::Pool { rays: 4, threads: 128, queue: 128 };

/// The head of 96³ voxels, marched plainly.
static HEAD: LazyLock<Scene> = LazyLock::new(|| {
    let read = VolumeSettings { dims: Some([96; 3]), ..VolumeSettings::default() };
    let settings = RenderSettings { integration: Integration::Plain, ..RenderSettings::default() };
    scene(&open_volume("head", &read).unwrap(), &settings).unwrap()
});

fn sampled(size: FrameSize) -> Vec<Pixel> {
    let fovea = Fovea { base: 0.03, sigma: 0.02, ..Fovea::default() };
    cpu::compact(&cpu::mask(&fovea, size, &Noise::new(NoiseKind::Stbn, 0), 0)).pixels().to_vec()
}

fn costs(order: Order, work: Work, columns: bool) -> MarchCost {
    let size = FrameSize::new(320, 180).unwrap();
    let replay = Replay::new(&HEAD).unwrap();
    let gpu = GpuModel::named("H200").unwrap();
    let camera = CameraPath::Orbit.camera(0);
    cost((&replay, &gpu), (&camera, size), (&sampled(size), order), (work, columns))
}

#[test]
fn rays_have_the_samples_of_the_specification() {
    let replay = Replay::new(&HEAD).unwrap();
    let size = FrameSize::new(40, 30).unwrap();
    let options = RenderOptions { simd: Simd::Scalar, skip_empty: true };
    let renderer = cpu::Renderer::new(&HEAD, options).unwrap();
    for camera in [0, 90, 210].map(|frame| CameraPath::Orbit.camera(frame)) {
        let rays = camera.rays(size);
        let [mut primary, mut shadow] = [0u64; 2];
        for y in 0..size.height {
            for x in 0..size.width {
                let [lit, shadows] = replay.visible_samples(&replay.segment(&rays.ray(x, y)));
                primary += lit;
                shadow += shadows;
            }
        }
        let (_, count) = renderer.march_full(&camera, size);
        // The specification also counts samples that show nothing.
        assert!(
            primary > 0 && primary <= count.primary && shadow <= count.shadow,
            "{primary} {shadow} {count:?}"
        );
        assert!(primary * 20 > count.primary, "{primary} {count:?}");
    }
}

#[test]
fn pools_cut_the_longest_chain_and_keep_lanes_busy() {
    let [rays, pool] = [Work::Rays, POOL].map(|work| costs(Order::Tiles, work, false));
    assert!(20 * pool.longest_chain <= rays.longest_chain, "{pool:?} {rays:?}");
    assert!(pool.busy_lanes >= 0.55, "{pool:?}");
    assert!(pool.ms < rays.ms, "{pool:?} {rays:?}");
}

#[test]
fn columns_save_the_looks_of_shadow_rays() {
    let [without, with] = [false, true].map(|columns| costs(Order::Tiles, POOL, columns));
    assert!(with.loads_per_shadow_step <= 2.1 && without.loads_per_shadow_step > 2.3, "{with:?} {without:?}");
}

#[test]
fn lists_in_tiles_have_fewer_steps_than_rows() {
    let [raster, tiles] = [Order::Raster, Order::Tiles].map(|order| costs(order, Work::Rays, false));
    assert!(tiles.warp_steps as f64 * 1.8 <= raster.warp_steps as f64, "{tiles:?} {raster:?}");
}

#[test]
fn nothing_costs_nothing() {
    let volume = Volume::from_values(Grid::new([4; 3], [1.0; 3]).unwrap(), vec![0u8; 64]).unwrap();
    let replay = Replay::new(&Scene::new(volume.into(), TransferFunction::grey_ramp(0.5))).unwrap();
    let size = FrameSize::new(16, 16).unwrap();
    let gpu = GpuModel::ALL[0];
    for work in [Work::Rays, POOL] {
        let found = cost(
            (&replay, &gpu),
            (&CameraPath::Orbit.camera(0), size),
            (&sampled(size), Order::Tiles),
            (work, true),
        );
        assert_eq!((found.busy_lanes, found.loads_per_shadow_step), (0.0, 0.0));
        let none =
            cost((&replay, &gpu), (&CameraPath::Orbit.camera(0), size), (&[], Order::Tiles), (work, true));
        assert_eq!((none.longest_chain, none.warp_steps, none.ms), (0, 0, 0.0));
    }
    assert!(GpuModel::named("h300").is_none());
}
