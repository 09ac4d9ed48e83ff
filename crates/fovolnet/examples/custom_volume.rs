//! Renders a volume that the program makes itself, with a transfer function of its own.
//!
//! ```text
//! cargo run --release -p fovolnet --example custom_volume -- waves.png
//! ```

use fovolnet::core::{ControlPoint, FrameSize, Grid, TransferFunction, Volume};
use fovolnet::io::image::{Alpha, write_png};
use fovolnet::{OpenVolume, Pipeline, RenderSettings, SpeedSettings};
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let output = std::env::args().nth(1).unwrap_or_else(|| "waves.png".to_owned());

    // 64 × 48 × 32 voxels, x fastest; slices are twice as far apart as pixels.
    let grid = Grid::new([64, 48, 32], [1.0, 1.0, 2.0])?;
    let values = (0..grid.voxels()).map(|i| {
        let [x, y, z] = [i % 64, i / 64 % 48, i / (64 * 48)].map(|n| n as f32);
        (0.2 * x).sin() * (0.25 * y).cos() * (0.4 * z).sin()
    });
    let volume = OpenVolume::from(Volume::from_values(grid, values.collect::<Vec<f32>>())?);

    let settings = RenderSettings {
        size: FrameSize::new(480, 360)?,
        transfer_function: TransferFunction::new(vec![
            ControlPoint::new(0.5, [0.1, 0.3, 0.9], 0.0),
            ControlPoint::new(0.8, [0.2, 0.8, 0.5], 0.1),
            ControlPoint::new(1.0, [1.0, 0.9, 0.2], 0.6),
        ])?
        .into(),
        ..Default::default()
    };
    let mut pipeline = Pipeline::new(&volume, &settings, &SpeedSettings::default())?;
    write_png(Path::new(&output), &pipeline.render(0)?.frame, Alpha::Drop)?;
    println!("{output}");
    Ok(())
}
