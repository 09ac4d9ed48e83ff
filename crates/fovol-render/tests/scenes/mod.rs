//! Scenes and cameras on which marchers are compared, and the comparison of their frames.

use fovol_core::{Camera, CameraPath, ControlPoint, Frame, Grid, TransferFunction, Volume};

/// A dented ball with a hollow and a surrounding haze, as values of 0…1.
fn ball(dims: [usize; 3]) -> Vec<f64> {
    let centred = |i: usize, n: usize| (i as f64 + 0.5) / n as f64 * 2.0 - 1.0;
    let mut values = Vec::new();
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                let (x, y, z) = (centred(x, dims[0]), centred(y, dims[1]), centred(z, dims[2]));
                let r = (x * x + y * y + z * z).sqrt() + 0.08 * (9.0 * x).sin() * (7.0 * y).cos();
                let shell = (-((r - 0.6) / 0.15).powi(2)).exp();
                values.push((0.8 * shell + 0.15 * (-4.0 * (r - 0.2).powi(2)).exp()).clamp(0.0, 1.0));
            }
        }
    }
    values
}

/// A volume for each way to store voxels.
pub fn volumes() -> Vec<(&'static str, Volume)> {
    let cube = Grid::new([45, 38, 50], [1.0; 3]).unwrap();
    let flat = Grid::new([40, 33, 17], [0.7, 0.9, 2.5]).unwrap();
    let bytes = ball(cube.dims()).iter().map(|v| (v * 255.0) as u8).collect();
    let shorts = ball(flat.dims()).iter().map(|v| (v * 4000.0) as i16 - 1024).collect();
    let floats = ball(cube.dims()).iter().map(|v| (v * 3.7 - 1.0) as f32).collect();
    vec![
        ("u8", Volume::from_values(cube, bytes).unwrap()),
        ("i16, anisotropic", Volume::from_values(flat, shorts).unwrap()),
        ("f32", Volume::from_values(cube, floats).unwrap()),
    ]
}

/// Haze around something dense.
pub fn transfer() -> TransferFunction {
    let p = ControlPoint::new;
    TransferFunction::new(vec![
        p(0.0, [0.1, 0.2, 0.6], 0.0),
        p(0.25, [0.2, 0.4, 0.9], 0.0),
        p(0.4, [0.9, 0.6, 0.2], 0.08),
        p(0.7, [1.0, 0.9, 0.7], 0.6),
        p(1.0, [1.0, 1.0, 1.0], 0.9),
    ])
    .unwrap()
}

/// 99.9th percentile, maximum and mean of the channel differences.
pub fn differences(a: &Frame, b: &Frame) -> (f32, f32, f64) {
    let mut all: Vec<f32> = a
        .pixels()
        .iter()
        .zip(b.pixels())
        .flat_map(|(a, b)| (0..3).map(move |c| (a[c] - b[c]).abs()))
        .collect();
    all.sort_by(f32::total_cmp);
    let mean = all.iter().map(|&d| f64::from(d)).sum::<f64>() / all.len() as f64;
    (all[all.len() * 999 / 1000], all[all.len() - 1], mean)
}

/// From outside, from inside the box, and along an axis (two components of the direction near 0).
pub fn cameras() -> [Camera; 3] {
    [
        CameraPath::Orbit.camera(70),
        Camera::on_sphere(200.0, 10.0, 0.3, 70.0),
        Camera::on_sphere(0.0, 0.0, 1.9, 35.0),
    ]
}
