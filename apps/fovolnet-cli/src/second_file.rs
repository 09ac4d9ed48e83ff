//! The file that some formats of volumes take besides the one that is named.

use fovolnet::io::volume::Beside;

/// What becomes of a file that lies where the second one would.
#[derive(clap::Args)]
pub struct SecondFile {
    /// Replace a file that nobody named: NAME.raw of .nhdr and .mhd, NAME.json of .raw, where it was not written for them
    #[arg(long)]
    overwrite: bool,
}

impl SecondFile {
    /// What may be replaced beside the volume.
    pub fn beside(&self) -> Beside {
        if self.overwrite { Beside::All } else { Beside::Own }
    }
}
