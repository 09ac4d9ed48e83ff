//! Playback of the time points of a volume.

use crate::session::opened::Opened;
use fovolnet::VolumeSettings;
use fovolnet::core::Dtype;

/// Playback of time points. While one is shown, the next is read.
#[derive(Debug, Default)]
pub struct TimePlayback {
    /// Whether it plays.
    pub plays: bool,
    /// Whether a picture of the open volume was shown.
    has_picture: bool,
}

impl TimePlayback {
    /// Notes that another volume was opened.
    pub fn opened(&mut self) {
        self.has_picture = false;
    }

    /// Notes that a picture was shown.
    pub fn shown(&mut self) {
        self.has_picture = true;
    }

    /// Settings to read the next time point of `opened`, once its own is shown. After the last comes the first.
    pub fn next(&mut self, opened: &mut Opened) -> Option<VolumeSettings> {
        let contents = opened.volume.volume.contents();
        if !self.plays || contents.times < 2 {
            self.plays = false;
            return None;
        }
        if !self.has_picture {
            return None;
        }
        let next = (contents.time + 1) % contents.times;
        // Colours keep their meaning from one time point to the next.
        let transfer = opened.transfer().clone();
        if opened.document.settings().tf.is_none() {
            opened.set_transfer(&transfer);
        }
        let mut read = opened.document.session().read.clone();
        let volume = &opened.volume;
        if read.shown_range().is_none() && volume.volume.dtype() != Dtype::U8 && volume.colours.is_none() {
            read.range = Some(volume.volume.range());
        }
        read.time = Some(next.into());
        Some(read)
    }
}
