//! Renders one picture of a volume that is made in memory.
//!
//! ```text
//! cargo run --release -- gyroid.ppm
//! ```

use fovolnet::core::{Grid, Volume};
use fovolnet::{OpenVolume, Pipeline, RenderSettings, SpeedSettings};
use std::error::Error;
use std::fs;

fn main() -> Result<(), Box<dyn Error>> {
    let output = std::env::args().nth(1).unwrap_or_else(|| "gyroid.ppm".to_owned());

    // 64³ voxels, x fastest.
    let grid = Grid::new([64; 3], [1.0; 3])?;
    let values = (0..grid.voxels()).map(|i| {
        let [x, y, z] = [i % 64, i / 64 % 64, i / (64 * 64)].map(|n| n as f32 / 6.0);
        x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos()
    });
    let volume = OpenVolume::from(Volume::from_values(grid, values.collect::<Vec<f32>>())?);

    let mut pipeline = Pipeline::new(&volume, &RenderSettings::default(), &SpeedSettings::default())?;
    let frame = pipeline.render(0)?.frame;

    let size = frame.size();
    let header = format!("P6 {} {} 255\n", size.width, size.height);
    fs::write(&output, [header.into_bytes(), frame.to_rgb8()].concat())?;
    println!("{output}");
    Ok(())
}
