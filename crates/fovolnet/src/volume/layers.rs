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
        if first.layers.len() + 1 >= MOST_VOLUMES {
            return Err(Error::Setting(format!(
                "at most {MOST_VOLUMES} volumes and channels are shown together; leave out --overlay {overlay}"
            )));
        }
        let layer = overlaid(overlay, &first, number)?;
        first.layers.push(layer);
    }
    Ok(first)
}

/// Opens `overlay` on the voxels of `first`; it is overlay `number`, from 0 on.
fn overlaid(overlay: &LayerChoice, first: &OpenVolume, number: usize) -> Result<OpenLayer> {
    let opened = open_single_volume(&overlay.source, &VolumeSettings::default())?;
    let alignment = opened.volume.alignment(&first.volume);
    let resampled = opened.volume.resampled(&first.volume).map_err(|error| {
        Error::Setting(format!("{} cannot be laid over {}: {error}", opened.source, first.source))
    })?;
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
    let own = opened.procedural.is_some()
        || resampled.is_label_map()
        || resampled.contents().displays.iter().any(|display| display.colour.is_some());
    let transfer_function = match &overlay.transfer_function {
        TransferChoice::Auto if !own => TransferChoice::Named(MAPS[number.min(MAPS.len() - 1)].into()),
        chosen => chosen.clone(),
    };
    let opened =
        with_colours(OpenVolume { volume: Arc::new(resampled), ..opened }, &VolumeSettings::default())?;
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
