//! Second file of some volume formats, beside the one that the user names.

use fovolnet::io::volume::Beside;

/// Option to replace an existing file in the place of the second one.
#[derive(clap::Args)]
pub struct SecondFile {
    /// Replace a file that nobody named: NAME.raw of .nhdr and .mhd, NAME.json of .raw, where it was not written for them
    #[arg(long)]
    overwrite: bool,
}

impl SecondFile {
    /// Files that may be replaced beside the volume.
    pub fn beside(&self) -> Beside {
        if self.overwrite { Beside::All } else { Beside::Own }
    }
}
