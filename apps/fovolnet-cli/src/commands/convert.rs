use crate::second_file::SecondFile;
use crate::{console, outputs};
use anyhow::Result;
use fovolnet::{VolumeSettings, io::volume, open_single_volume, parse};
use std::path::PathBuf;

/// Convert between volume formats
#[derive(clap::Args)]
pub struct Convert {
    /// Volume file, folder of slices, or procedural volume
    #[arg(value_parser = parse::file())]
    input: String,
    /// File to write: .raw .raw.gz .nrrd .nhdr .nii .nii.gz .mha .mhd .vti
    output: PathBuf,
    #[command(flatten)]
    second: SecondFile,
    #[command(flatten)]
    read: VolumeSettings,
}

impl Convert {
    pub fn run(self) -> Result<()> {
        let opened = open_single_volume(&self.input, &self.read)?;
        console::remark(&opened);
        outputs::check([&*self.output])?;
        let notes = volume::write_with(&opened.volume, &self.output, self.second.beside())?;
        console::notes_of(&self.output, &notes);
        console::say(format!("wrote {}", self.output.display()))
    }
}
