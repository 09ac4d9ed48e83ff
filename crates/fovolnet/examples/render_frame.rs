//! Renders one frame of a volume to a PNG file, every pixel marched, with shadows.
//!
//! ```text
//! cargo run --release -p fovolnet --example render_frame -- head head.png
//! ```

use fovolnet::core::{FrameSize, ShadowMode};
use fovolnet::io::image::{Alpha, write_png};
use fovolnet::{Pipeline, RenderSettings, SpeedSettings, VolumeSettings, open_volume};
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let source = arguments.next().unwrap_or_else(|| "head".to_owned());
    let output = arguments.next().unwrap_or_else(|| "frame.png".to_owned());

    let volume = open_volume(&source, &VolumeSettings::default())?;
    let settings = RenderSettings {
        size: FrameSize::new(640, 480)?,
        shadows: ShadowMode::On,
        background: [1.0, 1.0, 1.0],
        ..RenderSettings::default()
    };
    let mut pipeline = Pipeline::new(&volume, &settings, &SpeedSettings::default())?;
    let rendered = pipeline.render(0)?;
    write_png(Path::new(&output), &rendered.frame, Alpha::Drop)?;
    println!("{output}: {} of {} pixels marched", rendered.samples, rendered.frame.size().pixels());
    Ok(())
}
