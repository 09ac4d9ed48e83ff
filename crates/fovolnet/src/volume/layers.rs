//! Further volumes of a scene, and volumes whose voxels are colours.

use super::open::{OpenLayer, OpenVolume, open_single_volume};
use crate::settings::{ChannelChoice, ComponentChoice, LayerChoice};
use crate::{Error, Result, TransferChoice, VolumeSettings};
use fovol_core::{Alignment, MOST_VOLUMES, Volume};
use std::sync::Arc;

/// Colour maps of further volumes that have no colours of their own, in order.
const MAPS: [&str; MOST_VOLUMES - 1] = ["inferno", "viridis", "cividis"];

/// Opens `source` with everything that is shown with it: further channels of the file, overlays, and colours of voxels.
///
/// A file whose channels have colours shows all of them, blended, unless `settings` choose some. Volumes of other dimensions are
/// resampled to the voxels of the first. See [`super::open_single_volume`] for what is read.
///
/// # Errors
/// A file that is missing, unreadable or invalid; more than four volumes; volumes that do not overlap.
pub fn open_volume(source: &str, settings: &VolumeSettings) -> Result<OpenVolume> {
    let overlays = settings.overlay.as_deref().unwrap_or_default();
    let alone = VolumeSettings { overlay: None, ..settings.clone() };
    let mut first = with_colours(open_single_volume(source, &alone)?, settings)?;
    let shown = shown_channels(&first.volume, settings);
    for channel in shown.iter().skip(1) {
        let read = VolumeSettings { channel: Some((*channel).into()), ..alone.clone() };
        let opened = open_single_volume(source, &read)?;
        first.layers.push(OpenLayer { opened, transfer_function: TransferChoice::Auto });
    }
    for (number, overlay) in overlays.iter().enumerate() {
        first.check_room(|| format!("leave out --overlay {overlay}"))?;
        let layer = opened_layer(overlay, &first, number)?;
        first.layers.push(layer);
    }
    Ok(first)
}

impl OpenVolume {
    /// Shows `opened` and its layers, too, on the box of this volume, resampled to its voxels where their numbers differ.
    ///
    /// # Errors
    /// More than four volumes in all; volumes that do not overlap.
    pub fn with_layer(mut self, opened: Self, transfer_function: TransferChoice) -> Result<Self> {
        let alone = Self { layers: Vec::new(), ..opened.clone() };
        let own = OpenLayer { opened: alone, transfer_function };
        for layer in std::iter::once(own).chain(opened.layers) {
            self.check_room(|| format!("leave out {}", layer.opened.source))?;
            let layer = laid_over(layer, &self, self.layers.len())?;
            self.layers.push(layer);
        }
        Ok(self)
    }

    /// Whether the volume says which colours it has: those of its file, of labels, or of a procedural volume.
    pub fn has_own_colours(&self) -> bool {
        let volume = &self.volume;
        self.colours.is_some()
            || self.procedural.is_some()
            || volume.is_label_map()
            || volume.contents().displays.iter().any(|display| display.colour.is_some())
    }

    /// Checks that one volume more may be shown; `remedy` says how to show fewer.
    fn check_room(&self, remedy: impl FnOnce() -> String) -> Result<()> {
        if self.layers.len() + 1 < MOST_VOLUMES {
            return Ok(());
        }
        let remedy = remedy();
        Err(Error::Setting(format!(
            "at most {MOST_VOLUMES} volumes and channels are shown together; {remedy}"
        )))
    }
}

/// Opens `overlay` on the voxels of `first`; it is overlay `number`, from 0 on.
fn opened_layer(overlay: &LayerChoice, first: &OpenVolume, number: usize) -> Result<OpenLayer> {
    let opened = open_single_volume(&overlay.source, &VolumeSettings::default())?;
    let opened = with_colours(opened, &VolumeSettings::default())?;
    let transfer_function = overlay.transfer_function.clone();
    laid_over(OpenLayer { opened, transfer_function }, first, number)
}

/// Lays `layer` over the voxels of `first`; it is layer `number`, from 0 on.
fn laid_over(layer: OpenLayer, first: &OpenVolume, number: usize) -> Result<OpenLayer> {
    let OpenLayer { opened, transfer_function } = layer;
    let alignment = opened.volume.alignment(&first.volume);
    let resample = |volume: &Volume| {
        volume.resampled(&first.volume).map_err(|error| {
            Error::Setting(format!("{} cannot be laid over {}: {error}", opened.source, first.source))
        })
    };
    let colours = match &opened.colours {
        Some([r, g, b]) => Some([resample(r)?.into(), resample(g)?.into(), resample(b)?.into()]),
        None => None,
    };
    let resampled = resample(&opened.volume)?;
    let resampled = match alignment {
        Alignment::Same => resampled,
        Alignment::Space => resampled.with_note(format!(
            "is resampled to the voxels of {}, by the positions in both files",
            first.source
        )),
        Alignment::Box => resampled.with_note(format!(
            "is stretched to the box of {}: the files have no positions in common",
            first.source
        )),
    };
    let transfer_function = match transfer_function {
        TransferChoice::Auto if !opened.has_own_colours() => {
            TransferChoice::Named(MAPS[number.min(MAPS.len() - 1)].into())
        }
        chosen => chosen,
    };
    let opened = OpenVolume { volume: Arc::new(resampled), colours, ..opened };
    Ok(OpenLayer { opened, transfer_function })
}

/// Channels of the file of `volume` that are shown, the one that `volume` holds first.
fn shown_channels(volume: &Volume, settings: &VolumeSettings) -> Vec<usize> {
    let contents = volume.contents();
    if let Some(ChannelChoice::Several(chosen)) = &settings.channel {
        return chosen.clone();
    }
    let is_shown = |channel: &usize| {
        let display = contents.displays.get(*channel);
        display.is_some_and(|display| display.colour.is_some() && !display.is_hidden)
    };
    let coloured: Vec<usize> = (0..contents.channels.len()).filter(is_shown).collect();
    if settings.channel.is_some() || !coloured.contains(&contents.channel) {
        return vec![contents.channel];
    }
    let others = coloured.into_iter().filter(|channel| *channel != contents.channel);
    std::iter::once(contents.channel).chain(others).take(MOST_VOLUMES).collect()
}

/// `opened` with the colours of its voxels, if they are shown as such.
fn with_colours(opened: OpenVolume, settings: &VolumeSettings) -> Result<OpenVolume> {
    let volume = &opened.volume;
    let are_colours = match settings.component {
        Some(ComponentChoice::Number(_)) => return Ok(opened),
        Some(ComponentChoice::Colours(_)) => true,
        None => volume.contents().are_colours,
    };
    if !are_colours {
        return Ok(opened);
    }
    if !volume.may_be_colours() {
        return match settings.component {
            Some(_) => Err(Error::Setting(format!(
                "{} has {} components, and colours have 3 or 4; leave out --component rgb",
                opened.source,
                volume.components()
            ))),
            None => Ok(opened),
        };
    }
    let (colours, opacity) = volume.colours()?;
    Ok(OpenVolume { volume: Arc::new(opacity), colours: Some(colours), ..opened })
}
