use crate::console::{JsonOutput, Progress};
use crate::interrupt;
use anyhow::{Result, bail};
use fovolnet::Reconstruction;
use fovolnet::core::{Frame, SampleMask};
use fovolnet::io::image::{self, Alpha};
use fovolnet::io::{Error, atomic};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Fill sparse frames of any renderer
#[derive(clap::Args)]
pub struct Reconstruct {
    /// Folder of RGBA pictures sparse_0000.png, … (or .exr); alpha marks the sampled pixels
    sparse: PathBuf,
    /// Folder for the full frames
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// How frames are filled: pull-push or linear
    #[arg(long, value_name = "HOW", default_value = "pull-push")]
    reconstruct: Reconstruction,
    #[command(flatten)]
    json: JsonOutput,
}

#[derive(Serialize)]
struct FrameFigures {
    file: String,
    samples: usize,
    density: f64,
    ms: f64,
}

#[derive(Serialize)]
struct Report {
    reconstruct: String,
    frames: Vec<FrameFigures>,
}

impl Reconstruct {
    pub fn run(self) -> Result<()> {
        let Reconstruction::Fill(fill) = self.reconstruct else {
            bail!("`none` reconstructs nothing; use --reconstruct pull-push or linear");
        };
        let files = frames_named(&self.sparse, "sparse_")?;
        atomic::make_folder(&self.output)?;
        let mut progress = Progress::new("reconstructing", files.len() as u64);
        let mut frames = Vec::new();
        for path in &files {
            interrupt::check(&format!("{} complete frames are in {}", frames.len(), self.output.display()))?;
            let sparse = image::read(path)?;
            let mask = SampleMask::of_sparse_frame(&sparse);
            let started = Instant::now();
            let full = fill.reconstruct(&sparse);
            let ms = started.elapsed().as_secs_f64() * 1e3;
            frames.push(FrameFigures {
                file: self.write(path, &full)?,
                samples: mask.count(),
                density: mask.density(),
                ms,
            });
            progress.step();
        }
        drop(progress);
        self.json.say(format!("{} frames in {}", frames.len(), self.output.display()))?;
        self.json.write(&Report { reconstruct: self.reconstruct.to_string(), frames })
    }

    fn write(&self, sparse: &Path, full: &Frame) -> Result<String> {
        let name = sparse.file_name().unwrap_or_default().to_string_lossy().replacen("sparse_", "frame_", 1);
        let path = self.output.join(&name);
        if name.ends_with(".exr") {
            image::write_exr(&path, full)?;
        } else {
            image::write_png(&path, full, Alpha::Drop)?;
        }
        Ok(name)
    }
}

/// The pictures in `folder` whose names begin with `prefix`, sorted by name.
pub fn frames_named(folder: &Path, prefix: &str) -> Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder).map_err(|e| Error::io("read", folder, e))?;
    let mut files = Vec::new();
    for entry in entries {
        let path = entry.map_err(|e| Error::io("read", folder, e))?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let is_picture =
            [".png", ".exr", ".jpg", ".jpeg", ".bmp"].iter().any(|e| name.to_lowercase().ends_with(e));
        if name.starts_with(prefix) && is_picture {
            files.push(path);
        }
    }
    if files.is_empty() {
        bail!("{}: there are no pictures {prefix}0000.png, … in it; check the folder", folder.display());
    }
    files.sort();
    Ok(files)
}
