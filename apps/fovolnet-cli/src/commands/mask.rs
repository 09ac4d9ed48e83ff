use crate::console::JsonOutput;
use crate::outputs;
use anyhow::Result;
use fovolnet::RenderOverrides;
use fovolnet::core::{Fovea, SampleMask};
use fovolnet::io::{atomic, image};
use fovolnet::render::cpu;
use fovolnet::render::noise::Noise;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Write the sample map of one frame
#[derive(clap::Args)]
pub struct Mask {
    /// PNG to write: white where a pixel is sampled
    #[arg(short, long, value_name = "MASK.png")]
    output: PathBuf,
    #[command(flatten)]
    settings: RenderOverrides,
    #[command(flatten)]
    json: JsonOutput,
}

#[derive(Serialize)]
struct Report {
    samples: usize,
    density: f64,
    expected_density: f64,
}

impl Mask {
    pub fn run(self) -> Result<()> {
        let (fovea, mask) = mask_of(self.settings)?;
        outputs::check([Some(&*self.output), self.json.file()].into_iter().flatten())?;
        write(&self.output, &mask)?;
        let report = Report {
            samples: mask.count(),
            density: mask.density(),
            expected_density: fovea.expected_density(mask.size()),
        };
        self.json.say(format!(
            "{}: {} of {} pixels sampled, density {:.4} (expected {:.4})",
            self.output.display(),
            report.samples,
            mask.size().pixels(),
            report.density,
            report.expected_density
        ))?;
        self.json.write(&report)
    }
}

fn mask_of(settings: RenderOverrides) -> Result<(Fovea, SampleMask)> {
    // Masks do not depend on the camera, so the file of a path is not read.
    let settings = RenderOverrides { path: None, ..settings }.resolve()?;
    let frame = settings.first_frame;
    let fovea = settings.fovea(frame)?;
    let noise = Noise::new(settings.noise, settings.seed);
    Ok((fovea, cpu::mask(&fovea, settings.size, &noise, frame)))
}

/// Writes `mask` as PNG; sampled pixels are white.
pub fn write(path: &Path, mask: &SampleMask) -> Result<()> {
    if let Some(folder) = path.parent().filter(|p| !p.as_os_str().is_empty()) {
        atomic::make_folder(folder)?;
    }
    let size = mask.size();
    let bytes: Vec<u8> = (0..size.height)
        .flat_map(|y| (0..size.width).map(move |x| (x, y)))
        .map(|(x, y)| if mask.contains(x, y) { 255 } else { 0 })
        .collect();
    image::write_grey_png(path, size, &bytes)?;
    Ok(())
}
