//! Fills sparse frames of any renderer with a network. Here 8 % of the pixels of five frames are marched.
//!
//! ```text
//! cargo run --release -p fovolnet --example reconstruct_sparse -- sparse
//! ```

use fovolnet::core::{FrameSize, SparseFrame};
use fovolnet::io::image::{Alpha, write_png};
use fovolnet::metrics::psnr;
use fovolnet::{
    Pipeline, Reconstruction, Reconstructor, RenderSettings, Sampling, SpeedSettings, VolumeSettings,
    open_volume,
};
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "sparse".to_owned()));
    std::fs::create_dir_all(&folder)?;
    let size = FrameSize::new(320, 240)?;

    // Any renderer will do: `SparseFrame::new` takes pixels, colours and depths, and `SparseFrame::from` a picture with
    // alpha 1 at samples and 0 elsewhere.
    let volume = open_volume("head", &VolumeSettings { dims: Some([64; 3]), ..Default::default() })?;
    let shared = RenderSettings { size, frames: 5, ..Default::default() };
    let sparse = RenderSettings {
        sampling: Sampling::Compact,
        reconstruction: Reconstruction::None,
        pb: 0.08,
        ..shared.clone()
    };
    let full = RenderSettings { sampling: Sampling::Full, ..shared };
    let mut renderer = Pipeline::new(&volume, &sparse, &SpeedSettings::default())?;
    let mut reference = Pipeline::new(&volume, &full, &SpeedSettings::default())?;

    let network = RenderSettings { reconstruction: Reconstruction::WNet, ..Default::default() };
    let mut reconstructor = Reconstructor::new(&network, size)?;
    for i in 0..5 {
        let sparse = SparseFrame::from(&renderer.render(i)?.frame);
        // Nothing moves here, so there is no motion to pass. The reconstructor keeps the state between frames.
        let filled = reconstructor.reconstruct(&sparse, None)?;
        write_png(&folder.join(format!("frame_{i:04}.png")), &filled, Alpha::Drop)?;
        println!("frame {i}: {:.1} dB", psnr(&reference.render(i)?.frame, &filled)?);
    }
    Ok(())
}
