use anyhow::{Result, bail};
use fovolnet::core::{did_you_mean, path_of_text};
use fovolnet::io::procedural::{self, Procedural};
use fovolnet::{OpenVolume, TransferChoice, VolumeSettings, open_volume};

/// Volume with its transfer function.
#[derive(Debug, Clone, PartialEq)]
pub struct DataSet {
    /// Short unique name.
    pub name: String,
    source: String,
    read: VolumeSettings,
    /// Transfer function.
    pub transfer: TransferChoice,
}

/// Default number of voxels along each side of procedural volumes.
const SIDE: usize = 128;

impl DataSet {
    /// Parses `VOLUME[@TF]`. The volume is a file, a folder, or a procedural volume as NAME or NAME:SIDE.
    pub fn parse(text: &str) -> Result<Self> {
        let (source, transfer) = match text.rsplit_once('@') {
            Some((source, transfer)) if !path_of_text(text).exists() => (source, transfer.into()),
            _ => (text, TransferChoice::Auto),
        };
        let path = path_of_text(source);
        if path.exists() {
            let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let name = file.split(['.', '_']).next().unwrap_or(&file).to_owned();
            return Ok(Self { name, source: source.into(), read: VolumeSettings::default(), transfer });
        }
        let (name, side) =
            source.split_once(':').map_or((source, Ok(SIDE)), |(name, side)| (name, side.parse()));
        match (name.parse::<Procedural>(), side) {
            (Ok(kind), Ok(side)) => Ok(Self { transfer, ..Self::made(kind, side) }),
            _ => bail!(
                "`{text}` is neither a file nor a procedural volume; give a file, or NAME or NAME:SIDE of `fovolnet data list`{}",
                did_you_mean(name, &procedural::names())
            ),
        }
    }

    fn made(kind: Procedural, side: usize) -> Self {
        let read = VolumeSettings { dims: Some([side; 3]), ..VolumeSettings::default() };
        Self { name: kind.name().into(), source: kind.name().into(), read, transfer: TransferChoice::Auto }
    }

    pub fn open(&self) -> Result<OpenVolume> {
        Ok(open_volume(&self.source, &self.read)?)
    }
}

/// Every procedural volume.
pub fn procedural() -> Vec<DataSet> {
    Procedural::ALL.map(|kind| DataSet::made(kind, SIDE)).to_vec()
}

/// Three small procedural volumes.
pub fn few() -> Vec<DataSet> {
    [(Procedural::Vortices, 64), (Procedural::Head, 96), (Procedural::Supernova, 96)]
        .map(|(kind, side)| DataSet::made(kind, side))
        .to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn volumes_are_named_with_side_and_transfer_function() {
        let head = DataSet::parse("head:64@viridis").unwrap();
        assert_eq!((head.name.as_str(), &head.transfer), ("head", &"viridis".into()));
        assert_eq!(head.open().unwrap().volume.grid().dims(), [64; 3]);
        for wrong in ["nothing-like-this", "head:many", ""] {
            assert!(DataSet::parse(wrong).unwrap_err().to_string().contains("data list"), "{wrong}");
        }
    }
}
