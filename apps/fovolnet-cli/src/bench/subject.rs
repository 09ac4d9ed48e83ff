use crate::picture_arguments::PictureArguments;
use anyhow::{Result, bail};
use fovolnet::core::{Integration, shown_path};
use fovolnet::{OpenVolume, PathChoice, RenderOverrides, RenderSettings, SpeedSettings, open_volume, parse};

/// Measured picture: a volume and its flags.
#[derive(clap::Args)]
pub struct Subject {
    /// Volume file, folder of slices, or procedural volume
    #[arg(default_value = "head", value_parser = parse::file())]
    volume: String,
    #[command(flatten)]
    flags: PictureArguments,
}

impl Subject {
    /// Opens the volume.
    pub fn open(&self) -> Result<OpenVolume> {
        Ok(open_volume(&self.volume, &self.flags.read)?)
    }

    /// Name of the volume, for reports.
    pub fn name(&self) -> String {
        shown_path(&self.volume)
    }

    /// Settings of the picture. Benchmarks have an orbit, plain integration and `frames` frames unless the flags say
    /// otherwise.
    pub fn settings(&self, frames: Option<u32>) -> Result<RenderSettings> {
        let given = &self.flags.settings;
        if given.limit()?.is_some() {
            bail!("benchmarks measure the flags as written; leave out --quality and --budget");
        }
        let has_view = given.camera.is_some() || given.view.is_some();
        let orbit = (!has_view).then_some(PathChoice::Orbit);
        let settings = RenderOverrides {
            frames: given.frames.or(frames),
            path: given.path.clone().or(orbit),
            integration: given.integration.or(Some(Integration::Plain)),
            ..given.clone()
        };
        Ok(settings.resolve()?)
    }

    /// Settings of speed.
    pub fn speed(&self) -> &SpeedSettings {
        &self.flags.speed
    }
}
