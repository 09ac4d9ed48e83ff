//! Transfer functions of channels whose file says how they look.

use fovol_core::{ControlPoint, TransferFunction, Volume};

/// Opacity per voxel at the upper end of the window, and in its middle: what is dim stays translucent.
const OPACITY: f64 = 0.9;
const MIDDLE: f64 = 0.1;

/// The colour that the file gives the channel of `volume`, ever more opaque over the window that it gives. `None` if it gives
/// no colour.
pub fn channel_colour(volume: &Volume) -> Option<TransferFunction> {
    let contents = volume.contents();
    let display = contents.displays.get(contents.channel)?;
    let colour = display.colour?.map(|channel| f64::from(channel) / 255.0);
    let points = [(0.0, 0.0), (0.5, MIDDLE), (1.0, OPACITY)];
    let points = points.map(|(value, opacity)| ControlPoint::new(value, colour, opacity));
    TransferFunction::new(points.to_vec()).ok()?.with_range(display.window).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::{ChannelDisplay, Contents, Grid};

    #[test]
    fn channels_have_the_colours_and_windows_of_their_file() {
        let grid = Grid::new([2; 3], [1.0; 3]).unwrap();
        let display =
            ChannelDisplay { colour: Some([255, 0, 51]), window: Some([0.0, 127.5]), is_hidden: false };
        let contents = Contents { displays: vec![ChannelDisplay::default(), display], ..Contents::default() };
        let volume = Volume::from_values(grid, vec![0u8; 8]).unwrap();
        assert!(channel_colour(&volume.clone().with_contents(contents.clone())).is_none());
        let volume = volume.with_contents(Contents { channel: 1, ..contents });
        let transfer = channel_colour(&volume).unwrap().over(volume.range());
        let [r, g, b, a] = transfer.evaluate(0.5);
        assert!((r - 1.0).abs() < 1e-9 && g == 0.0 && (b - 0.2).abs() < 1e-9 && (a - OPACITY).abs() < 1e-9);
    }
}
