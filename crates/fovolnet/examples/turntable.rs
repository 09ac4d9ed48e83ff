//! Renders a turntable clip of a volume. 5 % of the pixels are marched, and a network reconstructs the rest.
//!
//! ```text
//! cargo run --release -p fovolnet --example turntable -- head turn.y4m 24
//! ```

use fovolnet::core::FrameSize;
use fovolnet::io::video::VideoWriter;
use fovolnet::{
    CameraChoice, Pipeline, Reconstruction, RenderSettings, Sampling, SpeedSettings, VolumeSettings,
    open_volume,
};
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let source = arguments.next().unwrap_or_else(|| "head".to_owned());
    let output = arguments.next().unwrap_or_else(|| "turn.y4m".to_owned());
    let frames: u32 = arguments.next().map_or(Ok(24), |count| count.parse())?;

    let volume = open_volume(&source, &VolumeSettings::default())?;
    let settings = RenderSettings {
        size: FrameSize::new(480, 360)?,
        frames,
        camera: CameraChoice::Turntable,
        sampling: Sampling::Compact,
        reconstruction: Reconstruction::WNet,
        pb: 0.05,
        ..Default::default()
    };
    let mut pipeline = Pipeline::new(&volume, &settings, &SpeedSettings::default())?;
    let mut clip = VideoWriter::create(Path::new(&output), pipeline.size(), 24_u32)?;
    for i in 0..frames {
        clip.push(&pipeline.render(i)?.frame)?;
    }
    println!("{}", clip.finish()?.display());
    Ok(())
}
