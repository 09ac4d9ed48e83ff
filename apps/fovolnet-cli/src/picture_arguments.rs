use fovolnet::{RenderOverrides, SpeedSettings, VolumeSettings};

/// Flags of a picture of a volume, which `render` and `bench` share.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct PictureArguments {
    #[command(flatten)]
    pub read: VolumeSettings,
    #[command(flatten)]
    pub settings: RenderOverrides,
    #[command(flatten)]
    pub speed: SpeedSettings,
}
