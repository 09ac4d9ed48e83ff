//! The range that a file gives to the shown channel.

use fovol_core::Volume;

/// Shows `volume` in the window of its channel, with a note, if the file declares one and the values are no labels.
pub fn windowed(volume: Volume) -> Volume {
    let contents = volume.contents();
    let window = contents.displays.get(contents.channel).and_then(|display| display.window);
    let Some([low, high]) = window.filter(|_| !contents.are_labels) else { return volume };
    match volume.clone().with_range([low, high]) {
        Ok(volume) => volume.with_note(format!(
            "the window {low} to {high} that it gives to the channel is shown; --range LO,HI sets another"
        )),
        Err(_) => volume,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::{ChannelDisplay, Contents, Grid};

    #[test]
    fn windows_become_ranges() {
        let volume = Volume::from_values(Grid::new([2, 1, 1], [1.0; 3]).unwrap(), vec![0u16, 9]).unwrap();
        let display = ChannelDisplay { window: Some([2.0, 5.0]), ..ChannelDisplay::default() };
        let contents = Contents { displays: vec![display], ..Contents::default() };
        let shown = windowed(volume.clone().with_contents(contents.clone()));
        assert!(shown.range() == [2.0, 5.0] && shown.notes().len() == 1);
        let labels = Contents { are_labels: true, ..contents };
        assert!(!windowed(volume.with_contents(labels)).range_is_chosen());
    }
}
